//! The local page in Debian's chromium (tests/browser). Without node, chromium or the modules of
//! tests/browser/install.sh the test says that it was skipped, and fails where `ISOLUX_NO_SKIP` is set.

#![expect(clippy::print_stderr, reason = "says what was skipped")]

mod folder;

use std::path::{Path, PathBuf};
use std::process::Command;

use folder::Folder;

/// A plan of a few minutes, which leaves time for clicks at 600 times real time.
const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_range = [0, 360, 15]
gamma_range = [0, 90, 2.5]
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

#[test]
fn a_scan_is_started_paused_resumed_and_aborted_in_a_browser() {
    let (node, chromium, modules) = match needed() {
        Ok(all) => all,
        Err(what) => {
            assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{what}");
            eprintln!("skipped 1 test: {what}");
            return;
        }
    };
    let folder = Folder::in_memory();
    let made = folder.command(&["init", "."]).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    folder.write("plan.toml", PLAN);
    let station = folder.read("station.toml");
    let absent = station.replace("konica-t10a:memory:luxmeter", "konica-t10a:tcp://127.0.0.1:9");
    assert_ne!(absent, station);
    folder.write("broken-station.toml", &absent);
    let job = folder.read("job.toml").replace("station.toml", "broken-station.toml");
    folder.write("broken.toml", &job);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap();
    let pictures = root.join("target/browser/pictures");
    let status = Command::new(node)
        .arg(root.join("tests/browser/page.mjs"))
        .arg(env!("CARGO_BIN_EXE_isolux"))
        .arg(folder.path(""))
        .arg(&pictures)
        .env("ISOLUX_CHROMIUM", chromium)
        .env("ISOLUX_NODE_MODULES", modules)
        .status()
        .unwrap();
    assert!(status.success(), "{status}; pictures in {}", pictures.display());
}
