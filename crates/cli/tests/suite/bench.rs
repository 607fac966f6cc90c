//! The bench from the command line: exit codes, signals, sudden death, bad input. The virtual darkroom stands in.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::folder::Folder;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 330, 30]
gamma_range = [0, 180, 5]
reference_every = 37
[[block]]
name = "capped"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 5
"#;

struct Bench {
    _keep: tempfile::TempDir,
    folder: PathBuf,
}

impl Bench {
    fn new() -> Self {
        let keep = tempfile::tempdir().unwrap();
        let folder = keep.path().join("bench");
        let bench = Self { _keep: keep, folder };
        assert!(answer(&["init", bench.path("").trim_end_matches('/')]).status.success());
        std::fs::write(bench.folder.join("small.toml"), PLAN).unwrap();
        bench
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).to_str().unwrap().to_owned()
    }

    fn scan(&self, how: &str, run: &str) -> Child {
        let (station, plan, run) = (self.path("station.toml"), self.path("small.toml"), self.path(run));
        command(&["scan", &station, &plan, how, &run])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    fn change(&self, file: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.folder.join(file)).unwrap();
        assert!(text.contains(from), "{from} is not in {file}");
        std::fs::write(self.folder.join(file), text.replacen(from, to, 1)).unwrap();
    }
}

fn answer(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_isolux"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn rows(run: &Path) -> usize {
    std::fs::read_to_string(run.join("readings.csv")).map_or(0, |text| text.lines().count().saturating_sub(1))
}

fn wait_for_rows(run: &Path, count: usize) {
    let begun = Instant::now();
    while rows(run) < count {
        assert!(
            begun.elapsed() < Duration::from_mins(2),
            "no {count} rows after two minutes"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, name: &str) {
    let kill = format!("kill -{name} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// (point, repeat) of every row that is a point of the plan.
fn points(run: &Path) -> Vec<(u64, u32)> {
    let text = std::fs::read_to_string(run.join("readings.csv")).unwrap();
    text.lines()
        .skip(1)
        .map(|row| row.split(',').collect::<Vec<_>>())
        .filter(|row| row[13] == "point")
        .map(|row| (row[14].parse().unwrap(), row[15].parse().unwrap()))
        .collect()
}

fn whole_plan() -> Vec<(u64, u32)> {
    (0..12 * 37)
        .map(|point| (point, 0))
        .chain((0..5).map(|repeat| (12 * 37, repeat)))
        .collect()
}

#[test]
#[cfg(unix)]
fn signals_end_it_cleanly_at_any_moment() {
    let bench = Bench::new();
    // Long enough that a test which is kept waiting still meets a scan under way.
    bench.change("small.toml", "[0, 330, 30]", "[0, 355, 5]");
    for (name, after, run) in [("INT", 0, "a"), ("TERM", 1, "b"), ("INT", 60, "c")] {
        let child = bench.scan("--out", run);
        let folder = bench.folder.join(run);
        let begun = Instant::now();
        while !folder.join("events.jsonl").exists() {
            assert!(begun.elapsed() < Duration::from_mins(1));
            std::thread::sleep(Duration::from_millis(2));
        }
        wait_for_rows(&folder, after);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let stated = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(130), "{stated}");
        assert!(
            stated.contains(&format!("SIG{name}")) && stated.contains("--resume"),
            "{stated}"
        );
        let header = std::fs::read_to_string(folder.join("run.toml")).unwrap();
        assert!(
            header.contains("how = \"interrupted\"") && header.contains("axes_at_rest = true"),
            "{header}"
        );
    }
}

#[test]
#[cfg(unix)]
fn killed_and_taken_up_again_no_point_is_lost_or_doubled() {
    let bench = Bench::new();
    let mut child = bench.scan("--out", "run");
    let folder = bench.folder.join("run");
    wait_for_rows(&folder, 20);
    signal(&child, "KILL");
    child.wait().unwrap();
    assert!(
        !std::fs::read_to_string(folder.join("run.toml"))
            .unwrap()
            .contains("[stopped]")
    );
    let before = std::fs::read_to_string(folder.join("readings.csv")).unwrap();
    // What a loss of power may leave of a row.
    std::fs::write(folder.join("readings.csv"), format!("{before}999,lit,li")).unwrap();
    let output = bench.scan("--resume", "run").wait_with_output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        std::fs::read_to_string(folder.join("readings.csv"))
            .unwrap()
            .starts_with(&before)
    );
    assert_eq!(points(&folder), whole_plan());
    // A plan that is not that of the run is refused, and the run is left alone.
    bench.change("small.toml", "repeats = 5", "repeats = 6");
    let after = std::fs::read(folder.join("readings.csv")).unwrap();
    let output = bench.scan("--resume", "run").wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the plan is not that of the run"));
    assert_eq!(std::fs::read(folder.join("readings.csv")).unwrap(), after);
}

#[test]
fn bad_input_says_where_and_writes_nothing() {
    let bench = Bench::new();
    let refused = |file: &str, from: &str, to: &str, words: &[&str]| {
        let text = std::fs::read_to_string(bench.folder.join(file)).unwrap();
        bench.change(file, from, to);
        let output = bench.scan("--out", "run").wait_with_output().unwrap();
        let stated = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stated}");
        for word in words {
            assert!(stated.contains(word), "`{word}` is not in: {stated}");
        }
        assert!(!bench.folder.join("run").exists(), "nothing is written");
        std::fs::write(bench.folder.join(file), text).unwrap();
    };
    refused(
        "small.toml",
        "reference_every",
        "reference_evry",
        &["small.toml:7:1", "unknown field `reference_evry`"],
    );
    refused(
        "small.toml",
        "[0, 330, 30]",
        "[0, 390, 30]",
        &["small.toml:5:1", "390°", "limits"],
    );
    refused("small.toml", "[0, 180, 5]", "[0, nan, 5]", &["small.toml:6:1"]);
    refused(
        "small.toml",
        "isolux-plan/1",
        "isolux-plan/9",
        &["small.toml:1:10", "isolux-plan/9"],
    );
    refused(
        "station.toml",
        "turning_luminaire",
        "moving_detector",
        &["station.toml:", "moving_detector"],
    );
    refused(
        "station.toml",
        "zaber:memory:axes?axis=1",
        "zebra:memory:axes?axis=1",
        &["axis.c", "zebra"],
    );
    refused("station.toml", "spectroradiometer.csv", "nowhere.csv", &["nowhere.csv"]);
    let missing = answer(&["plan", &bench.path("nowhere.toml"), &bench.path("small.toml")]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("nowhere.toml"));
    // A second `init` would replace files.
    assert_eq!(answer(&["init", &bench.path("")]).status.code(), Some(2));
    // A folder that holds something is no place for a run.
    std::fs::create_dir_all(bench.folder.join("run")).unwrap();
    std::fs::write(bench.folder.join("run/mine.txt"), "mine").unwrap();
    let output = bench.scan("--out", "run").wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(std::fs::read_dir(bench.folder.join("run")).unwrap().count(), 1);
}

#[test]
fn by_hand_and_dry() {
    let bench = Bench::new();
    let station = bench.path("station.toml");
    let stated = |arguments: &[&str]| {
        let output = answer(arguments);
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(
            output.status.success(),
            "{text}{}",
            String::from_utf8_lossy(&output.stderr)
        );
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    };
    let plan = stated(&["plan", &station, &bench.path("plan.toml"), "--json"]);
    assert_eq!((&plan["points"], &plan["references"]), (&2297.into(), &26.into()));
    assert!(
        plan["distances"]["best_mm"].is_number() && plan["distances"]["best_mm"] == plan["blocks"][0]["distance_mm"],
        "the day is at the distance that is proposed: {plan}"
    );
    let check = stated(&["check", &station, "--json", "--record", &bench.path("trace.txt")]);
    assert!(
        check["instruments"]
            .as_array()
            .unwrap()
            .iter()
            .all(|found| found["ok"] == true),
        "{check}"
    );
    assert!(std::fs::metadata(bench.folder.join("trace.txt")).unwrap().len() > 1000);
    assert_eq!(stated(&["home", &station, "--json"])["c_deg"], 0.0);
    assert_eq!(
        stated(&["read", &station, "--count", "3", "--json"])
            .as_array()
            .unwrap()
            .len(),
        3
    );
    assert!(stated(&["stop", &station, "--json"])["gamma_deg"].is_number());
    assert!(stated(&["warmup", &station, "--json"])["elapsed_s"].as_f64().unwrap() >= 1800.0);
    let outside = answer(&["move", &station, "--c", "400"]);
    assert_eq!(outside.status.code(), Some(2));
    // The twins of each command are fresh: nobody has homed them.
    let lost = answer(&["move", &station, "--c", "10"]);
    assert_eq!(lost.status.code(), Some(3), "{}", String::from_utf8_lossy(&lost.stderr));
}

#[test]
fn outputs_and_the_rail_are_moved_by_hand() {
    let bench = Bench::new();
    let station = bench.path("station.toml");
    let stated = |arguments: &[&str]| -> (Option<i32>, String) {
        let out = answer(arguments);
        let text = [out.stdout, out.stderr]
            .map(|bytes| String::from_utf8(bytes).unwrap())
            .concat();
        (out.status.code(), text)
    };
    let (code, text) = stated(&[
        "switch",
        &station,
        "--lamp",
        "on",
        "--shutter",
        "open",
        "--baffle",
        "in",
    ]);
    assert_eq!(
        (code, text.trim()),
        (Some(0), "lamp on, shutter open, baffle in the beam")
    );
    let (code, text) = stated(&["switch", &station, "--shutter", "closed", "--json"]);
    assert_eq!((code, text.trim()), (Some(0), "{\"shutter\":false}"));
    let (code, text) = stated(&["move", &station, "--distance-mm", "3700"]);
    assert!(code == Some(0) && text.contains("detector at 3700.00 mm"), "{text}");
    let (code, text) = stated(&["move", &station, "--distance-mm", "50"]);
    assert!(
        code == Some(2) && text.contains("100 mm…12000 mm") && text.contains("nothing was moved"),
        "{text}"
    );
    bench.change(
        "station.toml",
        "[lamp]\nopen = \"zaber:memory:axes?do=1\"",
        "[lamp]\nprompt = \"turn the knob\"",
    );
    let (code, text) = stated(&["switch", &station, "--lamp", "off"]);
    assert!(
        code == Some(2) && text.contains("left to a person: turn the knob"),
        "{text}"
    );
    assert_eq!(stated(&["switch", &station]).0, Some(2), "something has to be named");
}

/// Twins as a process over TCP for the lux meter, twins of this process for the rest: in real time.
#[test]
fn a_real_link_and_twins_play_together_in_real_time() {
    use std::io::{BufRead, BufReader};
    let bench = Bench::new();
    let mut twin = command(&["virtual", "luxmeter", "--tcp", "0", "--json", "--lasts-s", "300"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(twin.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    let twin_at: serde_json::Value = serde_json::from_str(&line).unwrap();
    std::fs::create_dir(bench.path("mixed")).unwrap();
    let (file, open) = (
        bench.path("mixed/station.toml"),
        format!("luxmeter={}", twin_at["open"].as_str().unwrap()),
    );
    let written = answer(&["init", "--bench", &file, "--open", &open, "--open", "baffle=hand"]);
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let checked = answer(&["check", &file, "--json"]);
    twin.kill().unwrap();
    twin.wait().unwrap();
    let report: serde_json::Value = serde_json::from_slice(&checked.stdout).unwrap();
    assert!(checked.status.success(), "{report}");
    for (role, link) in [
        ("axis.c", "memory:axes"),
        ("luxmeter", "tcp://127.0.0.1"),
        ("spectroradiometer", "memory:"),
    ] {
        let found = report["instruments"]
            .as_array()
            .unwrap()
            .iter()
            .find(|found| found["role"] == role)
            .unwrap();
        assert!(
            found["ok"] == true && found["open"].as_str().unwrap().contains(link),
            "{found}"
        );
    }
    assert!(
        answer(&["init", "--bench", &file]).status.code() == Some(2),
        "it asks on a terminal only, and replaces nothing"
    );
}

#[test]
fn every_port_that_cannot_be_asked_says_why() {
    let folder = Folder::in_memory();
    let stated = folder.isolux(&["devices", "--identify", "usb:1", "/dev/nothing"], 3);
    for words in [
        "usb: cannot be asked",
        "/dev/nothing: ",
        "an instrument at 0 of 2 ports",
        "could not be asked: usb:1, /dev/nothing",
    ] {
        assert!(stated.contains(words), "{words} is not in\n{stated}");
    }
}
