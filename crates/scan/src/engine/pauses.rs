//! Pause, resume and abort on a bench of fakes, in virtual time.

use std::time::Duration;

use isolux_record::run::{Run, StopHow};
use isolux_record::{Quality, Role};
use tokio::time::{Instant, sleep};

use super::ScanSummary;
use super::tests::{DAY, at_rest, scan_with};
use crate::cancel::Cancel;
use crate::error::{ScanError, ScanErrorKind};
use crate::pause::Pause;
use crate::testing::{Room, Shared, bench, plan, run_dir};

/// The outcome of a scan that was paused from `from` to `to` seconds, its record and its events. `hand` is what
/// somebody does to the room at the beginning, in the middle and at the end of the pause.
struct Paused {
    outcome: Result<ScanSummary, ScanError>,
    run: Run,
    events: Vec<serde_json::Value>,
    room: Shared,
    begun: Instant,
}

async fn paused(from: f64, to: f64, hand: impl Fn(&mut Room, usize) + Send + 'static) -> Paused {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let pause = Pause::new();
    let (requested, beside) = (pause.clone(), room.clone());
    let begun = Instant::now();
    tokio::spawn(async move {
        sleep(Duration::from_secs_f64(from)).await;
        assert!(requested.ask("a test") && !requested.ask("another"), "the first stands");
        // The visit that was begun is finished.
        sleep(Duration::from_secs(25)).await;
        hand(&mut beside.lock().unwrap(), 0);
        sleep(Duration::from_secs_f64((to - from) / 2.0 - 25.0)).await;
        hand(&mut beside.lock().unwrap(), 1);
        sleep(Duration::from_secs_f64((to - from) / 2.0)).await;
        assert!(requested.end("a test"));
        sleep(Duration::from_mins(5)).await;
        hand(&mut beside.lock().unwrap(), 2);
    });
    let outcome = scan_with(&mut devices, &plan, &mut run, (&Cancel::new(), &pause), None).await;
    drop(run);
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    let events = events.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let run = Run::read(&path).unwrap();
    Paused {
        outcome,
        run,
        events,
        room,
        begun,
    }
}

impl Paused {
    fn count(&self, name: &str) -> usize {
        self.events.iter().filter(|event| event["event"] == name).count()
    }

    /// Every point once, in order, all of them sound.
    fn assert_whole(&self, what: &str) {
        assert!(self.outcome.is_ok(), "{what}: {:?}", self.outcome);
        let rows = &self.run.readings.rows;
        let points: Vec<_> = rows
            .iter()
            .filter(|row| row.role == Role::Point)
            .map(|row| (row.point, row.repeat))
            .collect();
        let expected: Vec<_> = (0..12)
            .map(|point| (point, 0))
            .chain([(12, 0), (12, 1), (12, 2), (14, 0), (14, 1), (15, 0), (15, 1)])
            .collect();
        assert_eq!(points, expected, "{what}");
        assert!(rows.iter().all(|row| row.quality == Quality::Ok), "{what}");
        let stopped = self.run.header.stopped.as_ref().unwrap();
        assert_eq!(
            (stopped.how, stopped.axes_at_rest),
            (StopHow::Completed, true),
            "{what}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn a_pause_finishes_the_point_keeps_the_lamp_and_ends_at_the_reference() {
    let seen = std::sync::Arc::new(std::sync::Mutex::new(Vec::new()));
    let look = seen.clone();
    let paused = paused(1840.0, 5440.0, move |room, moment| {
        let now = Instant::now();
        // Homing has set the counts of stops back.
        let rests = room.axes.iter().all(|axis| !axis.moving(now) && axis.stops >= 1);
        look.lock()
            .unwrap()
            .push((moment, rests, room.lamp_on.is_some(), room.looks.len()));
    })
    .await;
    paused.assert_whole("paused between points");
    let seen = seen.lock().unwrap();
    let [(0, rests, lamp, before), (1, still, burning, after), ..] = seen[..] else {
        panic!("{seen:?}")
    };
    assert!(rests && still, "stopped by the pause, and left alone");
    assert!(lamp && burning, "the lamp burns on");
    assert_eq!(before, after, "nothing is read during the pause");
    assert_eq!(
        (paused.count("paused"), paused.count("resumed"), paused.count("stable")),
        (1, 1, 1)
    );
    assert_eq!(
        paused.count("lamp"),
        2,
        "switched on at the start and off for the last block alone"
    );
    let resumed = paused.events.iter().find(|event| event["event"] == "resumed").unwrap();
    assert!(
        (resumed["paused_s"].as_f64().unwrap() - 3600.0).abs() < 30.0,
        "{resumed}"
    );
    // The first reading after the pause is of the reference point.
    let rows = &paused.run.readings.rows;
    let next = rows.iter().position(|row| row.lamp_s > Some(5000.0)).unwrap();
    assert!(next > 0 && rows[next - 1].lamp_s < Some(1860.0));
    assert_eq!((rows[next].role, rows[next].gamma_target_deg), (Role::Reference, 0.0));
    assert_eq!(rows.iter().filter(|row| row.role == Role::Reference).count(), 4);
}

#[tokio::test(start_paused = true)]
async fn a_pause_in_the_warm_up_begins_its_window_anew() {
    // Somebody stands in the light meanwhile.
    let paused = paused(1000.0, 1800.0, |room, moment| room.shutter_open = moment != 0).await;
    paused.assert_whole("paused in the warm-up");
    assert_eq!((paused.count("paused"), paused.count("lamp")), (1, 2));
    let first = paused.run.readings.rows.first().unwrap();
    // 15 min from the end of the pause, although the lamp was on for the least time before.
    assert!((2670.0..2740.0).contains(&first.lamp_s.unwrap()), "{first:?}");
    let looks = paused.events.iter().filter(|event| event["event"] == "warm_up");
    let during = looks.filter(|look| (1035.0..1760.0).contains(&look["lamp_s"].as_f64().unwrap()));
    assert_eq!(during.count(), 0, "nobody looks at the lamp during a pause");
}

#[tokio::test(start_paused = true)]
async fn a_lamp_that_left_its_band_in_a_pause_is_warmed_up_again() {
    // 3 % less light until five minutes after the pause.
    let paused = paused(1840.0, 3000.0, |room, moment| {
        room.dimmed = if moment == 2 { 0.0 } else { 0.03 };
    })
    .await;
    paused.assert_whole("the lamp came back");
    assert_eq!((paused.count("lamp_outside_band"), paused.count("stable")), (1, 2));
    let references = paused
        .run
        .readings
        .rows
        .iter()
        .filter(|row| row.role == Role::Reference);
    let lux: Vec<f64> = references.filter_map(|row| row.illuminance_lx).collect();
    assert!(lux.iter().all(|value| (value / lux[0] - 1.0).abs() < 0.002), "{lux:?}");
    assert!(paused.begun.elapsed() > Duration::from_mins(65));
}

#[tokio::test(start_paused = true)]
async fn a_lamp_that_does_not_come_back_ends_the_scan() {
    let paused = paused(1840.0, 3000.0, |room, _| room.dimmed = 0.03).await;
    let error = paused.outcome.unwrap_err();
    assert!(matches!(error, ScanError::Reference { .. }), "{error}");
    assert_eq!(error.kind(), ScanErrorKind::NotAccepted);
    assert!(at_rest(&paused.room));
    let stable = paused.events.iter().filter(|event| event["event"] == "stable");
    assert_eq!(stable.count(), 2, "warmed up again before it is refused");
}

#[tokio::test(start_paused = true)]
async fn paused_at_any_moment_no_point_is_lost_or_doubled() {
    let mut moment = 0.9;
    while moment < 1900.0 {
        let paused = paused(moment, moment + 120.0, |_, _| {}).await;
        paused.assert_whole(&format!("paused after {moment} s"));
        assert_eq!(
            paused.count("paused"),
            usize::from(moment < 1899.0).min(paused.count("resumed"))
        );
        moment += if (26.0..1800.0).contains(&moment) { 173.3 } else { 3.37 };
    }
}

#[tokio::test(start_paused = true)]
async fn an_abort_ends_a_pause_with_the_axes_at_rest() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let (pause, cancel) = (Pause::new(), Cancel::new());
    let (requested, signal) = (pause.clone(), cancel.clone());
    tokio::spawn(async move {
        sleep(Duration::from_secs(1840)).await;
        assert!(requested.toggle("p"));
        sleep(Duration::from_secs(100)).await;
        signal.cancel("abort from the page");
    });
    let outcome = scan_with(&mut devices, &plan, &mut run, (&cancel, &pause), None).await;
    let error = outcome.unwrap_err();
    assert_eq!(error.kind(), ScanErrorKind::Interrupted);
    assert!(error.to_string().contains("abort from the page"), "{error}");
    assert!(at_rest(&room));
    let stopped = Run::read(&path).unwrap().header.stopped.unwrap();
    assert_eq!((stopped.how, stopped.axes_at_rest), (StopHow::Interrupted, true));
}

#[tokio::test(start_paused = true)]
async fn a_pause_that_cannot_stop_an_axis_ends_the_scan_and_says_so() {
    let (mut devices, room) = bench();
    let plan = plan(DAY);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let pause = Pause::new();
    let requested = pause.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs(1840)).await;
        room.lock().unwrap().stop_fails = true;
        requested.ask("a test");
    });
    let outcome = scan_with(&mut devices, &plan, &mut run, (&Cancel::new(), &pause), None).await;
    let error = outcome.unwrap_err();
    assert!(matches!(error, ScanError::NotAtRest { .. }), "{error}");
    assert!(!Run::read(&path).unwrap().header.stopped.unwrap().axes_at_rest);
}
