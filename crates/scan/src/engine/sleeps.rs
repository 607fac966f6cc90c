//! A process that is stopped and a computer that sleeps, on a bench of fakes in virtual time: a stop is time that
//! passes at once, a sleep is time that only another clock counts.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use isolux_record::run::{Run, RunDir, StopHow};
use isolux_record::{Quality, Role};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::time::{Instant, advance, sleep};

use super::ScanSummary;
use super::tests::{DAY, at_rest};
use crate::awake::Awake;
use crate::cancel::Cancel;
use crate::devices::Devices;
use crate::error::ScanError;
use crate::pause::Pause;
use crate::testing::{Room, Shared, bench, plan, run_dir, station_with, unobserved};

/// When the lamp counts as stable: soon, because every second until then has ten looks at the clocks.
const STABLE_S: f64 = 180.0;

async fn scan(devices: &mut Devices, run: &mut RunDir, pause: &Pause, awake: &Awake) -> Result<ScanSummary, ScanError> {
    let stable = format!("stable = {{ least_s = {STABLE_S:.1}, window_s = 90.0, spread_rel = 0.005 }}");
    unobserved(&station_with(&stable), pause, awake)
        .run(devices, &plan(DAY), run, &Cancel::new(), None)
        .await
}

/// How the program does not run.
#[derive(Debug, Clone, Copy)]
enum How {
    /// The process is stopped: deadlines pass.
    Stopped,
    /// The computer sleeps: deadlines stand still.
    Suspended,
}

struct Slept {
    outcome: Result<ScanSummary, ScanError>,
    run: Run,
    events: Vec<serde_json::Value>,
    room: Shared,
}

impl Slept {
    fn all(&self, name: &str) -> Vec<&serde_json::Value> {
        self.events.iter().filter(|event| event["event"] == name).collect()
    }

    fn assert_whole(&self, what: &str) {
        assert!(self.outcome.is_ok(), "{what}: {:?}", self.outcome);
        assert!(at_rest(&self.room), "{what}");
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
        assert_eq!(self.run.spectra.len(), 1, "{what}");
        for row in rows {
            assert_eq!(row.quality, Quality::Ok, "{what}: {row:?}");
            assert!(
                row.integration_s.unwrap() <= 0.5,
                "{what}: read across the sleep: {row:?}"
            );
        }
        assert_eq!(self.run.header.stopped.as_ref().unwrap().how, StopHow::Completed);
    }
}

/// A day in which the program does not run for `length_s` at `moment`, while `meanwhile` happens in the room.
async fn slept(how: How, moment: f64, length_s: u64, meanwhile: impl Fn(&mut Room) + Send + 'static) -> Slept {
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan(DAY));
    let suspended = Arc::new(AtomicU64::new(0));
    let clock = suspended.clone();
    let awake = Awake::watching(Arc::new(move || Duration::from_secs(clock.load(Ordering::Relaxed))));
    let bench = room.clone();
    let task = tokio::spawn(async move {
        sleep(Duration::from_secs_f64(moment)).await;
        meanwhile(&mut bench.lock().unwrap());
        match how {
            How::Stopped => advance(Duration::from_secs(length_s)).await,
            How::Suspended => drop(suspended.fetch_add(length_s, Ordering::Relaxed)),
        }
    });
    let outcome = scan(&mut devices, &mut run, &Pause::new(), &awake).await;
    task.abort();
    drop(run);
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    Slept {
        outcome,
        run: Run::read(&path).unwrap(),
        events: events.lines().map(|line| serde_json::from_str(line).unwrap()).collect(),
        room,
    }
}

#[tokio::test(start_paused = true)]
async fn stopped_at_any_moment_nothing_is_lost_doubled_or_blamed() {
    let mut random = ChaCha8Rng::seed_from_u64(23);
    let mut noticed = 0;
    for round in 0..120 {
        let moment = match round {
            0..20 => random.random_range(0.5..25.0),
            20..40 => random.random_range(25.0..STABLE_S + 20.0),
            _ => STABLE_S + random.random_range(20.0..95.0),
        };
        let length_s = random.random_range(1..=120);
        let how = if round % 4 == 3 { How::Suspended } else { How::Stopped };
        let what = format!("{how:?} after {moment:.3} s for {length_s} s");
        let day = slept(how, moment, length_s, |_| {}).await;
        day.assert_whole(&what);
        let [event] = day.all("slept")[..] else {
            let ended_s = day.outcome.as_ref().unwrap().duration_s;
            assert!(moment > ended_s - 0.2, "{what}: {ended_s}, {:?}", day.all("slept"));
            continue;
        };
        noticed += 1;
        let slept_s = event["slept_s"].as_f64().unwrap();
        assert!((slept_s - length_s as f64).abs() < 0.21, "{what}: {event}");
        let suspended_s = event["suspended_s"].as_f64().unwrap();
        assert_eq!(suspended_s > 0.0, matches!(how, How::Suspended), "{what}: {event}");
        // The first lit row afterwards is a visit to the reference point.
        let from_s = event["time_s"].as_f64();
        let after = day
            .run
            .readings
            .rows
            .iter()
            .find(|row| row.time_s > from_s.map(|s| s + slept_s));
        if let Some(row) = after.filter(|row| row.kind == isolux_record::ReadingKind::Lit) {
            assert_eq!(row.role, Role::Reference, "{what}: {row:?}");
        }
    }
    assert!(noticed > 100, "{noticed}");
}

#[tokio::test(start_paused = true)]
async fn stopped_again_while_the_bench_is_being_found_it_begins_anew() {
    for round in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + round);
        let (first_s, then_s) = (STABLE_S + random.random_range(3.0..70.0), random.random_range(0.0..4.0));
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan(DAY));
        let task = tokio::spawn(async move {
            sleep(Duration::from_secs_f64(first_s)).await;
            for _ in 0..3 {
                advance(Duration::from_secs(20)).await;
                sleep(Duration::from_secs_f64(then_s)).await;
            }
        });
        let awake = Awake::watching(Arc::new(|| Duration::ZERO));
        let outcome = scan(&mut devices, &mut run, &Pause::new(), &awake).await;
        task.abort();
        drop(run);
        let day = Slept {
            outcome,
            run: Run::read(&path).unwrap(),
            events: Vec::new(),
            room,
        };
        day.assert_whole(&format!("after {first_s} s, and again after {then_s} s"));
    }
}

#[tokio::test(start_paused = true)]
async fn what_passed_while_the_computer_slept_counts_for_the_lamp() {
    let awake = slept(How::Suspended, STABLE_S + 40.0, 0, |_| {}).await;
    let asleep = slept(How::Suspended, STABLE_S + 40.0, 7200, |_| {}).await;
    asleep.assert_whole("two hours");
    let last = |day: &Slept| {
        day.run
            .readings
            .rows
            .iter()
            .filter_map(|row| row.time_s)
            .fold(0.0, f64::max)
    };
    // A reference visit more, and the visit again.
    let longer = last(&asleep) - last(&awake);
    assert!((7200.0..7230.0).contains(&longer), "{longer}");
    let utc = |day: &Slept| day.run.header.stopped.as_ref().unwrap().utc.clone();
    let (early, late): (jiff::Timestamp, jiff::Timestamp) =
        (utc(&awake).parse().unwrap(), utc(&asleep).parse().unwrap());
    assert!((7200.0..7230.0).contains(&late.duration_since(early).as_secs_f64()));
}

#[tokio::test(start_paused = true)]
async fn what_was_changed_meanwhile_is_found() {
    let lost = slept(How::Stopped, STABLE_S + 40.0, 45, |room| room.axes[1].homed = false).await;
    lost.assert_whole("a drive that lost its reference");
    assert_eq!(lost.all("bench_found")[0]["homed_again"], true);
    let dark = slept(How::Stopped, STABLE_S + 40.0, 45, |room| room.lamp_on = None).await;
    dark.assert_whole("a lamp that went out");
    assert_eq!(dark.all("stable").len(), 2, "warmed up again");
    let shut = slept(How::Stopped, STABLE_S + 40.0, 45, |room| room.shutter_open = false).await;
    shut.assert_whole("a shutter that was closed");
    let moved = slept(How::Stopped, STABLE_S + 40.0, 45, |room| {
        let axis = &mut room.axes[0];
        (axis.to, axis.from, axis.began, axis.ends) = (axis.to + 20_000, axis.to + 20_000, None, None);
    })
    .await;
    moved.assert_whole("an axis that was turned");
}

#[tokio::test(start_paused = true)]
async fn a_computer_that_never_stays_awake_ends_the_scan_and_says_so() {
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan(DAY));
    let awake = Awake::watching(Arc::new(|| Duration::ZERO));
    let task = tokio::spawn(async {
        sleep(Duration::from_secs_f64(STABLE_S + 35.0)).await;
        loop {
            sleep(Duration::from_millis(900)).await;
            advance(Duration::from_secs(5)).await;
        }
    });
    let error = scan(&mut devices, &mut run, &Pause::new(), &awake).await.unwrap_err();
    task.abort();
    assert!(matches!(error, ScanError::Slept { .. }), "{error}");
    assert!(error.to_string().contains("keep the computer awake"), "{error}");
    assert!(at_rest(&room));
    assert!(Run::read(&path).unwrap().header.stopped.unwrap().axes_at_rest);
}

#[tokio::test(start_paused = true)]
async fn a_pause_over_which_the_computer_slept_ends_as_a_pause() {
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan(DAY));
    let pause = Pause::new();
    let requested = pause.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs_f64(STABLE_S + 40.0)).await;
        requested.ask("a test");
        sleep(Duration::from_secs(100)).await;
        advance(Duration::from_hours(1)).await;
        sleep(Duration::from_secs(100)).await;
        requested.end("a test");
    });
    let awake = Awake::watching(Arc::new(|| Duration::ZERO));
    let began = Instant::now();
    let outcome = scan(&mut devices, &mut run, &pause, &awake).await;
    outcome.unwrap();
    assert!(began.elapsed() > Duration::from_secs_f64(STABLE_S + 40.0 + 3600.0) && at_rest(&room));
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    assert_eq!(events.matches("\"slept\"").count(), 1, "{events}");
}
