//! The local page in Debian's chromium (tests/browser). Without node, chromium or the modules of
//! tests/browser/install.sh the test says that it was skipped, and fails where `ISOLUX_NO_SKIP` is set.

#![expect(clippy::print_stderr, reason = "says what was skipped")]

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::folder::Folder;

/// A plan of some hours, which leaves a minute for clicks and pictures at 300 times real time, and more on a slow
/// machine.
const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 360, 15]
gamma_range = [0, 90, 0.5]
reference_every = 37
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 4
"#;

fn found(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// What the test needs beside this project; what is missing.
fn needed() -> Result<(PathBuf, PathBuf, PathBuf), &'static str> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let modules = root.join("target/browser/node_modules");
    let node = found("node").ok_or("node is missing")?;
    let chromium = found("chromium").ok_or("chromium is missing")?;
    if !modules.join("playwright-core").is_dir() {
        return Err("playwright-core is missing: bash tests/browser/install.sh");
    }
    Ok((node, chromium, modules))
}

/// The steps of `tests/browser/SCRIPT` in the folder that `prepare` fills.
fn in_a_browser(script: &str, prepare: impl FnOnce(&Folder)) {
    let (node, chromium, modules) = match needed() {
        Ok(all) => all,
        Err(what) => {
            assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{what}");
            eprintln!("skipped 1 test: {what}");
            return;
        }
    };
    let folder = Folder::in_memory();
    prepare(&folder);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap();
    let pictures = root.join("target/browser/pictures");
    let status = Command::new(node)
        .arg(root.join("tests/browser").join(script))
        .arg(env!("CARGO_BIN_EXE_isolux"))
        .arg(folder.path(""))
        .arg(&pictures)
        .env("ISOLUX_CHROMIUM", chromium)
        .env("ISOLUX_NODE_MODULES", modules)
        .status()
        .unwrap();
    assert!(status.success(), "{status}; pictures in {}", pictures.display());
}

#[test]
fn a_scan_is_started_paused_resumed_and_aborted_in_a_browser() {
    in_a_browser("page.mjs", |folder| {
        folder.isolux(&["init", "."], 0);
        std::fs::create_dir(folder.path("fresh")).unwrap();
        folder.write("plan.toml", PLAN);
        let station = folder.read("station.toml");
        let absent = station.replace("konica-t10a:memory:luxmeter", "konica-t10a:tcp://127.0.0.1:9");
        assert_ne!(absent, station);
        folder.write("broken-station.toml", &absent);
        let job = folder.read("job.toml").replace("station.toml", "broken-station.toml");
        folder.write("broken.toml", &job);
        folder.write("asked.plan.toml", ASKED);
        let job = folder.read("job.toml").replace("plan.toml", "asked.plan.toml");
        folder.write("asked.toml", &job);
    });
}

#[test]
fn a_run_is_reduced_lit_and_diagnosed_in_a_browser() {
    in_a_browser("study.mjs", |folder| {
        for (name, text) in [
            ("healthy", ROOM.to_owned()),
            ("bench", ROOM.replace("seed = 7", "seed = 8") + INJECTED),
        ] {
            std::fs::create_dir(folder.path(name)).unwrap();
            let (room, station) = (format!("{name}/darkroom.toml"), format!("{name}/station.toml"));
            folder.write(&room, &text);
            folder.isolux(
                &["virtual", "darkroom", &room, "--in-memory", "--station-out", &station],
                0,
            );
        }
        folder.write("reference.plan.toml", REFERENCE);
        folder.write("bench/one-way.plan.toml", ONE_WAY);
        let scan = |station: &str, plan: &str, out: &str| {
            folder.isolux(&["scan", station, plan, "--out", out], 0);
        };
        scan("healthy/station.toml", "reference.plan.toml", "healthy/run");
        folder.isolux(&["reduce", "healthy/run"], 0);
        scan("bench/station.toml", "bench/one-way.plan.toml", "bench/one-way");
        folder.write("bench/plan.toml", REFERENCE);
        folder.write("bench/scene.toml", SCENE);
        folder.write("bench/job.toml", JOB);
        folder.isolux(&["run", "bench/job.toml", "--out", "bench/day"], 0);
    });
}

#[test]
fn a_scan_in_motion_is_followed_in_a_browser() {
    in_a_browser("motion.mjs", |folder| {
        folder.write("lamp.ies", &lobes());
        folder.isolux(&["init", ".", "--sweep", "--lamp", "lamp.ies"], 0);
        let plan = folder.read("plan.toml");
        let is_c = |line: &&str| line.starts_with("c_range");
        let planes = plan.lines().find(is_c).unwrap();
        let chosen = "c_range = [0, 175, 5]\ntarget = { u_map_rel = 0.01 }";
        folder.write("plan.toml", &plan.replacen(planes, chosen, 1));
        let scene = folder.read("scene.toml");
        folder.write("scene.toml", &scene.replace("[2048, 2048]", "[64, 64]"));
    });
}

/// A photometric file of a lamp with three lobes around the axis, steps of 10° × 2°.
fn lobes() -> String {
    let angles = |count: u32, step: u32| (0..count).map(|k| (k * step).to_string()).collect::<Vec<_>>().join(" ");
    let cd = |c: f64, gamma: f64| {
        let lobe = 1.0 + 0.4 * gamma.sin() * (3.0 * c).cos();
        1000.0 * gamma.cos().max(0.0).powi(2) * lobe
    };
    let plane = |c: u32| {
        let at = |gamma: u32| format!("{:.2}", cd(f64::from(c).to_radians(), f64::from(gamma).to_radians()));
        (0..91).map(|k| at(2 * k)).collect::<Vec<_>>().join(" ")
    };
    let planes: Vec<String> = (0..37).map(|k| plane(10 * k)).collect();
    format!(
        "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] none\n[ISSUEDATE] 2026\n[MANUFAC] none\nTILT=NONE\n\
         1 -1 1 91 37 1 2 -0.06 -0.06 0\n1 1 10\n{}\n{}\n{}\n",
        angles(91, 2),
        angles(37, 10),
        planes.join("\n")
    )
}

/// A lamp that warms up, light in the room.
const ROOM: &str = r#"format = "isolux-darkroom/1"
seed = 7
[bench]
distance_mm = 3600.0
[injected_effects]
only = true
[injected_effects.lamp_warmup]
amplitude_rel = 0.045
time_constant_s = 420.0
[injected_effects.ambient_stray]
illuminance_lx = 0.1
"#;

/// What a scan in one direction cannot tell from a zero error of γ.
const INJECTED: &str = "[injected_effects.backlash]\nwidth_deg = 0.25\n";

const REFERENCE: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 270, 90]
gamma_range = [0, 90, 2]
repeats = 3
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;

const ONE_WAY: &str = r#"format = "isolux-plan/1"
[[block]]
name = "one way"
kind = "lit"
c_deg = [0, 180]
gamma_range = [-80, 80, 4]
repeats = 2
"#;

const SCENE: &str = r#"format = "isolux-scene/1"
model = "day/results/luminaire.model.toml"
[sensor]
size_mm = [24.576, 24.576]
pixels = [256, 256]
distance_mm = 500.0
"#;

const JOB: &str = r#"format = "isolux-job/1"
station = "station.toml"
plan = "plan.toml"
scene = "scene.toml"
[diagnose]
model = "../healthy/run/results/luminaire.model.toml"
observations = ["one-way"]
"#;

/// A person is asked before the first reading.
const ASKED: &str = r#"format = "isolux-plan/1"
[[block]]
name = "dark"
kind = "capped"
c_deg = 0
gamma_deg = 0
repeats = 3
[[block]]
name = "lit"
kind = "lit"
prompt = "take the cap off the lamp"
c_deg = [0, 90]
gamma_range = [0, 90, 10]
"#;
