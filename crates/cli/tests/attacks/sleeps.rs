//! The process is stopped (SIGSTOP, as when a computer sleeps) at any moment of a scan, for longer than any
//! instrument's deadline. It is noticed and said, nobody is blamed, and the record is that of an undisturbed scan.
//!
//!     ISOLUX_ATTACK_ROUNDS=50 cargo test -p isolux --test attacks sleeps -- --nocapture     # 1 s to 120 s, 13 min

use std::time::Duration;

use rand::RngExt as _;

use crate::folder::stated;
use crate::support::{Bench, moment, random, rounds, side_by_side, signal};

/// Stops of the short version, in seconds: below and above the 15 s that a lux meter has for a reading.
const SHORT: [f64; 4] = [1.0, 4.0, 16.5, 20.0];

pub fn stopped_at_any_moment_it_goes_on_and_blames_nobody() {
    let count = rounds(SHORT.len() as u64);
    let noticed = side_by_side(count, |round| one_round(round, count));
    assert!(
        2 * noticed > count,
        "most of the moments are within the scan: {count} scans were stopped, {noticed} times while instruments were in use"
    );
}

/// How often the scan of this round noticed that it had been stopped: once or, before and after its work, never.
fn one_round(round: u64, count: u64) -> u64 {
    let mut random = random(3000 + round);
    let after = moment(&mut random, Duration::ZERO, Duration::from_secs(28));
    // As many short ones as long ones.
    let drawn_s = 120_f64.powf(random.random_range(0.0..1.0));
    let length_s = if count > SHORT.len() as u64 {
        drawn_s
    } else {
        SHORT[round as usize]
    };
    let what = format!("round {round}: after {after:.2?} for {length_s:.2} s");
    let bench = Bench::new();
    let scan = bench.scan("--out", "run");
    std::thread::sleep(after);
    signal(&scan, "STOP");
    std::thread::sleep(Duration::from_secs_f64(length_s));
    signal(&scan, "CONT");
    let words = stated(scan.wait_with_output().unwrap(), Some(0));
    assert!(!words.contains("no answer"), "{what}: {words}");
    bench.assert_complete("run");
    bench.assert_true("run");
    bench.assert_at_rest();
    for row in bench.rows("run") {
        let integration_s: f64 = row["integration_s"].parse().unwrap();
        assert!(integration_s < 2.0, "{what}: read while it was stopped: {row:?}");
    }
    let events = bench.read("run/events.jsonl");
    let slept: Vec<&str> = events.lines().filter(|line| line.contains("\"slept\"")).collect();
    if let [line] = slept[..] {
        let (_, rest) = line.split_once("\"slept_s\":").unwrap();
        let slept_s: f64 = rest.split([',', '}']).next().unwrap().parse().unwrap();
        assert!(slept_s > length_s - 0.2, "{what}: {line}");
    } else {
        assert!(slept.is_empty(), "{what}: {slept:?}");
    }
    slept.len() as u64
}
