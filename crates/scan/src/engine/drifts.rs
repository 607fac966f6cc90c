//! A lamp that drifts slowly, and one that leaves its band for a while, on a bench of fakes in virtual time.

use std::time::Duration;

use isolux_record::run::{Run, RunDir, StopHow};
use isolux_record::steadiness::{Seen, Steadiness, level};
use isolux_record::{Reading, Role};
use tokio::time::sleep;

use super::ScanSummary;
use super::tests::{DAY, at_rest, scan};
use crate::cancel::Cancel;
use crate::error::{ScanError, ScanErrorKind};
use crate::testing::{AMBIENT_LX, OFFSET_LX, PEAK_CD, Room, STRAY_LX, bench, header, plan, run_dir};

/// Almost an hour of points, with a visit to the reference point every four minutes.
const LONG: &str = r#"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 330, 30]
gamma_range = [0, 90, 15]
repeats = 60
reference_every = 7
"#;

/// The outcome of a long scan of a lamp whose light changes by `per_h` an hour, its record and its events.
async fn drifting(per_h: f64) -> (Result<ScanSummary, ScanError>, Run, String) {
    let (mut devices, room) = bench();
    room.lock().unwrap().drift_per_h = per_h;
    let plan = plan(LONG);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await;
    assert!(at_rest(&room));
    drop(run);
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    (outcome, Run::read(&path).unwrap(), events)
}

fn visits(run: &Run) -> Vec<Seen> {
    let rows = run.readings.rows.iter().filter(|row| row.role == Role::Reference);
    let seen = |row: &Reading| Seen {
        illuminance_lx: row.illuminance_lx.unwrap(),
        digit_lx: row.digit_lx.unwrap(),
    };
    rows.map(seen).collect()
}

/// What a reduction refuses: see `isolux_record::steadiness`.
fn assert_reducible(run: &Run) {
    let limits = run.header.plan.limits();
    let mut followed = Steadiness::default();
    for visit in visits(run) {
        assert_eq!(followed.drifted(visit, limits), None, "{visit:?}");
        assert!(followed.follow(visit, limits), "{visit:?} after {:?}", followed.last());
    }
}

fn count(events: &str, name: &str) -> usize {
    let named = format!("\"event\":\"{name}\"");
    events.lines().filter(|line| line.contains(&named)).count()
}

#[tokio::test(start_paused = true)]
async fn a_slow_drift_that_the_visits_follow_ends_no_scan() {
    let (outcome, run, events) = drifting(-0.018).await;
    outcome.unwrap();
    let visits = visits(&run);
    let change = visits.last().unwrap().illuminance_lx / visits[0].illuminance_lx - 1.0;
    assert!(change < -0.0125, "{change}: farther from the first than a jump may be");
    assert_reducible(&run);
    assert_eq!(count(&events, "lamp_outside_band"), 0);
    assert_eq!(count(&events, "again"), 0, "no visit was doubted");
}

#[tokio::test(start_paused = true)]
async fn a_drift_beyond_what_is_corrected_is_waited_for_and_then_ends_the_scan() {
    let (mut devices, room) = bench();
    room.lock().unwrap().drift_per_h = -0.018;
    let narrow = plan(&format!("[limits]\ndrift_rel = 0.004\n{LONG}"));
    let (_keep, path, mut run) = run_dir(&devices, &narrow);
    let error = scan(&mut devices, &narrow, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    let ScanError::Drifted {
        change_rel,
        allowed_rel,
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert!(change_rel.abs() > allowed_rel && allowed_rel == 0.004, "{error}");
    assert_eq!(error.kind(), ScanErrorKind::NotAccepted);
    drop(run);
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    assert_eq!(count(&events, "lamp_outside_band"), 1);
    assert_eq!(count(&events, "stable"), 2, "it was watched until it was stable again");
    assert_eq!(count(&events, "lamp_inside_band"), 0);
    let before = Run::read(&path).unwrap();
    assert_eq!(before.header.stopped.as_ref().unwrap().how, StopHow::Failed);
    assert_reducible(&before);
    // The lamp is switched off and on, comes back at the level that it had, and drifts no more: the same run is brought
    // to its end.
    let level_lx = level(&visits(&before)).unwrap().illuminance_lx;
    {
        let mut room = room.lock().unwrap();
        (room.lamp_on, room.drift_per_h) = (None, 0.0);
        room.dimmed = 1.0 - (level_lx - OFFSET_LX - AMBIENT_LX) / (PEAK_CD / 100.0 + STRAY_LX);
    }
    let (mut dir, old) = RunDir::resume(&path, &header(&devices, &narrow)).unwrap();
    scan(&mut devices, &narrow, &mut dir, &Cancel::new(), Some(&old))
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_lamp_that_comes_back_while_it_is_waited_for_ends_no_scan() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let lamp = room.clone();
    tokio::spawn(async move {
        let dim = |share: f64| {
            lamp.lock()
                .map(|mut room: std::sync::MutexGuard<'_, Room>| room.dimmed = share)
        };
        sleep(Duration::from_secs(1838)).await;
        dim(0.03).unwrap();
        sleep(Duration::from_mins(6)).await;
        dim(0.0).unwrap();
    });
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert!(summary.duration_s > 1838.0 + 360.0 + 900.0, "{summary:?}");
    drop(run);
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    for (event, times) in [
        ("lamp_outside_band", 1),
        ("lamp_inside_band", 1),
        ("stable", 2),
        ("again", 2),
    ] {
        assert_eq!(count(&events, event), times, "{event}: {events}");
    }
    assert!(events.contains("within the limits: the scan goes on"));
    assert_reducible(&Run::read(&path).unwrap());
}

#[tokio::test(start_paused = true)]
async fn a_lamp_that_comes_back_at_another_level_is_refused_at_once_and_not_by_the_reduction() {
    for (dimmed, goes_on) in [(0.01, true), (0.03, false)] {
        let (mut devices, room) = bench();
        let plan = plan(DAY);
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs(1845)).await;
            signal.cancel("SIGTERM");
        });
        scan(&mut devices, &plan, &mut run, &cancel, None).await.unwrap_err();
        drop(run);
        {
            let mut room = room.lock().unwrap();
            (room.lamp_on, room.dimmed) = (None, dimmed);
        }
        let (mut dir, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
        let outcome = scan(&mut devices, &plan, &mut dir, &Cancel::new(), Some(&old)).await;
        assert_eq!(outcome.is_ok(), goes_on, "{dimmed}: {outcome:?}");
        if let Err(error) = outcome {
            assert!(
                matches!(error, ScanError::Drifted { change_rel, .. } if (change_rel + 0.03).abs() < 0.002),
                "{error}"
            );
        }
    }
}
