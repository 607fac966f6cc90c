//! The program is killed or asked to end at any moment of a scan. What was read stays, the axes rest, and the scan is
//! resumed to its end: every row once.

use std::time::Duration;

use rand::RngExt as _;

use crate::folder::stated;
use crate::support::{Bench, LONG_PLAN, ended, hear_hangups, moment, random, rounds, signal, wait_until};

/// Signals that the program can answer.
const ASKED: [&str; 4] = ["TERM", "HUP", "QUIT", "INT"];

pub fn every_signal_stops_the_axes_and_says_so_in_the_record() {
    hear_hangups();
    let bench = Bench::on_request();
    bench.write("plan.toml", LONG_PLAN);
    for (k, name) in ASKED.into_iter().enumerate() {
        let how = if k == 0 { "--out" } else { "--resume" };
        let before = bench.rows("run").len();
        let scan = bench.scan(how, "run");
        // Two more rows each, then the signal: in the middle of the next point. A resumed scan begins at the reference
        // point.
        bench.wait_for_rows("run", before + 2);
        wait_until("an axis moves", || bench.moves(1) || bench.moves(2));
        signal(&scan, name);
        let words = stated(ended(scan), Some(130));
        assert!(
            words.contains(&format!("SIG{name}")) && words.contains("--resume"),
            "{words}"
        );
        bench.assert_at_rest();
        bench.assert_stopped("run", "interrupted");
        bench.assert_once("run");
        bench.assert_true("run");
    }
}

pub fn a_hangup_that_is_ignored_stays_so() {
    let bench = Bench::new();
    // What nohup does.
    let program = env!("CARGO_BIN_EXE_isolux");
    let line = format!("trap '' HUP; exec {program} scan station.toml plan.toml --out run");
    let mut command = std::process::Command::new("sh");
    command.args(["-c", &line]).current_dir(bench.path(""));
    let scan = command.stdin(std::process::Stdio::null()).spawn().unwrap();
    bench.wait_for_rows("run", 2);
    signal(&scan, "HUP");
    let status = scan.wait_with_output().unwrap().status;
    assert_eq!(status.code(), Some(0));
    bench.assert_complete("run");
}

pub fn killed_again_and_again_it_comes_to_its_end() {
    hear_hangups();
    for round in 0..rounds(1) {
        let mut random = random(2000 + round);
        let bench = Bench::new();
        let mut begun = false;
        for _ in 0..3 {
            let how = if begun { "--resume" } else { "--out" };
            let mut scan = bench.scan(how, "run");
            std::thread::sleep(moment(&mut random, Duration::ZERO, Duration::from_secs(14)));
            // Two of three die without a word.
            let name = if random.random_bool(2.0 / 3.0) {
                "KILL"
            } else {
                ASKED[random.random_range(0..4)]
            };
            let before = bench.rows("run").len();
            signal(&scan, name);
            let status = scan.wait().unwrap();
            match status.code() {
                // It was killed; a signal that it could have answered came before it listened, so before it did
                // anything.
                None => assert!(name == "KILL" || bench.rows("run").len() == before, "{name}: {status}"),
                Some(0) => bench.assert_complete("run"),
                code => assert!(name != "KILL" && code == Some(130), "{name}: {status}"),
            }
            bench.isolux(&["stop", "station.toml"], 0);
            bench.assert_at_rest();
            begun = bench.path("run/run.toml").exists();
        }
        let how = if begun { "--resume" } else { "--out" };
        stated(bench.scan(how, "run").wait_with_output().unwrap(), Some(0));
        bench.assert_complete("run");
        bench.assert_true("run");
    }
}
