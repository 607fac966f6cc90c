//! `virtual darkroom|axis|luxmeter|spectroradiometer|powermeter|supply|oscilloscope`: the twins as a process, for other
//! programs to talk to.

use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::{Darkroom, Room};
use isolux_virtual::fault::Order;
use isolux_virtual::outlet::{self, Offer, Outlet};
use isolux_virtual::station::{
    CALIBRATION_FILE, RESPONSIVITY_FILE, calibration, in_memory, responsivity, station, station_in, twin,
};
use isolux_virtual::{Instrument, Serving, Switches, VirtualRoom};

use crate::darkroom::capture;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::init::Instruments;
use crate::system::signals::OnSignals;
use crate::{Failure, FailureKind};

/// Which twins, and how.
#[derive(Debug, Clone)]
pub struct Options {
    /// `darkroom.toml`; none: the built-in darkroom.
    pub darkroom: Option<Utf8PathBuf>,
    /// The twins to serve.
    pub twins: Twins,
    /// The drivers that they answer.
    pub instruments: Instruments,
    /// TCP port on the loopback address, 0 for any; none: a pty each.
    pub tcp_port: Option<u16>,
    /// Port on the loopback address for the spectroradiometer as a USB device over USB/IP, 0 for any; none: as the
    /// others.
    pub usbip_port: Option<u16>,
    /// Where to write a station file for them.
    pub station_out: Option<Utf8PathBuf>,
    /// Whether an existing station file may be replaced.
    pub overwrite: Overwrite,
    /// Take faults on standard input, one a line, while the twins serve.
    pub faults: bool,
    /// End after this time by itself.
    pub lasts: Option<Duration>,
}

/// The twins to serve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Twins {
    /// All instruments of the room.
    All,
    /// The axes and the switches on their controller.
    Axes,
    /// The lux meter alone, in lit air.
    LuxMeter,
    /// The spectroradiometer alone, in lit air.
    Spectroradiometer,
    /// The power meter alone, with the lamp on.
    PowerMeter,
    /// The lamp's supply alone.
    Supply,
    /// The oscilloscope alone, with the lamp on.
    Oscilloscope,
}

/// One twin that can be reached.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Reachable {
    /// `axes`, `luxmeter`, `spectroradiometer`, `powermeter`, `supply`, `oscilloscope`.
    pub instrument: &'static str,
    /// What a station's `open` names after the driver.
    pub address: String,
    /// A whole `open` for it.
    pub open: String,
    /// What makes a USB device of it on this computer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attach: Option<String>,
}

/// Serves the twins until `lasts` is over or a signal asks for the end. `ready` gets their addresses once, before
/// any byte.
///
/// # Errors
/// Bad input (exit 2) with file and line; exit 3 when the system refuses ports or ptys; exit 130 when interrupted.
pub fn serve(
    options: &Options,
    progress: &dyn Progress,
    ready: impl FnOnce(&[Reachable]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let document = match &options.darkroom {
        Some(path) => capture::document(path, progress)?,
        None => Darkroom::built_in().map_err(Failure::bad_input)?,
    };
    let mut choice = options.instruments.choice()?;
    // What a room has only where it is chosen is chosen by asking for it alone.
    match options.twins {
        Twins::PowerMeter => choice.add(Instrument::Powermeter),
        Twins::Supply => choice.add(Instrument::Supply),
        Twins::Oscilloscope => choice.add(Instrument::Oscilloscope),
        Twins::All | Twins::Axes | Twins::LuxMeter | Twins::Spectroradiometer => {}
    }
    if let Some(path) = &options.station_out {
        files::refuse_existing(path, options.overwrite)?;
        refuse_existing_beside(path, options.overwrite)?;
    }
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(Failure::instrument)?;
    let signals = OnSignals::listen()?;
    runtime.block_on(async {
        let room = VirtualRoom::open_with(document.clone(), &choice);
        let mut instruments: Vec<Instrument> = match options.twins {
            Twins::All => room.instruments().collect(),
            Twins::Axes => vec![Instrument::Axes, Instrument::Outputs],
            Twins::LuxMeter => vec![Instrument::Luxmeter],
            Twins::Spectroradiometer => vec![Instrument::Spectroradiometer],
            Twins::PowerMeter => vec![Instrument::Powermeter],
            Twins::Supply => vec![Instrument::Supply],
            Twins::Oscilloscope => vec![Instrument::Oscilloscope],
        };
        if matches!(
            options.twins,
            Twins::LuxMeter | Twins::Spectroradiometer | Twins::PowerMeter | Twins::Oscilloscope
        ) {
            // Nobody is there to switch the lamp on.
            let illuminated = Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            };
            room.with_world(|world, now_s| world.set_switches(illuminated, now_s));
        }
        let (usb, mut attach) = match options.usbip_port {
            Some(port) => {
                let (outlet, port, serving) = usb(&room, port).await?;
                instruments.retain(|instrument| *instrument != outlet.instrument);
                let attach = format!("usbip --tcp-port {port} attach --remote 127.0.0.1 --busid 1-1");
                (Some((outlet, serving)), Some(attach))
            }
            None => (None, None),
        };
        let offer = options.tcp_port.map_or(Offer::Pty, |port| Offer::Tcp { port });
        let (mut outlets, _serving) = outlet::offer(&room, &instruments, offer).await.map_err(|error| {
            Failure::instrument(format!("cannot offer the twins: {error}"))
                .help("try --tcp 0 for any free port on the loopback address")
        })?;
        let _usb_serving = usb.map(|(outlet, serving)| {
            outlets.push(outlet);
            serving
        });
        if let Some(path) = &options.station_out {
            write_curves(path, document.clone(), &outlets, options.overwrite)?;
            files::write(path, station(&document, &outlets).as_bytes(), options.overwrite)?;
        }
        let mut reachables: Vec<Reachable> = outlets.iter().map(reachable).collect();
        if let Some(usb) = reachables.last_mut() {
            usb.attach = attach.take();
        }
        ready(&reachables)?;
        let over = async {
            match options.lasts {
                Some(lasts) => tokio::time::sleep(lasts).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            () = over => Ok(()),
            () = orders(&room, options.faults, progress) => Ok(()),
            _ = signals.cancelled() => Err(Failure {
                kind: FailureKind::Interrupted,
                message: "interrupted, the twins have gone".to_owned(),
                help: None,
            }),
        }
    })
}

/// Carries out the faults that come on standard input where they are asked for; never ends, whatever comes there.
async fn orders(room: &VirtualRoom, requested: bool, progress: &dyn Progress) {
    if requested {
        let (sender, mut lines) = tokio::sync::mpsc::unbounded_channel();
        // A thread of its own, which the end of the process ends: nothing can wake it from reading.
        std::thread::spawn(move || {
            for line in std::io::stdin().lines() {
                let Ok(line) = line else { return };
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        while let Some(line) = lines.recv().await {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let stated = match line.parse::<Order>() {
                Ok(order) if room.order(&order) => format!("{:.1} s: {line}", room.now_s()),
                Ok(_) => format!("{line}: this room has no such instrument"),
                Err(error) => error.to_string(),
            };
            progress.event(Event::Note(&stated));
        }
    }
    std::future::pending::<()>().await;
}

/// The spectroradiometer as a USB device.
async fn usb(room: &VirtualRoom, port: u16) -> Result<(Outlet, u16, Serving), Failure> {
    match isolux_virtual::usb::offer(room, Instrument::Spectroradiometer, port).await {
        Ok(Some(offered)) => Ok(offered),
        Ok(None) => Err(
            Failure::bad_input("--usbip: no instrument of this room has a USB connector of its own")
                .help("with --spectroradiometer ocean-ooi or ocean-obp it has one"),
        ),
        Err(error) => Err(
            Failure::instrument(format!("cannot offer the device over USB/IP: {error}"))
                .help("try --usbip 0 for any free port on the loopback address"),
        ),
    }
}

/// Writes a station file for the room in memory of whatever process opens it, in virtual time: nothing is served.
///
/// # Errors
/// Bad input (exit 2) with file and line, or where the station could not name the room; exit 3 when the disk refuses.
pub fn write_in_memory(
    darkroom: Option<&Utf8Path>,
    instruments: &Instruments,
    out: &Utf8Path,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let document = match darkroom {
        Some(path) => capture::document(path, progress)?,
        None => Darkroom::built_in().map_err(Failure::bad_input)?,
    };
    let outlets = in_memory(&instruments.choice()?);
    files::refuse_existing(out, overwrite)?;
    refuse_existing_beside(out, overwrite)?;
    // A station names its room from where it stands itself.
    let folder = |path: &Utf8Path| {
        path.parent()
            .filter(|folder| !folder.as_str().is_empty())
            .map(Utf8Path::to_owned)
    };
    let named = match darkroom {
        None => None,
        Some(path) if folder(path) == folder(out) => path.file_name().map(str::to_owned),
        Some(path) => {
            let absolute = path
                .canonicalize_utf8()
                .map_err(|error| Failure::bad_input(format!("{path}: {error}")))?;
            Some(files::in_document(&absolute))
        }
    };
    let text = station_in(named.as_deref(), &document, &outlets);
    write_curves(out, document, &outlets, overwrite)?;
    files::write(out, text.as_bytes(), overwrite)
}

/// The files that a station may name, beside it.
fn refuse_existing_beside(station: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    let mut names = [CALIBRATION_FILE, RESPONSIVITY_FILE].into_iter();
    names.try_for_each(|name| files::refuse_existing(&station.with_file_name(name), overwrite))
}

/// Writes what the spectroradiometer among `outlets` needs beside the station, if it keeps no calibration of its own.
fn write_curves(
    station: &Utf8Path,
    document: Darkroom,
    outlets: &[Outlet],
    overwrite: Overwrite,
) -> Result<(), Failure> {
    let curves = [
        (RESPONSIVITY_FILE, responsivity(&document)),
        (CALIBRATION_FILE, calibration(&Room::new(document), outlets)),
    ];
    for (name, text) in curves {
        if let Some(text) = text {
            files::write(&station.with_file_name(name), text.as_bytes(), overwrite)?;
        }
    }
    Ok(())
}

fn reachable(outlet: &Outlet) -> Reachable {
    let Outlet {
        instrument,
        driver,
        address,
    } = outlet;
    let rest = twin(outlet)
        .and_then(|twin| twin.opens.first())
        .map_or("", |(_, rest)| rest);
    Reachable {
        instrument: instrument.name(),
        address: address.clone(),
        open: format!("{driver}:{address}{rest}"),
        attach: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front_end::progress::Silent;
    use isolux_record::Station;
    use isolux_virtual::twins::Choice;

    #[test]
    fn the_station_of_a_room_is_a_station() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
        let (darkroom, out) = (path.join("darkroom.toml"), path.join("station.toml"));
        std::fs::write(&darkroom, "[injected_effects]\ngamma_zero = { offset_deg = 0.2 }\n").unwrap();
        write_in_memory(
            Some(&darkroom),
            &Instruments::default(),
            &out,
            Overwrite::Never,
            &Silent,
        )
        .unwrap();
        let station = Station::load(&out).unwrap();
        assert_eq!(station.darkroom(), Some(Utf8Path::new("darkroom.toml")));
        assert!(crate::instruments::roles::is_virtual(&station));
        let calibration = isolux_record::document::read_text(&path.join(CALIBRATION_FILE)).unwrap();
        isolux_record::spectra::parse_calibration(&path, &calibration).unwrap();
        assert!(
            write_in_memory(
                Some(&darkroom),
                &Instruments::default(),
                &out,
                Overwrite::Never,
                &Silent
            )
            .is_err()
        );
        let text = station_in(None, &Darkroom::default(), &in_memory(&Choice::default()));
        assert_eq!(Station::parse(&out, &text).unwrap().darkroom(), None);
    }
}
