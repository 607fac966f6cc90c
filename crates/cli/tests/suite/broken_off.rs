//! Days that break off: by SIGINT and kill in the scan and after it, by faults of the instruments. What was
//! read stays readable, the axes stand, and the day is resumed to its end.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::ops::Deref;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::folder::{Folder, stated};

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 330, 30]
gamma_range = [0, 180, 5]
reference_every = 37
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 160, 40]
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;
/// A room in which nothing is wrong but what a test adds.
const ROOM: &str = "format = \"isolux-darkroom/1\"\n[injected_effects]\nonly = true\n";
/// Rows of the plan without the visits to the reference point.
const POINTS: usize = 12 * 37 + 5 + 10;

struct Bench(Folder);

impl Deref for Bench {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Bench {
    fn new() -> Self {
        let bench = Self(Folder::new());
        bench.isolux(&["init", "bench"], 0);
        bench.write("bench/plan.toml", PLAN);
        let scene = bench.read("bench/scene.toml");
        bench.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[32, 32]"));
        bench
    }

    /// A station in a room with this fault.
    fn with_fault(fault: &str) -> Self {
        let bench = Self::new();
        let station = bench.read("bench/station.toml");
        let named = "name = \"virtual darkroom\"\n";
        assert!(station.contains(named));
        bench.write(
            "bench/station.toml",
            &station.replace(named, &format!("{named}darkroom = \"room.toml\"\n")),
        );
        bench.write("bench/room.toml", &format!("{ROOM}{fault}"));
        bench
    }

    /// Starts the command and sends it a signal as soon as `is_time`; what it said, after its exit code was asserted.
    fn broken_off(&self, arguments: &[&str], signal: &str, exit: Option<i32>, is_time: impl Fn() -> bool) -> String {
        let child = self.start(arguments);
        let deadline = Instant::now() + Duration::from_mins(2);
        while !is_time() {
            assert!(Instant::now() < deadline, "{arguments:?} does not come so far");
            std::thread::sleep(Duration::from_millis(1));
        }
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        stated(child.wait_with_output().unwrap(), exit)
    }

    fn rows(&self, run: &str) -> usize {
        std::fs::read_to_string(self.path(run).join("readings.csv")).map_or(0, |text| text.lines().count())
    }

    /// The lit readings by block, point and repeat, lx.
    fn illuminated(&self, run: &str) -> BTreeMap<[String; 3], f64> {
        let text = self.read(&format!("{run}/readings.csv"));
        let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let head = lines.next().unwrap();
        let column = |name: &str| head.iter().position(|it| *it == name).unwrap();
        let illuminated = lines.filter(|row| row[column("role")] == "point" && row[column("kind")] == "lit");
        illuminated
            .map(|row| {
                let key = ["block", "point", "repeat"].map(|name| row[column(name)].to_owned());
                (key, row[column("illuminance_lx")].parse().unwrap())
            })
            .collect()
    }

    /// How often each reading of the plan is in the run, and how many it has to be.
    fn assert_whole(&self, run: &str) {
        let text = self.read(&format!("{run}/readings.csv"));
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let column = |name: &str| head.iter().position(|it| *it == name).unwrap();
        let keys = ["block", "point", "repeat"].map(column);
        let mut found = BTreeMap::new();
        for row in lines.map(|line| line.split(',').collect::<Vec<_>>()) {
            if row[column("role")] == "point" {
                *found.entry(keys.map(|key| row[key].to_owned())).or_insert(0) += 1;
            }
        }
        assert_eq!(found.len(), POINTS);
        assert!(found.values().all(|times| *times == 1), "{found:?}");
    }

    fn assert_stopped(&self, run: &str, how: &str) {
        let header = self.read(&format!("{run}/run.toml"));
        assert!(header.contains(&format!("how = \"{how}\"")), "{header}");
        assert!(header.contains("axes_at_rest = true"), "{header}");
    }

    /// What a part of a distribution gives says that it is one, in every name and on every page, and has no
    /// uncertainty; nothing of it stands where whole results do.
    fn assert_partial(&self, run: &str) {
        let described = self.isolux(&["reduce", run], 0);
        assert!(
            described.contains("no uncertainty") && described.contains("of 12 half-planes were measured"),
            "{described}"
        );
        let results = self.path(run).join("results-partial");
        for entry in std::fs::read_dir(&results).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            assert!(name.contains(".partial."), "{name}");
        }
        assert!(!self.path(run).join("results").exists());
        let budget = self.json(&format!("{run}/results-partial/budget.partial.json"));
        assert!(budget["flux"]["u"].is_null(), "{budget}");
        self.isolux(&["report", run, "--out", "report.html"], 0);
        assert!(!self.path("report.html").exists());
        let page = self.read("report.partial.html");
        assert!(page.contains("<h1>PARTIAL") && page.contains("of 12 half-planes were measured"));
    }

    /// The flux of the day, which is known: 337 lm.
    fn assert_flux(&self, run: &str) {
        let budget = self.json(&format!("{run}/results/budget.json"));
        let [flux, u] = ["value", "u"].map(|key| budget["flux"][key].as_f64().unwrap());
        assert!((flux - 337.0).abs() < 2.0 * u && u < 0.05 * flux, "{flux} ± {u} lm");
        assert!(self.path(run).join("results/report.html").exists());
    }
}

#[test]
fn a_day_is_interrupted_in_the_scan_and_after_it_and_comes_to_its_end() {
    let bench = Bench::new();
    let day = ["run", "bench/job.toml", "--out", "day"];
    let stated = bench.broken_off(&day, "INT", Some(130), || bench.rows("day") > 40);
    assert!(stated.contains("isolux run bench/job.toml --resume day"), "{stated}");
    bench.assert_stopped("day", "interrupted");
    let read = bench.rows("day");
    assert!(read < POINTS, "{read} readings: the scan was over");
    bench.assert_partial("day");

    let again = ["run", "bench/job.toml", "--resume", "day"];
    let model = bench.path("day/results/luminaire.model.toml");
    bench.broken_off(&again, "INT", Some(130), || model.exists());
    bench.assert_stopped("day", "completed");
    assert!(!bench.path("day/results/report.html").exists());

    bench.isolux(&again, 0);
    bench.assert_whole("day");
    bench.assert_flux("day");
}

#[test]
fn a_day_whose_program_was_killed_comes_to_its_end() {
    let bench = Bench::new();
    let day = ["run", "bench/job.toml", "--out", "day"];
    bench.broken_off(&day, "KILL", None, || bench.rows("day") > 40);
    assert!(bench.rows("day") < POINTS);
    // The day holds its job from its first moment.
    bench.isolux(&["run", "--resume", "day"], 0);
    bench.assert_whole("day");
    bench.assert_flux("day");
    let result = bench.json("day/results/result.json");
    assert_eq!(result["pixels"], serde_json::json!([32, 32]));
}

/// Twenty seconds of a fault in the middle of a scan: more than the repeats of a question bridge.
#[test]
fn an_instrument_that_fails_leaves_a_run_that_goes_on() {
    for (instrument, kind) in [
        ("axes", "drop_byte"),
        ("axes", "stall"),
        ("luxmeter", "flip_bit"),
        ("luxmeter", "silent"),
        ("luxmeter", "disconnect"),
    ] {
        let fault =
            format!("[[fault]]\ninstrument = \"{instrument}\"\nkind = \"{kind}\"\nat_s = 2100.0\nfor_s = 20.0\n");
        let bench = Bench::with_fault(&fault);
        let scan = ["scan", "bench/station.toml", "bench/plan.toml"];
        let stated = bench.isolux(&[&scan[..], &["--out", "run"]].concat(), 3);
        assert!(stated.contains("--resume"), "{instrument} {kind}: {stated}");
        bench.assert_stopped("run", "failed");
        let read = bench.rows("run");
        assert!((20..POINTS).contains(&read), "{instrument} {kind}: {read} rows");
        // The cable is back.
        bench.write("bench/room.toml", ROOM);
        bench.isolux(&[&scan[..], &["--resume", "run"]].concat(), 0);
        bench.assert_whole("run");
        bench.isolux(&["reduce", "run"], 0);
    }
}

/// One damaged or late answer is asked for again; the numbers are those of a bench without faults, but for what
/// readings at other moments draw anew: two digits of a row, and in the flux the budget's parts of noise and drift.
#[test]
fn a_damaged_answer_is_asked_for_again() {
    let mut runs: Vec<(BTreeMap<[String; 3], f64>, f64, f64)> = Vec::new();
    for (instrument, kind) in [
        ("", ""),
        ("axes", "flip_bit"),
        ("luxmeter", "drop_byte"),
        ("luxmeter", "late"),
    ] {
        let fault = format!(
            "[[fault]]\ninstrument = \"{instrument}\"\nkind = \"{kind}\"\nfor_s = 1e6\nprobability = 0.01\ndelay_s = 0.7\n"
        );
        let bench = Bench::with_fault(if kind.is_empty() { "" } else { &fault });
        bench.isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"], 0);
        bench.assert_whole("run");
        bench.isolux(&["reduce", "run"], 0);
        let flux = &bench.json("run/results/budget.json")["flux"];
        let part = |name: &str| flux["parts"][name].as_f64().unwrap();
        let drawn = part("noise").hypot(part("drift")).hypot(part("smoothing"));
        runs.push((bench.illuminated("run"), flux["value"].as_f64().unwrap(), drawn));
    }
    let (rows, flux, drawn) = &runs[0];
    for (others, other, other_drawn) in &runs[1..] {
        for (key, lux) in rows {
            assert!(
                (others[key] - lux).abs() <= 0.0201 + 0.01 * lux,
                "{key:?}: {lux}, {}",
                others[key]
            );
        }
        let bound = 3.0 * drawn.hypot(*other_drawn);
        assert!((other - flux).abs() <= bound, "{flux} and {other} lm, bound {bound}");
    }
}
