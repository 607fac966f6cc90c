//! Every twin of the table in place of the default one, in real time over a link of the system: it finds the
//! distribution that the default finds in virtual time. And what a scan makes of faults that are switched on while it
//! runs.
//!
//! The meters keep their pace, 2 s to 8 s a point, so the plan is short and all twins are scanned at once. By hand:
//! `ISOLUX_REAL_LINKS=60 cargo test -p isolux-app --test suite links -- --nocapture` takes as many points for each.

#![cfg(unix)]
#![expect(clippy::print_stdout, reason = "how long each scan took")]

mod unplugged;

use std::sync::Arc;
use std::time::{Duration, Instant};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_app::{Failure, init};
use isolux_darkroom::Darkroom;
use isolux_record::spectra::DarkSubtraction;
use isolux_record::{Plan, Quality, Role, Run};
use isolux_transport::{Links, SystemLinks};
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use isolux_virtual::{Instrument, Serving, VirtualRoom, station};
use tempfile::TempDir;

/// A room without injected effects, whose T-10A and Modbus meter integrate 20 ms, whose axes take little time, and
/// whose rail stands where the plan wants it.
const FAST: &str = "[bench]\ndistance_mm = 2000.0\n[injected_effects]\nonly = true\n[luxmeter]\nintegration_s = 0.02\n\
    [axis.c]\nspeed_deg_s = 45.0\naccel_deg_s2 = 400.0\n\
                    [axis.gamma]\nspeed_deg_s = 45.0\naccel_deg_s2 = 400.0\n";

/// So many points of light and a spectrum, and where there is time for it a reading behind the shutter.
fn plan(points: usize) -> Plan {
    let planes = if points > 6 { 2 } else { 1 };
    // A short way where every second counts.
    let end_deg = if points > 2 { 60.0 } else { 15.0 };
    let step = 2.0 * end_deg / (points as f64 / f64::from(planes) - 1.0).max(1.0);
    let block = |name: &str, rest: &str| format!("[[block]]\nname = \"{name}\"\n{rest}");
    let axis = "c_deg = 0\ngamma_deg = 0\n";
    let mut text = String::from("format = \"isolux-plan/1\"\n");
    let range = format!(
        "c_range = [0, {}, 90]\ngamma_range = [-{end_deg}, {end_deg}, {step}]\n",
        90 * (planes - 1)
    );
    text += &block("lit", &format!("kind = \"lit\"\n{range}distance_mm = 2000.0\n"));
    let spectrum = "kind = \"lit\"\ninstrument = \"spectroradiometer\"\nrepeats = 2\n";
    text += &block("spectrum", &format!("{spectrum}{axis}"));
    if points > 2 {
        text += &block("capped", &format!("kind = \"capped\"\n{axis}"));
    }
    Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap()
}

/// A MAVOLUX converts once in two seconds and takes 8 s a point: two of them fit into a minute.
fn affordable(twin: &TwinKind) -> usize {
    if twin.driver == "gossen-mavo-usb" { 2 } else { 3 }
}

/// The station of a lamp that is stable at once.
fn hasty(station: &str) -> String {
    let stable = "\n[lamp.stable]\nleast_s = 0.5\nwindow_s = 0.5\nspread_rel = 0.05\n\n[shutter]";
    station.replacen("\n[shutter]", stable, 1)
}

/// Scans with the instruments of `source` behind `links`.
async fn scanned(source: &StationFiles, links: Arc<dyn Links>, plan: &Plan) -> Result<Run, Failure> {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let mut devices = source.open(&Catalogue::new(links)).await?;
    let now = "2026-01-01T00:00:00Z".parse().unwrap();
    let job = ScanJob {
        source,
        plan,
        place: Place::take(Target::New(&path), false)?,
        force: None,
        operator: None,
        control: &Control::default(),
        progress: &Silent,
    };
    job.execute_on(&mut devices, None, now).await?;
    Ok(Run::read(&path).unwrap())
}

/// The scan in the memory of this process, in virtual time.
fn expected(plan: &Plan) -> Run {
    let run = session::run(true, async {
        let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
        let source = StationFiles::from_text(&hasty(&station), calibration.as_deref()).unwrap();
        let session = session::Session::in_room(Darkroom::parse(FAST).unwrap(), &Choice::default()).unwrap();
        scanned(&source, session.links.clone(), plan).await
    });
    run.unwrap()
}

/// The room with `twin` in it, its instruments on links of the system, and the station for them.
async fn served(twin: &TwinKind, how: Offer) -> (VirtualRoom, StationFiles, (Serving, TempDir)) {
    let mut choice = Choice::default();
    choice.choose(twin.instrument, twin.driver).unwrap();
    let document = Darkroom::parse(FAST).unwrap();
    let room = VirtualRoom::open_with(document.clone(), &choice);
    let instruments: Vec<Instrument> = room.instruments().collect();
    let (outlets, serving) = offer(&room, &instruments, how).await.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("fast.toml");
    let shipped = include_str!("../../../../../drivers/luxmeter/profiles/u32-thousandths.toml");
    std::fs::write(&profile, shipped.replace("_s = 1.0", "_s = 0.02")).unwrap();
    let text = station::station(&document, &outlets).replace("u32-thousandths", profile.to_str().unwrap());
    assert!(text.contains(&format!("\"{}:", twin.driver)), "{text}");
    let calibration = station::calibration(&isolux_darkroom::Room::new(document), &outlets);
    let source = StationFiles::from_text(&hasty(&text), calibration.as_deref()).unwrap();
    (room, source, (serving, folder))
}

/// C, γ, illuminance and digit of the points.
fn points(run: &Run) -> Vec<(f64, f64, f64, f64)> {
    let points = run.readings.rows.iter().filter(|row| row.role == Role::Point);
    let points = points.inspect(|row| assert_eq!(row.quality, Quality::Ok, "{row:?}"));
    let point = |row: &isolux_record::Reading| {
        let (lux, digit) = (row.illuminance_lx.unwrap(), row.digit_lx.unwrap());
        (row.c_target_deg, row.gamma_target_deg, lux, digit)
    };
    points.map(point).collect()
}

/// Irradiance of the spectrum from 430 nm to 670 nm.
fn irradiance_w_m2(run: &Run) -> f64 {
    let calibration = run.header.spectral.as_ref().unwrap();
    let spectrum = run.spectra[0].irradiance(calibration, DarkSubtraction::Spectrum);
    let pixels = run.spectra[0].pixels.iter().zip(spectrum.unwrap().irradiance_w_m2_nm);
    let points: Vec<(f64, f64)> = pixels
        .filter(|(pixel, _)| (430.0..670.0).contains(&pixel.wavelength_nm))
        .map(|(pixel, value)| (pixel.wavelength_nm, value.expect("not saturated")))
        .collect();
    let trapezia = points
        .windows(2)
        .map(|pair| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0));
    trapezia.sum()
}

/// Whether the two runs saw the same room.
fn same(twin: &TwinKind, found: &Run, expected: &Run) {
    let (here, there) = (points(found), points(expected));
    assert_eq!(here.len(), there.len(), "{}", twin.driver);
    for (here, there) in here.iter().zip(&there) {
        assert_eq!((here.0, here.1), (there.0, there.1), "{}", twin.driver);
        // The digits of both, their noise, and the lamp's first minutes.
        let allowed = here.3.max(there.3) + 0.01 * there.2;
        assert!(
            (here.2 - there.2).abs() <= allowed,
            "{}: {here:?} {there:?}",
            twin.driver
        );
    }
    let (found, expected) = (irradiance_w_m2(found), irradiance_w_m2(expected));
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{}: {found} {expected} W/m²",
        twin.driver
    );
}

#[test]
fn every_twin_scans_over_a_real_link() {
    let requested = std::env::var("ISOLUX_REAL_LINKS").ok();
    let requested: Option<usize> = requested.map(|text| text.parse().expect("a number of points"));
    std::thread::scope(|scope| {
        // No station has an oscilloscope: it records the light by itself.
        let of_stations = TWINS.iter().filter(|twin| twin.instrument != Instrument::Oscilloscope);
        let scans = of_stations.zip(0..).map(|(twin, number)| {
            let points = requested.unwrap_or_else(|| affordable(twin));
            // Half of them on pseudo-terminals, half over TCP.
            let (link, how) = match number % 2 {
                0 => ("pty", Offer::Pty),
                _ => ("TCP", Offer::Tcp { port: 0 }),
            };
            scope.spawn(move || {
                let plan = plan(points);
                let expected = expected(&plan);
                let begun = Instant::now();
                let found = session::run(false, async {
                    let (_room, source, _kept) = served(twin, how).await;
                    scanned(&source, Arc::new(SystemLinks::default()), &plan).await
                });
                let took = begun.elapsed();
                println!("{:16} over {link}: {points} points in {took:.1?}", twin.driver);
                same(twin, &found.unwrap(), &expected);
            })
        });
        let scans: Vec<_> = scans.collect();
        let failed = scans.into_iter().filter_map(|scan| scan.join().err()).count();
        assert_eq!(failed, 0, "of {} twins", TWINS.len());
    });
}

/// What a scan of the default instruments over TCP comes to when `faults` are ordered as it begins to read.
fn under(faults: &[&str]) -> Result<Run, Failure> {
    session::run(false, async {
        let (room, source, _kept) = served(&TWINS[0], Offer::Tcp { port: 0 }).await;
        let plan = plan(3);
        let orders = async {
            // The first reading is part of the warm-up: the scan has begun.
            while room.with_world(|world, now_s| world.lamp_time_s(now_s).is_none_or(|lit_s| lit_s < 3.0)) {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
            for fault in faults {
                assert!(room.order(&fault.parse().unwrap()), "{fault}");
            }
            std::future::pending::<()>().await;
        };
        tokio::select! {
            () = orders => unreachable!("it never ends"),
            run = scanned(&source, Arc::new(SystemLinks::default()), &plan) => run,
        }
    })
}

#[test]
fn a_scan_survives_the_faults_of_a_link_and_reports_those_of_an_instrument() {
    let plan = plan(3);
    let expected = expected(&plan);
    // (faults, a word of the error message; none where the scan must survive with right values)
    let cases: [(&[&str], Option<&str>); 7] = [
        (
            &["luxmeter late delay_s=0.3 for_s=60", "axes late delay_s=0.05 for_s=60"],
            None,
        ),
        (&["luxmeter silent", "axes silent", "spectroradiometer silent"], None),
        (
            &[
                "luxmeter flip_bit probability=0.2 for_s=60",
                "axes flip_bit probability=0.1 for_s=60",
                "luxmeter drop_byte probability=0.1 for_s=60",
            ],
            None,
        ),
        (&["luxmeter disconnect"], Some("luxmeter")),
        (&["axes stall"], Some("stall")),
        (&["axes alarm"], Some("FD")),
        (&["luxmeter saturate"], Some("over range")),
    ];
    std::thread::scope(|scope| {
        let scans: Vec<_> = cases
            .iter()
            .map(|(faults, word)| {
                let expected = &expected;
                scope.spawn(move || match (under(faults), word) {
                    (Ok(run), None) => same(&TWINS[0], &run, expected),
                    (Ok(_), Some(word)) => panic!("{faults:?}: no {word}"),
                    (Err(failure), word) => {
                        println!("{faults:?}: {failure:?}");
                        let word = word.unwrap_or("a scan that survives");
                        assert!(format!("{failure:?}").contains(word), "{faults:?}: {word}: {failure:?}");
                    }
                })
            })
            .collect();
        let failed = scans.into_iter().filter_map(|scan| scan.join().err()).count();
        assert_eq!(failed, 0, "of {} cases", cases.len());
    });
}
