//! Sweeps on a bench of fakes, in virtual time: no reading of another place, and the axes at rest after every end.

use std::time::Duration;

use camino::Utf8Path;
use isolux_record::plan::{Plan, RINGS, Way};
use isolux_record::run::{Run, RunDir, StopHow};
use isolux_record::{Event, Role, Station};
use tokio::time::{Instant, sleep};

use super::ScanSummary;
use super::tests::at_rest;
use crate::awake::Awake;
use crate::cancel::Cancel;
use crate::devices::Devices;
use crate::error::{ScanError, ScanErrorKind};
use crate::pause::Pause;
use crate::testing::{Shared, bench, header, plan, run_dir, station_with, unobserved};

/// Two half-planes; a conversion of half a second is 5° at 10 °/s.
const SWEEPS: &str = r#"
[[block]]
name = "lit"
kind = "lit"
mode = "sweep"
speed_deg_s = 10.0
c_deg = [0, 90]
gamma_range = [-90, 90, 15]
reference_every = 3
"#;

fn station() -> Station {
    station_with("peak_cd = 1000.0")
}

async fn scan(
    devices: &mut Devices,
    plan: &Plan,
    run: &mut RunDir,
    cancel: &Cancel,
    resumed: Option<&Run>,
) -> Result<ScanSummary, ScanError> {
    unobserved(&station(), &Pause::new(), &Awake::unwatched())
        .run(devices, plan, run, cancel, resumed)
        .await
}

/// Every conversion with a number was taken between its instants at a place on the way, with the light on and open.
fn assert_true(run: &Run, room: &Shared, what: &str) {
    let room = room.lock().unwrap();
    for sweep in &run.sweeps {
        assert!(sweep.light.len() > 10 && sweep.positions.len() > 100, "{what}");
        for sample in sweep.light.iter().filter(|sample| sample.illuminance_lx.is_some()) {
            let taken = &room.looks[usize::from_str_radix(&sample.raw, 16).unwrap()];
            assert!(
                taken.lamp_on && taken.shutter_open && !taken.baffle_in,
                "{what}: {taken:?}"
            );
            let [c, gamma] = taken.axes.map(|steps| steps as f64 / 1000.0);
            let (moving, rests, rested) = match sweep.of.way() {
                Way::HalfPlane { c_deg, .. } => (gamma, c, c_deg),
                Way::Ring { gamma_deg, .. } => (c, gamma, gamma_deg),
            };
            // The fake sees the light of the end of its conversion.
            let near = sweep.positions.iter().min_by(|a, b| {
                let off = |at: f64| (at - sample.answered_s).abs();
                off(a.answered_s).total_cmp(&off(b.answered_s))
            });
            assert!(
                (near.unwrap().place_deg - moving).abs() < 0.4,
                "{what}: {sample:?} in {taken:?}"
            );
            assert!((rests - rested).abs() < 0.011, "{what}");
        }
    }
}

/// How much the light changes around C where half-planes are chosen.
const UNEVEN: f64 = 0.3;

/// The same with half-planes that are chosen.
fn chosen() -> Plan {
    let text = SWEEPS.replace(
        "c_deg = [0, 90]",
        "c_range = [0, 150, 30]\ntarget = { u_map_rel = 0.02 }",
    );
    plan(&text)
}

/// (C, γ) from and to of every sweep.
fn ways(run: &Run) -> Vec<Way> {
    run.sweeps.iter().map(|sweep| sweep.of.way()).collect()
}

#[tokio::test(start_paused = true)]
async fn half_planes_are_chosen_by_rings_and_the_events_say_why() {
    let (mut devices, room) = bench();
    room.lock().unwrap().uneven = UNEVEN;
    let plan = chosen();
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert!(at_rest(&room));
    drop(run);
    let run = Run::read(&path).unwrap();
    let rings = ways(&run).iter().filter(|way| way.half_plane_deg().is_none()).count();
    assert_eq!(rings, RINGS);
    assert_eq!(summary.points, run.sweeps.len() as u64, "what is left out is no point");
    let planes: Vec<f64> = ways(&run)[4..].iter().filter_map(Way::half_plane_deg).collect();
    assert_eq!(planes[0], 90.0, "before the rings");
    assert!(planes.len() > 1, "the light of the fake changes over C: {planes:?}");
    let events = isolux_record::event::read(&path);
    let said = events.iter().filter_map(|logged| match &logged.event {
        Event::HalfPlanes { c_deg, reason, .. } => Some((c_deg.clone(), reason.clone())),
        _ => None,
    });
    let said: Vec<_> = said.collect();
    assert!(
        said[0].1.contains("of the 4 rings") && said[0].0.contains(&planes[1]),
        "{said:?}"
    );
    assert_true(&run, &room, "chosen");
}

#[tokio::test(start_paused = true)]
async fn rings_show_first_whether_the_symmetry_of_a_plan_holds() {
    let text = SWEEPS
        .replace("c_deg = [0, 90]", "c_range = [0, 90, 30]\nsymmetry_max_rel = 0.02")
        .replace("[-90, 90, 15]", "[0, 90, 15]");
    let plan = plan(&text);
    for (uneven, holds) in [(0.0, true), (UNEVEN, false)] {
        let (mut devices, room) = bench();
        room.lock().unwrap().uneven = uneven;
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await;
        assert!(at_rest(&room));
        drop(run);
        let read = Run::read(&path).unwrap();
        let rings: Vec<bool> = ways(&read).iter().map(|way| way.half_plane_deg().is_none()).collect();
        assert_eq!(rings[..=RINGS], [false, true, true, true, true]);
        let is_symmetry = |logged: &isolux_record::Logged| matches!(logged.event, Event::Symmetry { .. });
        assert_eq!(
            isolux_record::event::read(&path)
                .into_iter()
                .filter(is_symmetry)
                .count(),
            1
        );
        if holds {
            outcome.unwrap();
            assert_eq!(rings.len(), 4 + RINGS + 3);
            continue;
        }
        // The fake has three lobes: about no plane the same.
        let error = outcome.unwrap_err();
        assert_eq!(error.kind(), ScanErrorKind::NotAccepted, "{error}");
        assert!(error.to_string().contains("about both planes"), "{error}");
        assert_eq!(rings.len(), 1 + RINGS, "no half-plane is swept for nothing");
        // Taken up again it says the same.
        let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
        let again = scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old)).await;
        assert_eq!(again.unwrap_err().kind(), ScanErrorKind::NotAccepted);
    }
    let round = SWEEPS.replace("c_deg = [0, 90]", "c_range = [0, 150, 30]\nsymmetry_max_rel = 0.02");
    let (mut devices, _room) = bench();
    let plan = crate::testing::plan(&round);
    let (_keep, _path, mut run) = run_dir(&devices, &plan);
    let refused = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(refused.to_string().contains("assume no symmetry"), "{refused}");
}

#[tokio::test(start_paused = true)]
async fn ended_at_any_moment_the_same_half_planes_are_chosen() {
    let plan = chosen();
    let whole = {
        let (mut devices, room) = bench();
        room.lock().unwrap().uneven = UNEVEN;
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
        ways(&Run::read(&path).unwrap())
    };
    assert!(whole.len() > 4 + 1 + RINGS);
    let mut moment = 1840.0;
    while moment < 2200.0 {
        let (mut devices, room) = bench();
        room.lock().unwrap().uneven = UNEVEN;
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            signal.cancel("SIGTERM");
        });
        let outcome = scan(&mut devices, &plan, &mut run, &cancel, None).await;
        assert!(at_rest(&room), "{moment}");
        drop(run);
        if outcome.is_err() {
            let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
            scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old))
                .await
                .unwrap();
        }
        assert_eq!(ways(&Run::read(&path).unwrap()), whole, "{moment}");
        moment += 13.7;
    }
}

/// The light of the fake is nowhere dark: all of it is beam.
#[tokio::test(start_paused = true)]
async fn ended_in_a_second_sweep_it_is_made_again_and_no_other() {
    let plan = plan(&SWEEPS.replace("speed_deg_s = 10.0", "speed_deg_s = 10.0\nbeam_speed_deg_s = 5.0"));
    let whole = {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
        assert!(at_rest(&room));
        drop(run);
        let run = Run::read(&path).unwrap();
        assert_true(&run, &room, "second sweeps");
        let slow = run.sweeps.iter().filter(|sweep| sweep.of.speed_deg_s == 5.0).count();
        assert_eq!(
            (run.sweeps.len(), slow),
            (3 + 3, 3),
            "both ways in the first half-plane"
        );
        let said = isolux_record::event::read(&path).into_iter();
        let said =
            said.filter(|logged| matches!(&logged.event, Event::SecondSweep { reason, .. } if reason.contains("10 %")));
        assert_eq!(said.count(), slow);
        ways(&run)
    };
    let (mut moment, mut cut_in_second) = (1900.0, 0);
    while moment < 2060.0 {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            signal.cancel("SIGTERM");
        });
        let outcome = scan(&mut devices, &plan, &mut run, &cancel, None).await;
        assert!(at_rest(&room), "{moment}");
        drop(run);
        if outcome.is_err() {
            let cut = Run::read(&path).unwrap().sweeps.len();
            cut_in_second += u32::from((3..whole.len()).contains(&cut));
            let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
            scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old))
                .await
                .unwrap();
        }
        let run = Run::read(&path).unwrap();
        assert_eq!(ways(&run), whole, "{moment}");
        assert_eq!(checks(&run).len(), 10, "{moment}");
        moment += 9.7;
    }
    assert!(cut_in_second > 3, "{cut_in_second}");
}

fn points(run: &Run) -> Vec<u64> {
    run.sweeps.iter().map(|sweep| sweep.of.point).collect()
}

/// Directions that were read at rest after the sweeps.
fn checks(run: &Run) -> Vec<(f64, f64)> {
    let rows = run.readings.rows.iter().filter(|row| row.role == Role::Check);
    rows.map(|row| (row.c_target_deg, row.gamma_target_deg)).collect()
}

#[tokio::test(start_paused = true)]
async fn a_block_of_sweeps_is_recorded_sweep_by_sweep() {
    let (mut devices, room) = bench();
    let plan = plan(SWEEPS);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert_eq!((summary.points, summary.visits_again), (5, 0));
    assert!(at_rest(&room));
    drop(run);
    let run = Run::read(&path).unwrap();
    assert_eq!(points(&run), [0, 1, 2, 3, 4]);
    assert_true(&run, &room, "undisturbed");
    let references = run.readings.rows.iter().filter(|row| row.role == Role::Reference);
    assert_eq!(
        references.count(),
        3,
        "before the first sweep, the fourth, and at the end"
    );
    assert_eq!(checks(&run).len(), 10);
    let signs: Vec<f64> = run.sweeps.iter().map(|sweep| sweep.of.gamma_deg[1].signum()).collect();
    assert_eq!(signs, [1.0, -1.0, 1.0, -1.0, 1.0]);
    assert_eq!(run.sweeps[2].of.speed_deg_s, 5.0);
}

#[tokio::test(start_paused = true)]
async fn ended_at_any_moment_the_axes_rest_and_the_next_sweep_follows() {
    let plan = plan(SWEEPS);
    let mut moment = 1830.0;
    while moment < 1990.0 {
        let (mut devices, room) = bench();
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let cancel = Cancel::new();
        let signal = cancel.clone();
        tokio::spawn(async move {
            sleep(Duration::from_secs_f64(moment)).await;
            signal.cancel("SIGTERM");
        });
        let outcome = scan(&mut devices, &plan, &mut run, &cancel, None).await;
        assert!(at_rest(&room), "{moment}");
        drop(run);
        if let Err(error) = outcome {
            assert_eq!(error.kind(), ScanErrorKind::Interrupted, "{moment}: {error}");
            let cut = Run::read(&path).unwrap();
            assert!(cut.header.stopped.as_ref().unwrap().axes_at_rest);
            assert_true(&cut, &room, &format!("cut after {moment} s"));
            let (mut run, old) = RunDir::resume(&path, &header(&devices, &plan)).unwrap();
            scan(&mut devices, &plan, &mut run, &Cancel::new(), Some(&old))
                .await
                .unwrap();
            drop(run);
            let whole = Run::read(&path).unwrap();
            assert_eq!(whole.sweeps[..cut.sweeps.len()], cut.sweeps[..]);
            assert_eq!(checks(&whole)[..checks(&cut).len()], checks(&cut)[..]);
        }
        let whole = Run::read(&path).unwrap();
        assert_eq!(points(&whole), [0, 1, 2, 3, 4], "{moment}");
        // Drawn by the sweeps alone: taken up again they are the same ten.
        let mut at_rest = checks(&whole);
        at_rest.sort_by(|a, b| a.partial_cmp(b).unwrap());
        at_rest.dedup();
        assert_eq!((checks(&whole).len(), at_rest.len()), (10, 10), "{moment}");
        assert_true(&whole, &room, &format!("resumed after {moment} s"));
        moment += 4.7;
    }
}

#[tokio::test(start_paused = true)]
async fn an_axis_that_stalls_in_a_sweep_is_stopped_and_what_there_was_is_evidence() {
    let (mut devices, room) = bench();
    let plan = plan(SWEEPS);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    // 90° and a run-out of 10²/80 + 2.5°.
    room.lock().unwrap().stall_at_deg = Some(93.75);
    let begun = Instant::now();
    let error = scan(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap_err();
    assert!(matches!(error, ScanError::Device { role: "axis.gamma", .. }), "{error}");
    assert!(at_rest(&room));
    assert!(
        begun.elapsed() < Duration::from_secs(2000),
        "by the deadline of the move"
    );
    drop(run);
    let run = Run::read(&path).unwrap();
    assert_eq!((run.sweeps.len(), run.header.sweep.len()), (0, 1));
    assert!(run.header.sweep[0].torn && run.header.sweep[0].samples > 5);
    assert_eq!(run.header.stopped.unwrap().how, StopHow::Failed);
    assert!(
        run.notices.iter().any(|notice| notice.contains("torn sweep")),
        "{:?}",
        run.notices
    );
}

#[tokio::test(start_paused = true)]
async fn a_hand_on_the_shutter_tears_a_sweep_and_it_is_made_again() {
    let (mut devices, room) = bench();
    let plan = plan(SWEEPS);
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let hand = room.clone();
    tokio::spawn(async move {
        // In the first sweep.
        sleep(Duration::from_secs(1845)).await;
        hand.lock().unwrap().shutter_open = false;
    });
    let summary = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
    assert_eq!(summary.visits_again, 1);
    drop(run);
    let run = Run::read(&path).unwrap();
    assert_eq!(points(&run), [0, 1, 2, 3, 4]);
    let torn: Vec<u64> = run
        .header
        .sweep
        .iter()
        .filter(|entry| entry.torn)
        .map(|entry| entry.index)
        .collect();
    assert_eq!(torn, [0]);
    assert_true(&run, &room, "after the hand");
}

#[tokio::test(start_paused = true)]
async fn what_the_bench_cannot_sweep_is_refused_before_motion() {
    for (from, to, word) in [
        ("speed_deg_s = 10.0", "speed_deg_s = 30.0", "more than the γ axis does"),
        ("[-90, 90, 15]", "[-180, 180, 15]\nlimit = 1", "unknown field"),
        ("[-90, 90, 15]", "[-183, 183, 3]", "outside"),
        ("[-90, 90, 15]", "[-180, 180, 15]", ""),
        ("[-90, 90, 15]", "[-90, 90, 1]", "1.8 °/s would do"),
    ] {
        let text = format!("{}{}", crate::testing::PLAN_HEAD, SWEEPS.replace(from, to));
        let plan = match Plan::parse(Utf8Path::new("p.toml"), &text) {
            Ok(plan) => plan,
            Err(error) => {
                assert!(error.to_string().contains(word), "{to}: {error}");
                continue;
            }
        };
        let (mut devices, room) = bench();
        let (_keep, _path, mut run) = run_dir(&devices, &plan);
        let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await;
        match outcome {
            Ok(_) => assert!(word.is_empty(), "{to}"),
            Err(error) => {
                assert!(!word.is_empty() && error.to_string().contains(word), "{to}: {error}");
                assert_eq!(error.kind(), ScanErrorKind::BadPlan);
                assert!(
                    room.lock().unwrap().axes.iter().all(|axis| axis.began.is_none()),
                    "nothing moved"
                );
            }
        }
    }
}
