//! Whole benches in virtual time: real bytes to the twins of the built-in darkroom, a run directory on disk.

use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{self, Place, ScanJob, Target};
use isolux_app::{FailureKind, init};
use isolux_record::run::StopHow;
use isolux_record::{Plan, Quality, ReadingKind, Role, Run};
use isolux_scan::Cancel;
use isolux_virtual::BUILT_IN;
use isolux_virtual::twins::Choice;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 90]
gamma_deg = [-60, -30, 0, 30, 60]
reference_every = 5
[[block]]
name = "near"
kind = "lit"
c_deg = 0
gamma_deg = 0
distance_mm = 2000.0
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 3
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 3
"#;

fn folder() -> (tempfile::TempDir, Utf8PathBuf) {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    (keep, path)
}

/// Scans the small plan in `darkroom`, interrupted after `cancel_s` of virtual time if asked.
fn scan_in(
    darkroom: &str,
    target: Target<'_>,
    cancel_s: Option<f64>,
) -> Result<scan::ScanSummary, isolux_app::Failure> {
    let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
    let source = StationFiles::from_text(&station, calibration.as_deref()).unwrap();
    let plan = Plan::parse(Utf8Path::new("plan.toml"), PLAN).unwrap();
    session::run(true, async {
        let session = Session::in_room(isolux_darkroom::Darkroom::parse(darkroom).unwrap(), &Choice::default())?;
        let cancel = Cancel::new();
        if let Some(seconds) = cancel_s {
            let cancel = cancel.clone();
            tokio::spawn(async move {
                tokio::time::sleep(Duration::from_secs_f64(seconds)).await;
                cancel.cancel("SIGTERM");
            });
        }
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let job = ScanJob {
            source: &source,
            plan: &plan,
            place: Place::take(target, false)?,
            force: None,
            operator: None,
            control: &Control {
                cancel,
                ..Control::default()
            },
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await
    })
}

#[test]
fn the_twins_are_scanned_as_they_are() {
    let (_keep, path) = folder();
    let summary = scan_in(BUILT_IN, Target::New(&path), None).unwrap();
    assert_eq!((summary.points, summary.spectra, summary.without_number), (13, 1, 0));
    let run = Run::read(&path).unwrap();
    assert_eq!(run.header.stopped.as_ref().unwrap().how, StopHow::Completed);
    let rows = &run.readings.rows;
    let lux = |block: &str, gamma: f64| {
        let of: Vec<f64> = rows
            .iter()
            .filter(|row| row.block == block && row.role == Role::Point && row.gamma_target_deg == gamma)
            .map(|row| row.illuminance_lx.unwrap())
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    // 337 lm with a peak near 1000 cd/klm: 3.4 lx at 10 m, 25 times that at 2 m.
    let far = lux("lit", 0.0);
    assert!((3.0..3.8).contains(&far), "{far} lx");
    assert!((lux("near", 0.0) / far / 25.0 - 1.0).abs() < 0.02);
    assert!((lux("lit", 30.0) / lux("lit", -30.0) - 1.0).abs() < 0.05);
    assert!(
        rows.iter()
            .filter(|row| row.kind == ReadingKind::Capped)
            .all(|row| row.illuminance_lx.unwrap().abs() < 0.03)
    );
    assert!(
        rows.iter()
            .all(|row| row.time_s.unwrap() > 1800.0 && row.quality == Quality::Ok)
    );
    assert!(
        rows.iter()
            .all(|row| (row.gamma_deg - row.gamma_target_deg).abs() < 0.01)
    );
    let peak = run.spectra[0]
        .pixels
        .iter()
        .map(|pixel| pixel.counts)
        .fold(0.0, f64::max);
    assert!(
        peak > 15_000.0 && !run.spectra[0].pixels.iter().any(|pixel| pixel.saturated),
        "{peak} counts"
    );
}

#[test]
fn one_seed_gives_one_record_to_the_byte() {
    let record = || {
        let (_keep, path) = folder();
        scan_in(BUILT_IN, Target::New(&path), None).unwrap();
        std::fs::read(path.join("readings.csv")).unwrap()
    };
    assert_eq!(record(), record());
}

#[test]
fn interrupted_it_can_be_read_and_taken_up_again() {
    for moment in [3.0, 700.0, 1893.0, 1903.0] {
        let (_keep, path) = folder();
        let failure = scan_in(BUILT_IN, Target::New(&path), Some(moment)).unwrap_err();
        assert_eq!(failure.kind, FailureKind::Interrupted, "{failure}");
        let cut = Run::read(&path).unwrap();
        let stopped = cut.header.stopped.unwrap();
        assert_eq!((stopped.how, stopped.axes_at_rest), (StopHow::Interrupted, true));
        scan_in(BUILT_IN, Target::Resume(&path), None).unwrap();
        let points: Vec<_> = Run::read(&path)
            .unwrap()
            .readings
            .rows
            .iter()
            .filter(|row| row.role == Role::Point)
            .map(|row| (row.point, row.repeat))
            .collect();
        let expected: Vec<_> = (0..11)
            .map(|point| (point, 0))
            .chain([(12, 0), (12, 1), (12, 2)])
            .collect();
        assert_eq!(points, expected, "cut after {moment} s");
    }
}

#[test]
fn a_meter_that_is_unplugged_ends_the_scan_with_the_axes_at_rest() {
    let darkroom = format!("{BUILT_IN}\n[[fault]]\ninstrument = \"luxmeter\"\nkind = \"disconnect\"\nat_s = 1890.0\n");
    let (_keep, path) = folder();
    let failure = scan_in(&darkroom, Target::New(&path), None).unwrap_err();
    assert_eq!(failure.kind, FailureKind::Instrument, "{failure}");
    assert!(failure.message.starts_with("luxmeter"), "{failure}");
    let stopped = Run::read(&path).unwrap().header.stopped.unwrap();
    assert_eq!((stopped.how, stopped.axes_at_rest), (StopHow::Failed, true));
}
