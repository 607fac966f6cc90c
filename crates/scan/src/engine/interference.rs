//! Hands on axes and outputs behind the engine's back: nothing that was read meanwhile is recorded as sound.

use std::time::Duration;

use isolux_record::run::{Run, RunDir, StopHow};
use isolux_record::{Plan, Quality, ReadingKind, Role};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::time::{Instant, sleep};

use super::tests::{DAY, at_rest, scan};
use super::visit::TRIES;
use crate::cancel::Cancel;
use crate::error::{ScanError, ScanErrorKind};
use crate::testing::{AxisDrive, Room, Shared, bench, header, plan, run_dir};

/// What a hand does.
#[derive(Debug, Clone, Copy)]
enum Hand {
    /// γ stands elsewhere at once.
    Gamma,
    /// C is driven away in two seconds.
    DriveC,
    /// γ is driven away and back within half a second.
    ThereAndBack,
    Shutter,
    Baffle,
    Lamp,
}

const HANDS: [Hand; 6] = [
    Hand::Gamma,
    Hand::DriveC,
    Hand::ThereAndBack,
    Hand::Shutter,
    Hand::Baffle,
    Hand::Lamp,
];

fn drive(room: &mut Room, axis: usize, by: i64, seconds: f64) {
    let now = Instant::now();
    let from = room.axes[axis].steps(now);
    room.axes[axis] = AxisDrive {
        from,
        to: from + by,
        began: Some(now),
        ends: Some(now + Duration::from_secs_f64(seconds)),
        ..room.axes[axis]
    };
}

async fn act(hand: Hand, room: &Shared) {
    {
        let mut room = room.lock().unwrap();
        match hand {
            Hand::Gamma => drive(&mut room, 1, 20_000, 0.0),
            Hand::DriveC => drive(&mut room, 0, 20_000, 2.0),
            Hand::ThereAndBack => drive(&mut room, 1, 5_000, 0.25),
            Hand::Shutter => room.shutter_open = !room.shutter_open,
            Hand::Baffle => room.baffle_in = !room.baffle_in,
            Hand::Lamp => {
                room.lamp_on = match room.lamp_on {
                    Some(_) => None,
                    None => Some(Instant::now()),
                }
            }
        }
    }
    if matches!(hand, Hand::ThereAndBack) {
        sleep(Duration::from_millis(250)).await;
        drive(&mut room.lock().unwrap(), 1, -5_000, 0.2);
    }
}

/// Every row and spectrum that calls itself sound was taken at its pose and in its state, by the room's own log.
fn assert_true(run: &Run, room: &Shared, what: &str) {
    let room = room.lock().unwrap();
    for row in run.readings.rows.iter().filter(|row| row.quality == Quality::Ok) {
        let at = usize::from_str_radix(&row.raw, 16).unwrap();
        let taken = &room.looks[at];
        let context = format!("{what}: {row:?} was taken in {taken:?}");
        assert!(
            (taken.axes[0] as f64 / 1000.0 - row.c_target_deg).abs() < 0.0101,
            "{context}"
        );
        assert!(
            (taken.axes[1] as f64 / 1000.0 - row.gamma_target_deg).abs() < 0.0101,
            "{context}"
        );
        let expected = match row.kind {
            ReadingKind::Lit => (true, true, false),
            ReadingKind::Baffled => (true, true, true),
            ReadingKind::LampOff => (false, true, false),
            ReadingKind::Capped => (taken.lamp_on, false, taken.baffle_in),
        };
        assert_eq!(
            (taken.lamp_on, taken.shutter_open, taken.baffle_in),
            expected,
            "{context}"
        );
    }
    for spectrum in &run.spectra {
        let light = 7.0 * 40_000.0 * spectrum.integration_s;
        let pixel = spectrum.pixels[7];
        assert!((pixel.counts - 1500.0 - light).abs() <= 1.0, "{what}: {pixel:?}");
        assert!((pixel.dark_counts - 1500.0).abs() <= 1.0, "{what}: {pixel:?}");
    }
}

fn points(run: &Run) -> Vec<(u64, u32)> {
    run.readings
        .rows
        .iter()
        .filter(|row| row.role == Role::Point)
        .map(|row| (row.point, row.repeat))
        .collect()
}

fn whole(plan: &Plan, run: &Run) {
    let expected: Vec<_> = (0..12)
        .map(|point| (point, 0))
        .chain([(12, 0), (12, 1), (12, 2), (14, 0), (14, 1), (15, 0), (15, 1)])
        .collect();
    assert_eq!(plan.blocks().len(), 5);
    assert_eq!(points(run), expected);
    assert_eq!(run.spectra.len(), 1);
}

#[tokio::test(start_paused = true)]
async fn one_hand_at_any_moment_leaves_no_wrong_row() {
    let plan = plan(DAY);
    let (mut again, mut failed) = (0, 0);
    for round in 0..180_u64 {
        let mut random = ChaCha8Rng::seed_from_u64(round);
        let hand = HANDS[round as usize % HANDS.len()];
        // The warm-up ends at about 1830 s; then a visit takes two seconds.
        let moment = if round < 24 {
            random.random_range(25.0..1825.0)
        } else {
            random.random_range(1823.0..1900.0)
        };
        let what = format!("round {round}, {hand:?} after {moment:.3} s");
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let beside = room.clone();
        let task = tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            act(hand, &beside).await;
        });
        let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await;
        task.abort();
        assert!(at_rest(&room), "{what}");
        drop(run);
        assert_true(&Run::read(&path).unwrap(), &room, &what);
        match outcome {
            Ok(summary) => again += summary.visits_again,
            Err(error) => {
                // A hand in the middle of a move ends the scan, and it is resumed.
                failed += 1;
                assert_eq!(error.kind(), ScanErrorKind::Instrument, "{what}: {error}");
                let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
                let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old)).await;
                assert!(outcome.is_ok(), "{what}: {error}; resumed: {outcome:?}");
            }
        }
        let run = Run::read(&path).unwrap();
        whole(&plan, &run);
        assert_true(&run, &room, &what);
        assert_eq!(run.header.stopped.unwrap().how, StopHow::Completed);
    }
    assert!(again > 60, "{again} visits made again, {failed} scans failed");
}

#[tokio::test(start_paused = true)]
async fn a_hand_that_never_rests_ends_the_scan_and_says_what_it_did() {
    let plan = plan(DAY);
    for (hand, role, found) in [
        (Hand::Shutter, "shutter", "closed"),
        (Hand::Baffle, "baffle", "in the beam"),
        (Hand::Lamp, "lamp", "off"),
        (Hand::Gamma, "axis.gamma", "at "),
    ] {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let beside = room.clone();
        // After the warm-up, each time that the engine has put it right for a while.
        let task = tokio::spawn(async move {
            sleep(Duration::from_secs(1840)).await;
            loop {
                let again = {
                    let room = beside.lock().unwrap();
                    let rests = room.axes.iter().all(|axis| !axis.moving(Instant::now()));
                    match hand {
                        Hand::Shutter => room.shutter_open,
                        Hand::Baffle => !room.baffle_in,
                        Hand::Lamp => room.lamp_on.is_some(),
                        _ => rests,
                    }
                };
                if again {
                    act(hand, &beside).await;
                }
                sleep(Duration::from_millis(700)).await;
            }
        });
        let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
            .await
            .unwrap_err();
        task.abort();
        let stated = error.to_string();
        match &error {
            ScanError::Disturbed {
                role: found_role,
                found: state,
                ..
            } => {
                assert_eq!(*found_role, role);
                assert!(state.starts_with(found), "{stated}");
            }
            ScanError::Device { role: found_role, .. } | ScanError::Position { role: found_role, .. } => {
                assert_eq!((*found_role, role), ("axis.gamma", "axis.gamma"), "{stated}");
            }
            _ => panic!("{stated}"),
        }
        assert_eq!(error.kind(), ScanErrorKind::Instrument);
        assert!(at_rest(&room));
        drop(run);
        let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
        if matches!(error, ScanError::Disturbed { .. }) {
            assert!(
                events.matches("\"event\":\"again\"").count() as u32 >= TRIES - 1,
                "{events}"
            );
        }
        let recorded = Run::read(&path).unwrap();
        assert_eq!(recorded.header.stopped.as_ref().unwrap().how, StopHow::Failed);
        assert_true(&recorded, &room, role);
        let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
        scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old))
            .await
            .unwrap();
        drop(run);
        let run = Run::read(&path).unwrap();
        whole(&plan, &run);
        assert_true(&run, &room, role);
    }
}

#[tokio::test(start_paused = true)]
async fn a_lamp_switched_off_is_warmed_up_again_and_has_a_reference_visit_of_its_own() {
    let plan = plan(DAY);
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let beside = room.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs(1845)).await;
        act(Hand::Lamp, &beside).await;
    });
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert!(summary.duration_s > 3600.0 && summary.visits_again == 1, "{summary:?}");
    drop(run);
    let run = Run::read(&path).unwrap();
    assert_true(&run, &room, "lamp");
    let rows = &run.readings.rows;
    let relit = rows.windows(2).position(|pair| pair[1].lamp_s < pair[0].lamp_s);
    let relit = relit.expect("the clock of the lamp began anew") + 1;
    assert_eq!(rows[relit].role, Role::Reference, "{rows:#?}");
    assert!(rows[relit].lamp_s.unwrap() > 1800.0);
}

#[tokio::test(start_paused = true)]
async fn a_reference_point_that_does_not_come_back_ends_the_scan_with_its_values() {
    let plan = plan(DAY);
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let beside = room.clone();
    tokio::spawn(async move {
        // Among the first six points: the next visit shows it.
        sleep(Duration::from_secs(1830)).await;
        beside.lock().unwrap().dimmed = 0.03;
    });
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    let ScanError::Reference {
        found_lx,
        expected_lx,
        allowed_lx,
        ..
    } = &error
    else {
        panic!("{error}");
    };
    let (found, first) = (found_lx.unwrap(), expected_lx.unwrap());
    assert!(
        (found / first - 0.97).abs() < 0.002 && (allowed_lx - (0.01 * first + 0.01)).abs() < 1e-9,
        "{error}"
    );
    assert_eq!(error.kind(), ScanErrorKind::NotAccepted);
    assert!(at_rest(&room));
    drop(run);
    let run = Run::read(&path).unwrap();
    let last = run.readings.rows.last().unwrap();
    assert_eq!(
        (last.role, last.illuminance_lx),
        (Role::Reference, Some(found)),
        "the reduction must know of it"
    );
    let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
    let count = |name: &str| {
        events
            .lines()
            .filter(|line| line.contains(&format!("\"{name}\"")))
            .count()
    };
    assert_eq!(
        (count("lamp_outside_band"), count("stable")),
        (1, 2),
        "it was waited for"
    );
    // The same lamp, still dimmed: a resumed scan compares with the last visit before and does not go on.
    let (mut dir, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
    let error = scan(&mut devices, &plan, &mut dir, &Cancel::new(), Some(&old))
        .await
        .unwrap_err();
    assert!(matches!(error, ScanError::Reference { .. }), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_drift_within_the_plans_limit_is_no_reason_to_stop() {
    let wide = plan(&format!("[limits]\nreference_rel = 0.05\ndrift_rel = 0.05\n{DAY}"));
    let (mut devices, room) = bench();
    let (_keep, _path, mut run) = run_dir(&devices, &wide);
    let beside = room.clone();
    tokio::spawn(async move {
        sleep(Duration::from_secs(1850)).await;
        beside.lock().unwrap().dimmed = 0.03;
    });
    scan(&mut devices, &wide, &mut run, &Cancel::new(), None).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn repeats_that_do_not_agree_are_measured_again_and_then_refused() {
    let repeats = plan("[[block]]\nname = \"a\"\nkind = \"lit\"\nc_deg = 0\ngamma_deg = [0, 30]\nrepeats = 12\n");
    // A door that is open for a second, and light that flickers for ever.
    for (seconds, expected) in [(1.0, true), (1e6, false)] {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &repeats);
        let beside = room.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs(1836)).await;
            let until = Instant::now() + Duration::from_secs_f64(seconds);
            while Instant::now() < until {
                beside.lock().unwrap().dimmed = -0.05;
                sleep(Duration::from_millis(600)).await;
                beside.lock().unwrap().dimmed = 0.0;
                sleep(Duration::from_millis(2100)).await;
            }
        });
        let outcome = scan(&mut devices, &repeats, &mut run, &Cancel::new(), None).await;
        drop(run);
        let rows = Run::read(&path).unwrap().readings.rows;
        match outcome {
            Ok(summary) => {
                assert!(expected && summary.visits_again == 1, "{summary:?}");
                assert_eq!(rows.len(), 24);
            }
            Err(error) => {
                assert!(!expected, "{error}");
                assert!(matches!(error, ScanError::Repeats { .. }), "{error}");
                assert_eq!(error.kind(), ScanErrorKind::NotAccepted);
            }
        }
        let around = |gamma: f64| rows.iter().filter(move |row| row.gamma_target_deg == gamma);
        for gamma in [0.0, 30.0] {
            let lux: Vec<f64> = around(gamma).filter_map(|row| row.illuminance_lx).collect();
            assert!(lux.iter().all(|value| (value / lux[0] - 1.0).abs() < 0.01), "{lux:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_dark_detector_is_not_a_stable_lamp() {
    let plan = plan(DAY);
    let (mut devices, room) = bench();
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    // The blade is stuck: the output says open and no light comes through but 0.05 lx of offset.
    room.lock().unwrap().stuck_shut = true;
    let begun = Instant::now();
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(matches!(error, ScanError::NoLight { .. }), "{error}");
    assert!(
        begun.elapsed() < Duration::from_mins(3),
        "a minute of darkness is enough"
    );
    assert!(at_rest(&room));
    assert!(Run::read(&path).unwrap().readings.rows.is_empty());
}
