//! Whole scans on a bench of fakes, in virtual time.

use std::time::Duration;

use isolux_record::run::{Run, RunDir, StopHow};
use isolux_record::{Plan, Quality, ReadingKind, Role};
use tokio::time::{Instant, sleep};

use super::ScanSummary;
use crate::awake::Awake;
use crate::cancel::Cancel;
use crate::devices::Devices;
use crate::error::{ScanError, ScanErrorKind};
use crate::pause::Pause;
use crate::testing::{
    AMBIENT_LX, OFFSET_LX, PEAK_CD, STRAY_LX, Shared, bench, header, plan, run_dir, station, unobserved,
};

pub(super) const DAY: &str = r#"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 90]
gamma_deg = [0, 30, 60]
order = "both"
reference_every = 6
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_deg = 0
repeats = 3
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 4
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 2
[[block]]
name = "off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 2
"#;

pub(super) async fn scan(
    devices: &mut Devices,
    plan: &Plan,
    run: &mut RunDir,
    cancel: &Cancel,
    resumed: Option<&Run>,
) -> Result<ScanSummary, ScanError> {
    scan_with(devices, plan, run, (cancel, &Pause::new()), resumed).await
}

pub(super) async fn scan_with(
    devices: &mut Devices,
    plan: &Plan,
    run: &mut RunDir,
    (cancel, pause): (&Cancel, &Pause),
    resumed: Option<&Run>,
) -> Result<ScanSummary, ScanError> {
    unobserved(&station(), pause, &Awake::unwatched())
        .run(devices, plan, run, cancel, resumed)
        .await
}

pub(super) fn at_rest(room: &Shared) -> bool {
    let room = room.lock().unwrap();
    room.axes
        .iter()
        .all(|drive| !drive.moving(Instant::now()) && drive.stops > 0)
}

#[tokio::test(start_paused = true)]
async fn a_whole_day_is_recorded_as_it_was() {
    let (mut devices, room) = bench();
    room.lock().unwrap().warm_up_amplitude = 0.05;
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert!(at_rest(&room));
    assert!(summary.warm_up_s.unwrap() >= 1800.0);
    let run = Run::read(&path).unwrap();
    let stopped = run.header.stopped.as_ref().unwrap();
    assert_eq!((stopped.how, stopped.axes_at_rest), (StopHow::Completed, true));
    // The last block has the lamp off and the shutter open.
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    let last: serde_json::Value = serde_json::from_str(events.lines().last().unwrap()).unwrap();
    let left = serde_json::json!({
        "c_deg": 0.0, "gamma_deg": 0.0, "axes_at_rest": true, "lamp_is_on": false, "shutter_is_open": true,
        "baffle_is_in": false,
    });
    assert_eq!(last["left"], left, "{last}");
    let rows = &run.readings.rows;
    // 12 points + 3 reference visits, 3 baffled, 2 capped, 2 off.
    assert_eq!(rows.len(), 15 + 3 + 2 + 2);
    assert_eq!((summary.points, summary.readings, summary.spectra), (16, 22, 1));
    let of = |kind| {
        rows.iter()
            .filter(move |row| row.kind == kind && row.quality == Quality::Ok)
            .map(|row| row.illuminance_lx.unwrap())
    };
    let close = |value: f64, expected: f64| (value - expected).abs() <= 0.0051 + 2e-3 * expected;
    assert!(of(ReadingKind::Capped).all(|lux| close(lux, OFFSET_LX)));
    assert!(of(ReadingKind::LampOff).all(|lux| close(lux, OFFSET_LX + AMBIENT_LX)));
    assert!(of(ReadingKind::Baffled).all(|lux| close(lux, OFFSET_LX + AMBIENT_LX + STRAY_LX)));
    for row in rows.iter().filter(|row| row.kind == ReadingKind::Lit) {
        let expected = OFFSET_LX + AMBIENT_LX + STRAY_LX + PEAK_CD * row.gamma_deg.to_radians().cos() / 100.0;
        assert!(close(row.illuminance_lx.unwrap(), expected), "{row:?}");
        assert!(row.lamp_s.unwrap() > 1800.0);
        assert!(
            (row.u_lx.unwrap() - 0.01 / 12.0_f64.sqrt()).abs() < 0.01,
            "{:?}",
            row.u_lx
        );
    }
    // "both": up, then down; the first reading of the way down repeats the last of the way up, its travel is held.
    let illuminated: Vec<i8> = rows
        .iter()
        .filter(|row| row.block == "lit" && row.role == Role::Point)
        .map(|row| row.travel)
        .collect();
    assert_eq!(illuminated, [0, 1, 1, 1, -1, -1, -1, 1, 1, 1, -1, -1]);
    assert_eq!(run.spectra.len(), 1);
    let peak = run.spectra[0].pixels[7];
    assert!(peak.counts > 0.4 * 65_535.0 && !peak.saturated && peak.dark_counts == 1500.0);
    assert_eq!(run.spectra[0].distance_mm, 500.0);
}

#[tokio::test(start_paused = true)]
async fn cancelled_at_any_moment_it_leaves_a_readable_run_and_axes_at_rest() {
    let plan = plan(DAY);
    let mut moment = 0.7_f64;
    let (mut cut, mut whole) = (0, 0);
    while moment < 1905.0 {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            signal.cancel("SIGINT");
        });
        let outcome = scan(&mut devices, &plan, &mut run, &cancel, None).await;
        assert!(at_rest(&room), "cancelled after {moment} s");
        let run = Run::read(&path).unwrap();
        let stopped = run.header.stopped.as_ref().unwrap();
        match outcome {
            Err(error) => {
                cut += 1;
                assert_eq!(error.kind(), ScanErrorKind::Interrupted, "{error}");
                assert_eq!((stopped.how, stopped.axes_at_rest), (StopHow::Interrupted, true));
                assert_eq!(stopped.readings, run.readings.rows.len() as u64);
                assert!(run.readings.torn_tail.is_none());
            }
            Ok(_) => whole += 1,
        }
        // Dense where the points are, sparse in the warm-up.
        moment += if (26.0..1800.0).contains(&moment) { 97.3 } else { 2.37 };
    }
    assert!(cut > 25 && whole > 0, "{cut} cut, {whole} whole");
}

#[tokio::test(start_paused = true)]
async fn resumed_after_any_cut_no_point_is_lost_doubled_or_out_of_order() {
    let plan = plan(DAY);
    for moment in [
        5.0, 1000.0, 1832.0, 1841.0, 1853.5, 1860.0, 1868.0, 1875.0, 1882.0, 1890.0,
    ] {
        let (mut devices, _room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            signal.cancel("SIGTERM");
        });
        let first = scan(&mut devices, &plan, &mut run, &cancel, None).await;
        drop(run);
        let before = std::fs::read(path.join("readings.csv")).unwrap();
        let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
        scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old))
            .await
            .unwrap();
        assert!(
            std::fs::read(path.join("readings.csv")).unwrap().starts_with(&before),
            "{moment}: {first:?}"
        );
        let run = Run::read(&path).unwrap();
        let points: Vec<_> = run
            .readings
            .rows
            .iter()
            .filter(|row| row.role == Role::Point)
            .map(|row| (row.point, row.repeat))
            .collect();
        let expected: Vec<_> = (0..12)
            .map(|point| (point, 0))
            .chain([(12, 0), (12, 1), (12, 2), (14, 0), (14, 1), (15, 0), (15, 1)])
            .collect();
        assert_eq!(points, expected, "cut after {moment} s");
        assert_eq!(run.spectra.len(), 1);
        assert_eq!(run.header.stopped.unwrap().how, StopHow::Completed);
    }
}

#[tokio::test(start_paused = true)]
async fn a_lost_meter_stops_the_axes_and_leaves_the_run() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    // The warm-up takes about 5 readings a look, a look every 30 s.
    room.lock().unwrap().meter_lost_after = Some(5 * 61 + 9);
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ScanErrorKind::Instrument, "{error}");
    assert!(matches!(&error, ScanError::Device { role: "luxmeter", .. }), "{error}");
    assert!(at_rest(&room));
    let run = Run::read(&path).unwrap();
    assert_eq!(run.header.stopped.unwrap().how, StopHow::Failed);
    assert!(!run.readings.rows.is_empty());
}

#[tokio::test(start_paused = true)]
async fn even_a_defect_of_the_program_stops_the_axes() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().panic_after = Some(5 * 61 + 9);
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(
        matches!(&error, ScanError::Panicked { message } if message == "a defect"),
        "{error}"
    );
    assert!(at_rest(&room));
    assert_eq!(Run::read(&path).unwrap().header.stopped.unwrap().how, StopHow::Failed);
}

#[tokio::test(start_paused = true)]
async fn answers_that_a_driver_asked_for_again_are_counted() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().meter_garbles_every = Some(5);
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert!(summary.retries > 10);
    assert!(
        Run::read(&path)
            .unwrap()
            .readings
            .rows
            .iter()
            .all(|row| row.quality == Quality::Ok)
    );
}

#[tokio::test(start_paused = true)]
async fn a_meter_whose_driver_has_given_up_is_not_asked_again() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, _, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().meter_silent_after = Some(50);
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(matches!(&error, ScanError::Device { role: "luxmeter", .. }), "{error}");
    assert_eq!(room.lock().unwrap().reads, 51);
    assert!(at_rest(&room));
}

#[tokio::test(start_paused = true)]
async fn an_axis_that_cannot_be_stopped_wins_over_every_other_end() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let cancel = Cancel::new();
    let signal = cancel.clone();
    let faults = room.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs(1850)).await;
        faults.lock().unwrap().stop_fails = true;
        signal.cancel("SIGINT");
    });
    let began = Instant::now();
    let error = scan(&mut devices, &plan, &mut run, &cancel, None).await.unwrap_err();
    assert_eq!(error.kind(), ScanErrorKind::Instrument);
    let after = began.elapsed().saturating_sub(Duration::from_secs(1850));
    assert!(
        after < Duration::from_secs(10),
        "the lost link is reported only after {after:?}"
    );
    assert!(
        error.to_string().contains("axis.c could not be verified at rest"),
        "{error}"
    );
    assert!(error.to_string().contains("SIGINT"), "{error}");
    let stopped = Run::read(&path).unwrap().header.stopped.unwrap();
    assert!(!stopped.axes_at_rest);
    assert!(
        room.lock().unwrap().axes[1].stops > 0,
        "the other axis is stopped all the same"
    );
}

#[tokio::test(start_paused = true)]
async fn an_axis_that_never_arrives_is_noticed() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, _path, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().stall_at_deg = Some(60.0);
    let begun = Instant::now();
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(
        matches!(&error, ScanError::Device { role: "axis.gamma", .. }),
        "{error}"
    );
    assert!(begun.elapsed() < Duration::from_mins(50));
    assert!(at_rest(&room));
}

#[tokio::test(start_paused = true)]
async fn light_that_lags_behind_the_axes_is_waited_for() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().lag_s = 1.0;
    scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    for row in Run::read(&path)
        .unwrap()
        .readings
        .rows
        .iter()
        .filter(|row| row.block == "lit")
    {
        let expected = OFFSET_LX + AMBIENT_LX + STRAY_LX + PEAK_CD * row.gamma_deg.to_radians().cos() / 100.0;
        let error = (row.illuminance_lx.unwrap() - expected).abs();
        assert!(error <= 0.025, "{error} lx at γ = {}", row.gamma_deg);
    }
}

#[tokio::test(start_paused = true)]
async fn the_gate_stays_shut_for_a_lamp_that_drifts_or_is_dark() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    room.lock().unwrap().drift_per_h = -0.04;
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(matches!(error, ScanError::NotStable { .. }), "{error}");
    assert_eq!(error.kind(), ScanErrorKind::NotAccepted);
    assert!(at_rest(&room));
    assert!(Run::read(&path).unwrap().readings.rows.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_plan_outside_the_limits_moves_nothing() {
    let (mut devices, room) = bench();
    let plan = plan(
        "[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = [0, 180]\n[[block]]\nname = \"b\"\nkind = \"lit\"\nc_deg = 370\ngamma_deg = 0\n",
    );
    let (_keep, _path, mut run) = run_dir(&devices, &plan);
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ScanErrorKind::BadPlan);
    assert!(room.lock().unwrap().log.is_empty() && room.lock().unwrap().axes[0].stops == 0);
}
