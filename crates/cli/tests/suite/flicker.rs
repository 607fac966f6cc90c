//! `isolux flicker` as a person calls it, and SciPy beside it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn flicker(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_isolux"))
        .arg("flicker")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

#[test]
fn the_oscilloscope_of_the_built_in_room_is_recorded_and_evaluated() {
    let keep = tempfile::tempdir().unwrap();
    let scope = "scpi-scope:memory:oscilloscope?profile=ds1000z&channel=1";
    let arguments = [
        "--from",
        scope,
        "--duration",
        "1.5",
        "--dark",
        "0.004",
        "--out",
        "out",
        "--limit-svm",
        "0.4",
    ];
    let output = flicker(keep.path(), &arguments);
    let words = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{words}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(
        words.contains("SVM ≤ 0.4: passes") && words.contains("180 s are needed"),
        "{words}"
    );
    for name in [
        "waveform.csv",
        "modulation.json",
        "modulation-waveform.svg",
        "modulation-spectrum.svg",
    ] {
        assert!(keep.path().join("out").join(name).is_file(), "{name}");
    }
    assert_eq!(
        flicker(keep.path(), &arguments).status.code(),
        Some(2),
        "nothing is replaced unasked"
    );
    // The file is evaluated as any other; one second has no PstLM to judge.
    let again = flicker(keep.path(), &["out/waveform.csv", "--limit-pst", "1"]);
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stdout).contains("the dark level is not stated"));
    for wrong in [
        &["--from", scope][..],
        &["nowhere.csv"],
        &["out/waveform.csv", "--rate", "9"],
        &[],
    ] {
        assert_eq!(flicker(keep.path(), wrong).status.code(), Some(2), "{wrong:?}");
    }
}

/// `tests/peers/flicker.py`; skipped, and counted, where its packages are missing.
#[test]
#[allow(clippy::print_stderr, reason = "a skipped test says so")]
fn scipy_finds_the_same() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let home: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../peers-python");
    let wanted = std::fs::read_to_string(root.join("tests/peers/requirements.txt")).unwrap();
    if std::fs::read_to_string(home.join("requirements.txt")).ok() != Some(wanted) {
        let why = "not all Python packages are here (tests/peers/python.sh installs them)";
        assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{why}");
        eprintln!("skipped 1 test: {why}");
        return;
    }
    let output = Command::new(home.join("bin/python"))
        .arg(root.join("tests/peers/flicker.py"))
        .arg(env!("CARGO_BIN_EXE_isolux"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
