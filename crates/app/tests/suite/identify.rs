//! `devices --identify` against every twin of the table: each is found by its own driver, nothing is set, nothing
//! moves.

#![cfg(unix)]

use std::sync::Arc;

use isolux_app::files::Overwrite;
use isolux_app::front_end::progress::Silent;
use isolux_app::init;
use isolux_app::instruments::{catalogue, check, identify, session};
use isolux_darkroom::Darkroom;
use isolux_transport::{Links, SystemLinks};
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use isolux_virtual::{AxisName, Instrument, VirtualRoom};
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Barrier;

/// Asks the twin at a link of the system, from another thread, as another program would.
fn requested(twin: &'static TwinKind, how: Offer) -> identify::PortReport {
    let requested = session::run(false, async {
        let mut choice = Choice::default();
        choice.choose(twin.instrument, twin.driver).unwrap();
        let room = VirtualRoom::open_with(Darkroom::default(), &choice);
        let (outlets, _serving) = offer(&room, &[twin.instrument], how).await.unwrap();
        let port = outlets[0].address.clone();
        let state = || {
            room.with_world(|world, now_s| {
                let place = AxisName::ALL.map(|name| world.axis(name).position(now_s));
                (place, world.switches())
            })
        };
        let before = state();
        let asking = tokio::task::spawn_blocking(move || identify::identify(&[port], &Silent));
        let requested = asking.await.unwrap()?.remove(0);
        assert_eq!(state(), before, "{}: nothing moves", twin.driver);
        Ok(requested)
    });
    requested.unwrap()
}

/// At once, because all wait for answers that do not come.
#[test]
fn every_twin_is_found_by_its_driver_and_by_no_other_language() {
    let known = |name: &str| catalogue::drivers().find(|driver| driver.name == name).unwrap();
    let modbus = ["oriental-az", "modbus-lux"];
    std::thread::scope(|scope| {
        scope.spawn(a_pseudo_terminal_is_asked_and_its_settings_are_stated);
        for twin in TWINS {
            if known(twin.driver).identify.is_empty() {
                continue;
            }
            scope.spawn(move || {
                let found = requested(twin, Offer::Tcp { port: 0 });
                assert_eq!(found.error, None, "{found:?}");
                let drivers: Vec<&str> = found.found.iter().map(|answered| answered.driver).collect();
                assert!(drivers.contains(&twin.driver), "{}: {found:?}", twin.driver);
                let alike =
                    |name: &&str| *name == twin.driver || modbus.contains(name) && modbus.contains(&twin.driver);
                assert!(drivers.iter().all(alike), "{}: {found:?}", twin.driver);
            });
        }
    });
}

fn a_pseudo_terminal_is_asked_and_its_settings_are_stated() {
    let twin = TWINS.iter().find(|twin| twin.driver == "konica-t10a").unwrap();
    let found = requested(twin, Offer::Pty);
    let [answered] = &found.found[..] else {
        panic!("{found:?}")
    };
    assert_eq!((answered.driver, answered.line.as_str()), ("konica-t10a", "9600 7E1"));
    assert!(
        answered.says.contains("T-10A") && answered.says.contains("PC mode"),
        "{answered:?}"
    );
    assert!(
        found.tried.last().unwrap().starts_with("9600 7E1: "),
        "{:?}",
        found.tried
    );
}

/// Each bridge passes nothing on before both are connected to.
#[test]
fn ports_are_asked_side_by_side_and_reported_in_their_order() {
    let requested = session::run(false, async {
        let both = Arc::new(Barrier::new(2));
        let (mut ports, mut kept) = (Vec::new(), Vec::new());
        for instrument in [Instrument::Luxmeter, Instrument::Axes] {
            let room = VirtualRoom::open(Darkroom::default());
            let (outlets, serving) = offer(&room, &[instrument], Offer::Tcp { port: 0 }).await.unwrap();
            let (twin, both) = (outlets[0].address.replace("tcp://", ""), Arc::clone(&both));
            let bridge = TcpListener::bind("127.0.0.1:0").await.unwrap();
            ports.push(format!("tcp://{}", bridge.local_addr().unwrap()));
            kept.push((room, serving));
            tokio::spawn(async move {
                for connection in 0.. {
                    let (mut near, _) = bridge.accept().await.unwrap();
                    if connection == 0 {
                        both.wait().await;
                    }
                    let mut far = TcpStream::connect(&twin).await.unwrap();
                    tokio::spawn(async move { copy_bidirectional(&mut near, &mut far).await });
                }
            });
        }
        let asking = tokio::task::spawn_blocking(move || identify::identify(&ports, &Silent));
        asking.await.unwrap()
    });
    let found: Vec<Vec<&str>> = requested
        .as_ref()
        .unwrap()
        .iter()
        .map(|port| port.found.iter().map(|found| found.driver).collect())
        .collect();
    assert_eq!(found, [["konica-t10a"], ["zaber"]], "{requested:?}");
}

#[test]
fn a_device_is_asked_by_one_name_after_the_other() {
    let keep = tempfile::tempdir().unwrap();
    let link = keep.path().join("axes");
    let requested = session::run(false, async {
        let room = VirtualRoom::open(Darkroom::default());
        let (outlets, _serving) = offer(&room, &[Instrument::Axes], Offer::Pty).await.unwrap();
        let port = outlets[0].address.clone();
        std::os::unix::fs::symlink(&port, &link).unwrap();
        let names = [port, link.to_str().unwrap().to_owned()];
        let asking = tokio::task::spawn_blocking(move || identify::identify(&names, &Silent));
        asking.await.unwrap()
    });
    for port in requested.unwrap() {
        assert_eq!(port.error, None, "{port:?}");
        assert_eq!(port.found[0].driver, "zaber", "{port:?}");
    }
}

#[test]
fn what_cannot_be_asked_says_why() {
    let stated = |port: &str| {
        identify::identify(&[port.to_owned()], &Silent)
            .unwrap()
            .remove(0)
            .error
            .unwrap()
    };
    assert!(
        stated("/dev/ttyNONE7").contains("isolux devices"),
        "{}",
        stated("/dev/ttyNONE7")
    );
    assert!(stated("usb:serial=1").contains("by their ids"));
    assert!(stated("modbus-tcp://127.0.0.1:502").contains("serial ports"));
}

#[test]
fn a_port_that_somebody_has_is_not_asked() {
    let requested = session::run(false, async {
        let room = VirtualRoom::open(Darkroom::default());
        let (outlets, _serving) = offer(&room, &[Instrument::Luxmeter], Offer::Pty).await.unwrap();
        let port = outlets[0].address.clone();
        let theirs = SystemLinks::default();
        let line = room.twin(Instrument::Luxmeter).unwrap().line;
        let _held = theirs.open(&port, line).await.unwrap();
        let asking = tokio::task::spawn_blocking(move || identify::identify(&[port], &Silent));
        Ok(asking.await.unwrap()?.remove(0))
    });
    let requested = requested.unwrap();
    let error = requested.error.unwrap();
    let pid = format!("{}", std::process::id());
    assert!(
        error.contains(&pid) && requested.tried.is_empty(),
        "it names the process: {error}"
    );
}

#[test]
fn a_station_that_states_another_serial_number_is_told() {
    let keep = tempfile::tempdir().unwrap();
    let path = camino::Utf8PathBuf::try_from(keep.path().join("station.toml")).unwrap();
    let (text, calibration) = init::virtual_station(&Choice::default()).unwrap();
    std::fs::write(path.with_file_name("spectroradiometer.csv"), calibration.unwrap()).unwrap();
    let checked = |section: &str, serial: &str| {
        let stated = format!("[{section}]\nserial = {serial:?}\n");
        std::fs::write(&path, text.replacen(&format!("[{section}]\n"), &stated, 1)).unwrap();
        let report = check::run(&path, None, Overwrite::Never, None, &Silent).unwrap();
        let found = report.instruments.into_iter().find(|found| found.role == section);
        found.unwrap_or_else(|| panic!("{section}"))
    };
    let seed = Darkroom::built_in().unwrap().seed;
    for (section, right) in [
        ("axis.c", format!("{}", 900_000 + seed % 100_000)),
        ("spectroradiometer", format!("USB2+V{seed:05}")),
    ] {
        let found = checked(section, &right);
        assert!(found.ok, "{found:?}");
        let found = checked(section, "4711");
        let error = found.error.unwrap();
        assert!(!found.ok && error.contains("4711") && error.contains(&right), "{error}");
        assert!(error.starts_with(&format!("{section}.serial: ")), "{error}");
    }
    // A T-10A has no word for its number.
    let found = checked("luxmeter", "4711");
    assert!(!found.ok && found.error.unwrap().contains("remove the key"));
}
