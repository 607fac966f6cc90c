//! Oriental Motor drives and a Modbus lux meter scan the virtual room in real time, over TCP and a pseudo-terminal, and find
//! what the default instruments find in virtual time.

#![cfg(unix)]

use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::bench::Source;
use isolux_app::catalogue::Catalogue;
use isolux_app::progress::Silent;
use isolux_app::scan::{self, Place, Target};
use isolux_app::{init, stage};
use isolux_darkroom::Darkroom;
use isolux_record::{Plan, Quality, Role, Run};
use isolux_scan::Cancel;
use isolux_transport::{Links, SystemLinks};
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, VirtualRoom, station};

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 90]
gamma_deg = [-60, -30, 0, 30, 60]
distance_mm = 2000.0
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 2
"#;

/// A room without flaws, whose meter integrates 20 ms, whose axes take little time, and whose rail stands where the plan wants it.
const FAST: &str = "[bench]\ndistance_mm = 2000.0\n[flaws]\nonly = true\n[luxmeter]\nintegration_s = 0.02\n[axis.c]\nspeed_deg_s = 360.0\naccel_deg_s2 = 3600.0\n\
                    [axis.gamma]\nspeed_deg_s = 360.0\naccel_deg_s2 = 3600.0\n";

/// The station of a lamp that is stable at once.
fn hasty(station: &str) -> String {
    let stable = "\n[lamp.stable]\nleast_s = 0.5\nwindow_s = 0.5\nspread_rel = 0.05\n\n[shutter]";
    station.replacen("\n[shutter]", stable, 1)
}

/// Scans with the instruments of `source` behind `links`.
async fn scanned(source: &Source, links: Arc<dyn Links>) -> Run {
    let plan = Plan::parse(Utf8Path::new("plan.toml"), PLAN).unwrap();
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let mut devices = source.open(&Catalogue::new(links)).await.unwrap();
    let now = "2026-01-01T00:00:00Z".parse().unwrap();
    let place = Place::take(Target::New(&path), false).unwrap();
    scan::on(
        source,
        &mut devices,
        &plan,
        place,
        None,
        None,
        &Cancel::new(),
        now,
        &Silent,
    )
    .await
    .unwrap();
    Run::read(&path).unwrap()
}

/// C, γ and illuminance of the points.
fn points(run: &Run) -> Vec<(f64, f64, f64)> {
    let points = run.readings.rows.iter().filter(|row| row.role == Role::Point);
    let points = points.inspect(|row| assert_eq!(row.quality, Quality::Ok, "{row:?}"));
    let point = |row: &isolux_record::Reading| (row.c_target_deg, row.gamma_target_deg, row.illuminance_lx.unwrap());
    points.map(point).collect()
}

#[test]
fn modbus_instruments_scan_over_real_links() {
    let expected = stage::play(true, async {
        let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
        let source = Source::from_text(&hasty(&station), calibration.as_deref()).unwrap();
        let stage = stage::Stage::in_room(Darkroom::parse(FAST).unwrap(), &Choice::default()).unwrap();
        Ok(scanned(&source, stage.links.clone()).await)
    });
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("fast.toml");
    let shipped = include_str!("../../../drivers/luxmeter/profiles/u32-thousandths.toml");
    std::fs::write(&profile, shipped.replace("_s = 1.0", "_s = 0.02")).unwrap();
    let found = stage::play(false, async {
        let mut choice = Choice::default();
        choice.choose(Instrument::Axes, "oriental-az").unwrap();
        choice.choose(Instrument::Luxmeter, "modbus-lux").unwrap();
        let document = Darkroom::parse(FAST).unwrap();
        let room = VirtualRoom::open_with(document.clone(), &choice);
        let axes = [Instrument::Axes, Instrument::Outputs];
        let (mut outlets, _tcp) = offer(&room, &axes, Offer::Tcp { port: 0 }).await.unwrap();
        let (meter, _pty) = offer(&room, &[Instrument::Luxmeter], Offer::Pty).await.unwrap();
        outlets.extend(meter);
        let station = station::station(&document, &outlets);
        assert!(station.contains("oriental-az:tcp://127.0.0.1:") && station.contains("modbus-lux:/dev/"));
        let station = hasty(&station).replace("u32-thousandths", profile.to_str().unwrap());
        let source = Source::from_text(&station, None).unwrap();
        Ok(scanned(&source, Arc::new(SystemLinks::default())).await)
    });
    let (expected, found) = (points(&expected.unwrap()), points(&found.unwrap()));
    assert_eq!((found.len(), expected.len()), (12, 12));
    for (here, there) in found.iter().zip(&expected) {
        assert_eq!((here.0, here.1), (there.0, there.1));
        // The T-10A shows 0.1 lx here, and both have their noise.
        let allowed = 0.1 + 0.01 * there.2;
        assert!((here.2 - there.2).abs() <= allowed, "{here:?} {there:?}");
    }
}
