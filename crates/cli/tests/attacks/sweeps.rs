//! The program is killed in the middle of a sweep. The axis comes to rest inside its limits by itself, the scan is
//! resumed, and at most the sweep that was cut is made again.

use std::time::Duration;

use crate::folder::stated;
use crate::support::{Bench, moment, random, rounds, signal, wait_until};

/// Six sweeps of six half-planes at 45 °/s, and ten directions at rest: three quarters of a minute in real time.
const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
mode = "sweep"
speed_deg_s = 45.0
c_range = [0, 120, 60]
gamma_range = [-90, 90, 10]
reference_every = 3
"#;
const SWEEPS: usize = 6;

fn bench() -> Bench {
    let bench = Bench::on_request();
    let station = bench.read("station.toml");
    // What the plan does not measure: the room has none of it.
    let bounds = "[bench]\nstray_max_rel = 1e-6\nambient_max_lx = 1e-6\ndark_max_lx = 1e-6";
    bench.write("station.toml", &station.replace("[bench]", bounds));
    bench.write("plan.toml", PLAN);
    bench
}

/// The whole sweeps of a run, each as it lies on the disk.
fn sweeps(bench: &Bench, run: &str) -> Vec<String> {
    let file = |k: usize| std::fs::read_to_string(bench.path(run).join(format!("sweeps/{k:03}.csv"))).ok();
    (0..).map_while(file).collect()
}

/// γ by the count of its controller, degrees.
fn gamma_deg(bench: &Bench) -> f64 {
    let answer = bench.tell_axes("1 2 get pos");
    // A checksum may follow behind a colon.
    let stated = answer.split_whitespace().last().unwrap().split(':').next().unwrap();
    let counts: f64 = stated.parse().unwrap_or_else(|_| panic!("{answer}"));
    counts / counts_per_deg(&bench.read("station.toml"))
}

fn counts_per_deg(station: &str) -> f64 {
    let (_, gamma) = station.split_once("[axis.gamma]").unwrap();
    let (_, rest) = gamma.split_once("counts_per_deg = \"").unwrap();
    let (above, below) = rest.split_once('"').unwrap().0.split_once('/').unwrap();
    above.parse::<f64>().unwrap() / below.parse::<f64>().unwrap()
}

/// Flux and twice the uncertainty of its parts, lm; without γ above 90° it has no U of its own.
fn flux_lm(bench: &Bench, run: &str) -> (f64, f64) {
    bench.isolux(&["reduce", run], 0);
    let budget = bench.json(&format!("{run}/results/budget.json"));
    let number = |key: &str| budget["flux"][key].as_f64().unwrap_or_else(|| panic!("{budget:#}"));
    (number("value"), 2.0 * number("u_of_parts"))
}

pub fn killed_in_a_sweep_at_most_that_sweep_is_made_again() {
    for round in 0..rounds(1) {
        let mut random = random(3000 + round);
        let bench = bench();
        // Another sweep each round.
        let made = (2 + round as usize) % SWEEPS;
        let scan = bench.scan("--out", "run");
        wait_until("a sweep before is whole", || {
            sweeps(&bench, "run").len() >= made && bench.path("run/run.toml").exists()
        });
        wait_until("γ is on its way", || bench.moves(2) && gamma_deg(&bench).abs() < 80.0);
        std::thread::sleep(moment(&mut random, Duration::ZERO, Duration::from_secs(3)));
        signal(&scan, "KILL");
        assert_eq!(scan.wait_with_output().unwrap().status.code(), None);
        // Nobody stops it: it has its target.
        wait_until("both axes rest", || !bench.moves(1) && !bench.moves(2));
        let rests = gamma_deg(&bench);
        assert!(rests.abs() <= 180.0, "{rests}");
        let cut = sweeps(&bench, "run");
        assert!((made..SWEEPS).contains(&cut.len()), "{}", cut.len());

        stated(bench.scan("--resume", "run").wait_with_output().unwrap(), Some(0));
        bench.assert_at_rest();
        bench.assert_stopped("run", "completed");
        let whole = sweeps(&bench, "run");
        assert_eq!(whole.len(), SWEEPS, "every sweep once");
        assert_eq!(whole[..cut.len()], cut[..], "what was whole is as it was");
        let header = bench.read("run/run.toml");
        let points: Vec<String> = header
            .split("[[sweep]]")
            .skip(1)
            .map(|entry| {
                entry
                    .lines()
                    .find_map(|line| line.strip_prefix("point = "))
                    .unwrap()
                    .to_owned()
            })
            .collect();
        assert_eq!(points, (0..SWEEPS).map(|point| point.to_string()).collect::<Vec<_>>());
        // The lamp of this room has 337 lm; an undisturbed scan says that too.
        let (flux, expanded) = flux_lm(&bench, "run");
        assert!(
            (flux - 337.0).abs() <= expanded && expanded < 0.03 * flux,
            "{flux} ± {expanded}"
        );
    }
}
