//! A second process at a bench that is being scanned: it is refused, whatever it wants and however it names the bench.
//! Only `stop` gets through, also when the scan hangs or is dead.

#![expect(
    clippy::print_stdout,
    reason = "how long a stop took is for the person who runs this"
)]

use std::process::Child;
use std::time::{Duration, Instant};

use crate::folder::stated;
use crate::support::{Bench, LONG_PLAN, ended, moment, random, rounds, signal, wait_until};

/// The axes of this station creep: a whole turn takes minutes, so that a stop meets them far from where they were sent.
fn slow(bench: &Bench) {
    let station = bench.read("station.toml");
    bench.write(
        "slow.toml",
        &station.replace("speed_deg_s = 400.0", "speed_deg_s = 2.0"),
    );
}

/// The same instruments under other names.
fn other_names(bench: &Bench) {
    let station = bench.read("station.toml");
    assert!(station.contains("tcp://127.0.0.1:"));
    bench.write("other.toml", &station.replace("tcp://127.0.0.1:", "tcp://localhost:"));
}

/// Starts a move of γ over 300° at 2°/s and waits until the axis is on its way.
fn long_move(bench: &Bench) -> Child {
    slow(bench);
    bench.isolux(&["home", "station.toml"], 0);
    let mover = bench.start(&["move", "slow.toml", "--gamma", "300"]);
    wait_until("the axis moves", || bench.moves(2));
    mover
}

/// The axis rests, far from where it was sent.
fn assert_stopped_short(bench: &Bench) {
    bench.assert_at_rest();
    let answer = bench.tell_axes("1 2 get pos");
    let count = answer.split_whitespace().nth(5).unwrap();
    let count: f64 = count.split(':').next().unwrap().parse().unwrap();
    assert!(count * 3.0 / 12_800.0 < 200.0, "{answer}");
}

pub fn nobody_else_gets_at_a_bench_that_is_scanned() {
    for round in 0..rounds(1) {
        let mut random = random(round);
        let bench = Bench::new();
        bench.write("plan.toml", LONG_PLAN);
        other_names(&bench);
        let scan = bench.scan("--out", "run");
        let who = format!("pid {}", scan.id());
        wait_until("the run begins", || bench.path("run/run.toml").exists());
        std::thread::sleep(moment(&mut random, Duration::ZERO, Duration::from_secs(10)));
        for station in ["station.toml", "other.toml"] {
            for command in [
                &["check", station][..],
                &["home", station],
                &["move", station, "--c", "0", "--gamma", "0"],
                &["read", station],
                &["warmup", station],
                &["scan", station, "plan.toml", "--out", "second"],
                &["read", station, "--force", "it works all the same"],
            ] {
                let words = bench.isolux(command, 3);
                assert!(words.contains(&who) && words.contains("isolux stop"), "{words}");
            }
        }
        for how in ["--resume", "--force"] {
            let resume = ["scan", "station.toml", "plan.toml", "--resume", "run"];
            let force = ["--force", "impatience"];
            let more = if how == "--force" { &force[..] } else { &[] };
            let words = bench.isolux(&[&resume[..], more].concat(), 3);
            assert!(words.contains(&who) && words.contains("run is in use"), "{words}");
        }
        let words = bench.isolux(&["reduce", "run"], 3);
        assert!(words.contains(&who), "{words}");
        assert!(!bench.path("second").exists(), "nothing is left of what was refused");
        // The scan goes on as if nobody had asked.
        bench.wait_for_rows("run", bench.rows("run").len() + 2);
        signal(&scan, "TERM");
        stated(ended(scan), Some(130));
        bench.assert_once("run");
        bench.assert_true("run");
        bench.assert_at_rest();
        // Nobody has it any more.
        bench.isolux(&["read", "other.toml"], 0);
    }
}

pub fn of_two_scans_that_begin_at_once_no_row_is_wrong() {
    for round in 0..rounds(1) {
        let mut random = random(1000 + round);
        let bench = Bench::new();
        other_names(&bench);
        let first = bench.scan("--out", "a");
        std::thread::sleep(moment(&mut random, Duration::ZERO, Duration::from_millis(20)));
        let second = bench.start(&["scan", "other.toml", "plan.toml", "--out", "b"]);
        let ended = [first, second].map(|scan| scan.wait_with_output().unwrap());
        let won = usize::from(ended[0].status.code() != Some(0));
        let [a, b] = ended;
        let (winner, loser) = if won == 0 { (a, b) } else { (b, a) };
        stated(winner, Some(0));
        let words = stated(loser, Some(3));
        assert!(words.contains("in use by"), "{words}");
        let run = ["a", "b"][won];
        assert!(!bench.path(["b", "a"][won]).exists(), "the other wrote nothing");
        bench.assert_complete(run);
        bench.assert_true(run);
    }
}

pub fn stop_ends_a_scan_that_works_and_the_scan_says_so() {
    let bench = Bench::new();
    bench.write("plan.toml", LONG_PLAN);
    for how in ["--out", "--resume"] {
        let before = bench.rows("run").len();
        let scan = bench.scan(how, "run");
        bench.wait_for_rows("run", before + 2);
        let words = bench.isolux(&["stop", "station.toml"], 0);
        assert!(words.contains("at rest") && words.contains("and ended"), "{words}");
        let words = stated(ended(scan), Some(130));
        assert!(words.contains("SIGTERM"), "{words}");
        bench.assert_at_rest();
        bench.assert_stopped("run", "interrupted");
        bench.assert_once("run");
        bench.assert_true("run");
    }
}

pub fn stop_gets_through_while_its_owner_is_suspended_and_the_owner_drives_no_more() {
    let bench = Bench::new();
    let mover = long_move(&bench);
    signal(&mover, "STOP");
    let began = Instant::now();
    let words = bench.isolux(&["stop", "station.toml"], 0);
    println!("stopped {:?} after it was asked for", began.elapsed());
    assert!(
        words.contains("suspended") && words.contains("taken from it"),
        "{words}"
    );
    assert_stopped_short(&bench);
    // It has the signal and the link still, and no right to use it.
    signal(&mover, "CONT");
    let words = stated(mover.wait_with_output().unwrap(), Some(3));
    assert!(words.contains("taken over"), "{words}");
    assert!(!words.contains("BY HAND"), "another process has the axes: {words}");
    assert_stopped_short(&bench);
    bench.isolux(&["read", "station.toml"], 0);
}

pub fn stop_gets_through_after_its_owner_was_killed() {
    let bench = Bench::new();
    let mut mover = long_move(&bench);
    signal(&mover, "KILL");
    mover.wait().unwrap();
    assert!(bench.moves(2), "a killed program stops nothing");
    let began = Instant::now();
    let words = bench.isolux(&["stop", "station.toml"], 0);
    println!("stopped {:?} after it was asked for", began.elapsed());
    assert!(!words.contains("pid"), "a dead owner is no owner: {words}");
    assert_stopped_short(&bench);
}

pub fn a_scan_that_hangs_is_taken_over_with_a_reason_and_writes_nothing_more() {
    let bench = Bench::on_request();
    let hung = bench.scan("--out", "run");
    bench.wait_for_rows("run", 2);
    signal(&hung, "STOP");
    let resume = ["scan", "station.toml", "plan.toml", "--resume", "run"];
    bench.isolux(&resume, 3);
    let force = [&resume[..], &["--force", "the scan hangs since the power dip"]].concat();
    // It counts as hung after five seconds without a sign of life.
    let taker = loop {
        let taker = bench.start(&force).wait_with_output().unwrap();
        if taker.status.code() != Some(3) {
            break taker;
        }
        std::thread::sleep(Duration::from_millis(200));
    };
    stated(taker, Some(0));
    bench.assert_complete("run");
    let before = ["run.toml", "readings.csv", "events.jsonl"].map(|file| bench.read(&format!("run/{file}")));
    assert!(
        before[2].contains("taken_over") && before[2].contains("since the power dip"),
        "{}",
        before[2]
    );
    signal(&hung, "CONT");
    let words = stated(hung.wait_with_output().unwrap(), Some(3));
    assert!(
        words.contains("taken over") && words.contains("up to that process"),
        "{words}"
    );
    for word in ["BY HAND", "--resume"] {
        assert!(!words.contains(word), "another scan drives the axes: {words}");
    }
    let after = ["run.toml", "readings.csv", "events.jsonl"].map(|file| bench.read(&format!("run/{file}")));
    assert_eq!(before, after);
    bench.assert_true("run");
    bench.assert_at_rest();
}
