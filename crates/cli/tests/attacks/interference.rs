//! A second connection moves the axes and switches the outputs while a scan runs. What it does is in no row that calls
//! itself `ok`, and the distribution that comes out is the lamp's.

use std::process::Child;
use std::time::Duration;

use rand::RngExt as _;

use crate::folder::stated;
use crate::support::{Bench, moment, random, rounds, side_by_side};

/// One half-plane of a lamp that is the same all around, and what the corrections need.
const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = 0
gamma_range = [0, 90, 7.5]
reference_every = 6
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 90, 90]
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 2
"#;

/// Axis 1 is C, axis 2 is γ; output 1 is the lamp, 2 the shutter, 3 the baffle.
const COMMANDS: [&str; 9] = [
    "1 2 move abs 0",
    "1 2 move rel 40000",
    "1 2 move rel -500",
    "1 1 move rel 60000",
    "1 2 home",
    "1 0 stop",
    "1 0 io set do 1 0",
    "1 0 io set do 2 0",
    "1 0 io set do 3 1",
];

pub fn what_a_second_hand_does_is_in_no_row_and_in_no_result() {
    side_by_side(rounds(2), |round| {
        one_round(round);
        1
    });
}

fn one_round(round: u64) {
    let mut random = random(round);
    // A meter that converts all the time, and one that does when it is asked.
    let bench = if round.is_multiple_of(2) {
        Bench::new()
    } else {
        Bench::on_request()
    };
    bench.write("plan.toml", PLAN);
    let mut scan = bench.scan("--out", "run");
    bench.wait_for_rows("run", 1);
    let mut sent = Vec::new();
    while sent.len() < 4 {
        std::thread::sleep(moment(&mut random, Duration::from_millis(500), Duration::from_secs(8)));
        // A command after the end of the scan would move axes that nobody stops again.
        if scan.try_wait().unwrap().is_some() {
            break;
        }
        let command = COMMANDS[random.random_range(0..COMMANDS.len())];
        bench.tell_axes(command);
        sent.push(command);
    }
    let what = format!("round {round}: {sent:?}");
    let what = format!("{what}: {}", finished(scan));
    bench.assert_at_rest();
    assert_sound(&bench, &what);
    if !bench.read("run/run.toml").contains("how = \"completed\"") {
        bench.isolux(&["scan", "station.toml", "plan.toml", "--resume", "run"], 0);
        assert_sound(&bench, &what);
    }
    bench.assert_stopped("run", "completed");
    bench.isolux(&["reduce", "run"], 0);
    let flux = &bench.json("run/results/budget.json")["flux"];
    // One half-plane stands for all, which nobody measured: the flux carries no ±, its parts are known all the
    // same.
    assert!(flux["u"].is_null(), "{flux}");
    let (value, u) = (flux["value"].as_f64().unwrap(), flux["u_of_parts"].as_f64().unwrap());
    assert!(
        (value - 337.0).abs() <= (2.0 * u).min(0.01 * 337.0),
        "{what}: {value} ± {u} lm for 337 lm"
    );
}

/// Whatever its end was, an exit code of the program and not a crash.
fn finished(scan: Child) -> String {
    let output = scan.wait_with_output().unwrap();
    let code = output.status.code();
    assert!(
        matches!(code, Some(0 | 3)),
        "{code:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    stated(output, code)
}

/// Every row that calls itself `ok` stands where it was sent, and has the light of its angle and of its kind.
fn assert_sound(bench: &Bench, what: &str) {
    for row in bench.rows("run").iter().filter(|row| row["quality"] == "ok") {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        for axis in ["c", "gamma"] {
            let away = number(&format!("{axis}_deg")) - number(&format!("{axis}_target_deg"));
            assert!(away.abs() < 0.0101, "{what}: {row:?}");
        }
        let cosine = number("gamma_target_deg").to_radians().cos().max(0.0);
        let expected = match row["kind"].as_str() {
            "lit" => 337.0 * 6.0 / std::f64::consts::TAU * cosine.powi(5),
            _ => 0.0,
        };
        let found = number("illuminance_lx");
        assert!(
            (found - expected).abs() < 0.01 * expected + 0.2,
            "{what}: {found} lx for {expected} lx: {row:?}"
        );
    }
}
