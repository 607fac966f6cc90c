//! Diagnose, measure what would settle the answer, diagnose again: by three commands and by one, in a virtual darkroom
//! whose axes have an injected effect that a scan in one direction cannot name.

use std::ops::Deref;
use std::process::{Output, Stdio};

use crate::folder::{Folder, stated};
use serde_json::Value;

/// At 3.6 m the axis has four digits of the lux meter.
const ROOM: &str = "\
format = \"isolux-darkroom/1\"
seed = SEED
[bench]
distance_mm = 3600.0
[injected_effects]
only = true
[injected_effects.lamp_warmup]
amplitude_rel = 0.045
time_constant_s = 420.0
";

/// What the operator's model is made of.
const REFERENCE: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 270, 90]
gamma_range = [0, 90, 2]
repeats = 3
[[block]]
name = "baffled"
kind = "baffled"
c_deg = 0
gamma_range = [0, 80, 20]
repeats = 3
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;

/// γ in one direction alone: a zero error and backlash do the same there.
const ONE_WAY: &str = r#"format = "isolux-plan/1"
[[block]]
name = "one way"
kind = "lit"
c_deg = [0, 180]
gamma_range = [-80, 80, 4]
repeats = 2
"#;

/// A folder with the operator's model and a bench that has `injected effect`.
struct Bench(Folder);

impl Deref for Bench {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Bench {
    fn with(effect: &str) -> Self {
        let bench = Self(Folder::new());
        bench.room("healthy", &ROOM.replace("SEED", "7"));
        bench.write("reference.plan.toml", REFERENCE);
        bench.isolux(
            &[
                "scan",
                "healthy/station.toml",
                "reference.plan.toml",
                "--out",
                "healthy/run",
            ],
            0,
        );
        bench.isolux(&["reduce", "healthy/run"], 0);
        bench.room("disturbed", &(ROOM.replace("SEED", "8") + effect));
        bench.write("one-way.plan.toml", ONE_WAY);
        bench.isolux(
            &["scan", "disturbed/station.toml", "one-way.plan.toml", "--out", "run"],
            0,
        );
        bench
    }

    fn room(&self, name: &str, text: &str) {
        std::fs::create_dir(self.path(name)).unwrap();
        let room = format!("{name}/darkroom.toml");
        self.write(&room, text);
        let station = format!("{name}/station.toml");
        self.isolux(
            &["virtual", "darkroom", &room, "--in-memory", "--station-out", &station],
            0,
        );
    }

    fn diagnosis(&self, folder: &str) -> Value {
        self.json(&format!("{folder}/diagnosis.json"))
    }

    const INVESTIGATE: [&'static str; 6] = [
        "investigate",
        "disturbed/station.toml",
        MODEL,
        "run",
        "--out",
        "investigation",
    ];
}

const MODEL: &str = "healthy/run/results/luminaire.model.toml";

/// Names of the 95 % set of the first effect.
fn set(diagnosis: &Value) -> Vec<&str> {
    let first = &diagnosis["effects"][0];
    let others = first["equivalents"].as_array().unwrap();
    std::iter::once(&first["name"])
        .chain(others)
        .map(|name| name.as_str().unwrap())
        .collect()
}

/// The one effect that was named, and a parameter of it with its standard uncertainty.
fn named<'a>(diagnosis: &'a Value, key: &str) -> (&'a str, f64, f64) {
    assert_eq!(diagnosis["verdict"], "named", "{diagnosis:#}");
    let effects = diagnosis["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{effects:#?}");
    assert_eq!(set(diagnosis).len(), 1, "{effects:#?}");
    let parameter = &effects[0]["parameters"][key];
    let number = |of: &str| parameter[of].as_f64().unwrap();
    (effects[0]["name"].as_str().unwrap(), number("value"), number("u"))
}

#[test]
fn the_plan_that_a_diagnosis_writes_settles_it() {
    let bench = Bench::with("[injected_effects.backlash]\nwidth_deg = 0.25\n");
    bench.isolux(&["diagnose", MODEL, "run", "--out", "first"], 0);
    let first = bench.diagnosis("first");
    assert_eq!(first["verdict"], "ambiguous", "{first:#}");
    let mut alternatives = set(&first);
    alternatives.sort_unstable();
    assert_eq!(alternatives, ["backlash", "gamma_zero"], "{first:#}");
    // A block that would leave the two within the noise of their difference costs an day_results and settles nothing.
    let suggested = first["next_measurement"].as_array().unwrap();
    assert!(
        suggested
            .iter()
            .all(|next| next["expected_sigma"].as_f64().unwrap() >= 1.0),
        "{first:#}"
    );
    let next = &suggested[0];
    assert_eq!(next["do"], "reverse_travel", "{next:#}");
    let plan = format!("first/{}", next["plan"].as_str().unwrap());

    // The plan as it is: first looked at, then carried out.
    bench.isolux(&["plan", "disturbed/station.toml", &plan], 0);
    bench.isolux(&["scan", "disturbed/station.toml", &plan, "--out", "more"], 0);
    let stated = bench.isolux(&["diagnose", MODEL, "run", "more", "--out", "second"], 0);
    let second = bench.diagnosis("second");
    let (name, width, u) = named(&second, "width_deg");
    assert_eq!(name, "backlash");
    assert!((width - 0.25).abs() < 3.0 * u && u < 0.02, "{width} ± {u}");
    assert!(stated.contains("backlash"), "{stated}");
    assert_eq!(second["next_measurement"].as_array().unwrap().len(), 0);
}

#[test]
fn investigate_settles_it_by_one_command_and_moves_nothing_unasked() {
    let bench = Bench::with("[injected_effects.gamma_zero]\noffset_deg = 0.12\n");

    // Nobody at the terminal: refused before anything is written or moved.
    let stated = bench.isolux(&Bench::INVESTIGATE, 2);
    assert!(stated.contains("--yes"), "{stated}");
    assert!(!bench.path("investigation").exists());

    #[cfg(unix)]
    for (out, answer, moves) in [("no", "no\n", false), ("silence", "\n", false), ("yes", "y\n", true)] {
        let (stated, moved) = at_a_terminal(&bench, out, answer);
        assert_eq!(moved, moves, "{stated}");
        assert_eq!(stated.contains("nothing was moved"), !moves, "{stated}");
    }

    let stated = bench.isolux(&[&Bench::INVESTIGATE[..], &["--yes"]].concat(), 0);
    let first = bench.diagnosis("investigation/diagnosis-1");
    assert_eq!(first["verdict"], "ambiguous", "{first:#}");
    assert!(set(&first).contains(&"backlash"), "{first:#}");
    let second = bench.diagnosis("investigation/diagnosis-2");
    let (name, offset, u) = named(&second, "offset_deg");
    assert_eq!(name, "gamma_zero");
    assert!((offset - 0.12).abs() < 3.0 * u && u < 0.01, "{offset} ± {u}");
    let verdict = stated.lines().find(|line| line.starts_with("verdict")).unwrap();
    assert!(
        verdict.contains("gamma_zero") || verdict.contains("γ zero"),
        "{verdict}"
    );
    assert!(!verdict.contains("backlash"), "{verdict}");

    // What is there is not written over.
    bench.isolux(&[&Bench::INVESTIGATE[..], &["--yes"]].concat(), 2);
}

/// A bench whose γ axis may not go back where the plan of the diagnosis begins, and whose detector stands still.
#[test]
fn a_plan_that_the_bench_cannot_carry_out_is_not_tried() {
    let bench = Bench::with("[injected_effects.gamma_zero]\noffset_deg = 0.12\n");
    let text = bench.read("disturbed/station.toml");
    let narrow = text.replace("limit_deg = [-185.0, 365.0]", "limit_deg = [-60.0, 60.0]");
    assert_ne!(text, narrow);
    bench.write("disturbed/station.toml", &narrow);
    let stated = bench.isolux(&[&Bench::INVESTIGATE[..], &["--yes"]].concat(), 0);
    assert!(stated.contains("cannot be carried out on this bench"), "{stated}");
    assert!(stated.contains("limits"), "{stated}");
    assert!(!bench.path("investigation/run-2").exists(), "{stated}");
}

/// The command at a terminal whose person answers `answer`; what it said, and whether it went on to measure.
#[cfg(unix)]
fn at_a_terminal(bench: &Bench, out: &str, answer: &str) -> (String, bool) {
    use std::io::{Read, Write};

    use serialport::{SerialPort, TTYPort};

    let (mut person, terminal) = TTYPort::pair().unwrap();
    let name = terminal.name().unwrap();
    // The pair holds its end exclusively; the command opens it by its name.
    drop(terminal);
    let terminal = std::fs::File::open(name).unwrap();
    let requested = ["investigate", "disturbed/station.toml", MODEL, "run", "--out", out];
    let mut child = bench
        .command(&requested)
        .stdin(terminal)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // What is typed before the question is no answer to it.
    let mut words = child.stderr.take().unwrap();
    let mut stderr = Vec::new();
    let mut byte = [0];
    while !stderr.ends_with(b"[y/N] ") && words.read(&mut byte).unwrap() > 0 {
        stderr.push(byte[0]);
    }
    person.write_all(answer.as_bytes()).unwrap();
    words.read_to_end(&mut stderr).unwrap();
    let output = child.wait_with_output().unwrap();
    let stated = stated(Output { stderr, ..output }, Some(0));
    assert!(stated.contains("May the axes move? [y/N]"), "{stated}");
    (stated, bench.path(out).join("run-2").exists())
}
