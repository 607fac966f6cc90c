//! `isolux verify`: one changed digit in any file of a run is named; a signature covers what nothing else does, and the
//! official minisign checks it and makes such signatures. Without that program its test says that it was skipped, and
//! fails where `ISOLUX_NO_SKIP` is set.

#![expect(clippy::print_stderr, reason = "a skipped test says so")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::folder::Folder;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
c_range = [0, 270, 90]
gamma_range = [0, 180, 15]
reference_every = 13
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 2
[[block]]
name = "lamp off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 10
"#;

/// Made by `minisign -G -W` of version 0.11.
const KEY: &str = "untrusted comment: minisign encrypted secret key\n\
RWQAAEIyAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACQmEukg1fLOycbkHaBU9tdf4gZsS\
JenCjxL7PybyvO5UJCSrRgeWt3Ex87m6tZ1KnDOUxbspNrX0/C6QHSoLMfLzBInQzMJSAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=\n";
const PUBLIC_KEY: &str = "untrusted comment: minisign public key B37C3548BA840909
RWQJCYS6SDV8s3Ex87m6tZ1KnDOUxbspNrX0/C6QHSoLMfLzBInQzMJS
";

/// States what the head of the lux meter answers.
fn state_head(folder: &Folder) {
    let bell = |nm: f64| (-0.5 * ((nm - 558.0) / 43.0).powi(2)).exp();
    let rows = (0..=42).map(|step| 370.0 + 10.0 * f64::from(step));
    let head = "wavelength_nm,responsivity,u_rel\n".to_owned();
    let text = rows.fold(head, |text, nm| text + &format!("{nm},{:.4},0.0050\n", bell(nm)));
    folder.write("bench/head.csv", &text);
    let station = folder.read("bench/station.toml");
    let station = station.replacen("[luxmeter]\n", "[luxmeter]\nresponsivity = \"head.csv\"\n", 1);
    folder.write("bench/station.toml", &station);
}

/// A bench with the plan and the keys of a laboratory.
fn bench() -> Folder {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "bench"], 0);
    folder.write("bench/plan.toml", PLAN);
    folder.write("lab.key", KEY);
    folder.write("lab.pub", PUBLIC_KEY);
    folder
}

/// A day of a job, reduced a second time with a model. Its report on paper is for the tests that change it: each
/// verification would make it once more.
fn day() -> Folder {
    let folder = bench();
    let scene = folder.read("bench/scene.toml");
    folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[16, 16]"));
    state_head(&folder);
    folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
    let model = "day/results/luminaire.model.toml";
    folder.isolux(&["reduce", "day", "--with", model, "--out", "day/with"], 0);
    folder
}

/// A scan, of which a verification computes less again than of a day.
fn scan() -> Folder {
    let folder = bench();
    folder.isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"], 0);
    folder
}

/// A scan and its results.
fn reduced() -> Folder {
    let folder = scan();
    folder.isolux(&["reduce", "run"], 0);
    folder
}

fn names(folder: &Path) -> Vec<String> {
    fn below(folder: &Path, root: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                below(&path, root, found);
            } else {
                let name = path.strip_prefix(root).unwrap().to_str().unwrap();
                found.push(name.replace('\\', "/"));
            }
        }
    }
    let mut found = Vec::new();
    below(folder, folder, &mut found);
    found.sort();
    found
}

fn copy(from: &Path, to: &Path) {
    let _ = fs::remove_dir_all(to);
    for file in names(from) {
        let target = to.join(&file);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(from.join(file), target).unwrap();
    }
}

/// Puts another digit in place of one; its line.
fn flip(file: &Path, random: &mut ChaCha8Rng) -> u64 {
    let mut bytes = fs::read(file).unwrap();
    let digits: Vec<usize> = (0..bytes.len()).filter(|at| bytes[*at].is_ascii_digit()).collect();
    let at = digits[random.random_range(0..digits.len())];
    bytes[at] = b'0' + (bytes[at] - b'0' + random.random_range(1..10)) % 10;
    fs::write(file, &bytes).unwrap();
    bytes[..at].split(|byte| *byte == b'\n').count() as u64
}

/// What `verify --json` prints, after its exit code was asserted.
fn verify(folder: &Folder, run: &str, more: &[&str], exit: i32) -> Value {
    let output = folder
        .command(&[&["verify", run, "--json"], more].concat())
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(exit), "{words}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["agrees"], exit == 0);
    found
}

/// The files of this state, each with the lines that are named.
fn of(found: &Value, state: &str) -> Vec<(String, Vec<Option<u64>>)> {
    let files = found["files"].as_array().unwrap().iter();
    files
        .filter(|file| file["state"] == state)
        .map(|file| {
            let lines = file["differs"].as_array().unwrap().iter();
            let name = file["name"].as_str().unwrap().to_owned();
            (name, lines.map(|differs| differs["line"].as_u64()).collect())
        })
        .collect()
}

/// Changes a digit of each of these files of the day, in a copy: they are named, and no other file is.
fn change_a_digit(folder: &Folder, files: &[&str]) {
    copy(&folder.path("day"), &folder.path("changed"));
    let changed: BTreeMap<&str, u64> = files
        .iter()
        .map(|file| {
            let mut random = ChaCha8Rng::seed_from_u64(7 + file.len() as u64);
            (*file, flip(&folder.path(&format!("changed/{file}")), &mut random))
        })
        .collect();
    let found = verify(folder, "changed", &[], 1);
    let differ: BTreeMap<_, _> = of(&found, "differs").into_iter().collect();
    for (&file, &line) in &changed {
        let lines = differ.get(file);
        let lines = lines.unwrap_or_else(|| panic!("{file}:{line} is not named: {differ:?}"));
        assert!(
            lines.iter().flatten().all(|named| *named == line),
            "{file}:{line} {lines:?}"
        );
        let bytes = [
            "run.toml",
            "events.jsonl",
            "results/irradiance.npy",
            "results/irradiance.png",
            "results/report.pdf",
        ];
        let has_line = !bytes.contains(&file) && !file.contains("job/") && !file.contains("reduced_with");
        assert!(!has_line || lines.contains(&Some(line)), "{file}:{line} {lines:?}");
    }
    for other in differ.keys().filter(|other| !changed.contains_key(other.as_str())) {
        // Of a file and the list of its hash nobody can say which was changed.
        let alone = |folder: &str| files.len() == 1 && files[0].starts_with(folder);
        let list = ["job/SHA256SUMS", "job/job.toml", "job/scene.toml"];
        assert!(
            alone("job/") && list.contains(&other.as_str())
                || alone("with/reduced_with/") && other == "with/provenance.json",
            "{changed:?} were changed, {other} is named"
        );
    }
}

/// Every file of the day that is verified; whether it is a result that is compared with what is computed from the
/// others, and no list of them.
fn files(folder: &Folder, computed: bool) -> Vec<String> {
    let is_computed = |file: &str| {
        ["results/", "with/"].iter().any(|folder| file.starts_with(folder))
            && !file.contains("/reduced_with/")
            && !file.ends_with("provenance.json")
    };
    let mut files = names(&folder.path("day"));
    files.retain(|file| file != "log.txt" && is_computed(file) == computed);
    files
}

#[test]
fn one_changed_digit_in_any_recorded_file_is_named() {
    let folder = day();
    let files = files(&folder, false);
    for known in ["run.toml", "spectra/000.csv", "job/job.toml"] {
        assert!(files.iter().any(|file| file == known), "{files:?}");
    }
    for file in &files {
        change_a_digit(&folder, &[file]);
    }
}

/// Every seventh together: each is compared with what is computed from the record, not with another.
#[test]
fn one_changed_digit_in_any_result_is_named() {
    let folder = day();
    let found = verify(&folder, "day", &[], 0);
    let unchecked: Vec<String> = of(&found, "not_checked").into_iter().map(|(name, _)| name).collect();
    assert_eq!(unchecked, ["log.txt"]);
    let files = files(&folder, true);
    assert!(files.iter().any(|file| file == "results/diagnosis.json"), "{files:?}");
    for first in 0..7 {
        let together: Vec<&str> = files.iter().skip(first).step_by(7).map(String::as_str).collect();
        change_a_digit(&folder, &together);
    }
    folder.isolux(&["report", "day", "--pdf"], 0);
    verify(&folder, "day", &[], 0);
    change_a_digit(&folder, &["results/report.pdf"]);
}

/// Who changes a file can change its checksum too; what is computed again tells both.
#[test]
fn a_changed_digit_under_a_changed_checksum_is_named() {
    let folder = day();
    let sha256 = |text: &str| hex::encode(Sha256::digest(text.as_bytes()));
    let text = folder.read("day/results/luminaire.ies");
    let file = folder.path("day/results/luminaire.ies");
    let line = flip(&file, &mut ChaCha8Rng::seed_from_u64(4));
    let changed = folder.read("day/results/luminaire.ies");
    let list = folder.read("day/results/provenance.json");
    let forged = list.replace(&sha256(&text), &sha256(&changed));
    assert!(forged != list, "the list holds the file");
    folder.write("day/results/provenance.json", &forged);
    let differ = of(&verify(&folder, "day", &[], 1), "differs");
    assert_eq!(differ[0], ("results/luminaire.ies".to_owned(), vec![Some(line)]));
    assert_eq!(differ[1].0, "results/provenance.json");
    assert_eq!(differ.len(), 2);
}

/// A day of the built-in darkroom holds no job: its sensor is known by the program, not by the file that is looked at.
#[test]
fn a_changed_sensor_of_a_built_in_day_is_named() {
    let folder = Folder::in_memory();
    folder.isolux(&["run", "--out", "day"], 0);
    let text = folder.read("day/results/result.json");
    let (before, _) = text.split_once("2048").unwrap();
    let line = before.split('\n').count() as u64;
    folder.write("day/results/result.json", &text.replacen("2048", "2047", 1));
    let differ = of(&verify(&folder, "day", &[], 1), "differs");
    assert_eq!(differ, [("results/result.json".to_owned(), vec![Some(line)])]);
}

#[test]
fn a_changed_sweep_is_named_with_its_line() {
    let folder = Folder::in_memory();
    folder.isolux(&["init", "bench", "--sweep"], 0);
    folder.isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"], 0);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for file in ["sweeps/000.csv", "sweeps/003.csv"] {
        let whole = fs::read(folder.path(&format!("run/{file}"))).unwrap();
        let line = flip(&folder.path(&format!("run/{file}")), &mut random);
        let differ = of(&verify(&folder, "run", &[], 1), "differs");
        assert_eq!(differ, [(file.to_owned(), vec![Some(line)])]);
        fs::write(folder.path(&format!("run/{file}")), whole).unwrap();
    }
    verify(&folder, "run", &[], 0);
}

#[test]
fn a_signature_covers_every_file_and_is_only_of_what_agrees() {
    let folder = reduced();
    let signed = ["--public-key", "lab.pub"];
    assert_eq!(
        of(&verify(&folder, "run", &signed, 1), "differs")[0].0,
        "SHA256SUMS.minisig"
    );
    // What differs is not signed.
    copy(&folder.path("run"), &folder.path("bad"));
    let mut random = ChaCha8Rng::seed_from_u64(2);
    flip(&folder.path("bad/results/luminaire.ldt"), &mut random);
    let words = folder.isolux(&["verify", "bad", "--sign", "--key", "lab.key"], 1);
    assert!(
        words.contains("nothing was signed") && !folder.path("bad/SHA256SUMS").exists(),
        "{words}"
    );

    let words = folder.isolux(&["verify", "run", "--sign", "--key", "lab.key"], 0);
    assert!(words.contains("signed        run/SHA256SUMS.minisig"), "{words}");
    let found = verify(&folder, "run", &signed, 0);
    assert_eq!(of(&found, "not_checked"), []);
    assert_eq!(found["signature"]["by_this_key"], true);
    // Without the key nobody says that it is good.
    let found = verify(&folder, "run", &[], 0);
    assert_eq!(found["signature"]["by_this_key"], false);
    let unchecked: Vec<String> = of(&found, "not_checked").into_iter().map(|(name, _)| name).collect();
    assert_eq!(unchecked, ["SHA256SUMS", "SHA256SUMS.minisig"]);

    let words = folder.isolux(&["verify", "run", "--sign", "--key", "lab.key"], 2);
    assert!(words.contains("exists"), "{words}");
    folder.isolux(&["verify", "run", "--sign", "--key", "lab.pub", "--force"], 2);
    folder.isolux(&["verify", "run", "--public-key", "lab.key"], 2);
    verify(&folder, "run", &signed, 0);
    // A run that was changed keeps its signature, which says so; one that holds more is signed anew.
    copy(&folder.path("run"), &folder.path("bad"));
    flip(&folder.path("bad/results/luminaire.ies"), &mut random);
    folder.isolux(&["verify", "bad", "--sign", "--key", "lab.key", "--force"], 1);
    let differ = of(&verify(&folder, "bad", &signed, 1), "differs");
    assert!(
        differ.len() == 1 && differ[0].0 == "results/luminaire.ies",
        "{differ:?}"
    );
    folder.isolux(&["reduce", "bad", "--force"], 0);
    folder.isolux(&["reduce", "bad", "--without", "drift", "--out", "bad/without"], 0);
    assert!(
        verify(&folder, "bad", &signed, 0)["notes"]
            .to_string()
            .contains("without/budget.json")
    );
    folder.isolux(&["verify", "bad", "--sign", "--key", "lab.key", "--force"], 0);
    let found = verify(&folder, "bad", &signed, 0);
    assert!(!found["notes"].to_string().contains("without/budget.json"), "{found}");

    for file in ["log.txt", "SHA256SUMS", "results/luminaire.xml", "run.toml"] {
        copy(&folder.path("run"), &folder.path("bad"));
        flip(&folder.path(&format!("bad/{file}")), &mut random);
        let differ = of(&verify(&folder, "bad", &signed, 1), "differs");
        let named = if file == "SHA256SUMS" {
            "SHA256SUMS.minisig"
        } else {
            file
        };
        assert!(differ.iter().any(|(name, _)| name == named), "{file}: {differ:?}");
        assert!(differ.len() == 1 || file == "SHA256SUMS", "{file}: {differ:?}");
    }
    fs::remove_file(folder.path("run/log.txt")).unwrap();
    folder.write("run/later.txt", "1");
    let found = verify(&folder, "run", &signed, 1);
    assert_eq!(of(&found, "differs"), [("log.txt".to_owned(), vec![None])]);
    assert!(found["notes"].to_string().contains("later.txt"), "{found}");
}

#[test]
fn a_changed_signature_is_no_signature() {
    let folder = scan();
    folder.isolux(&["verify", "run", "--sign", "--key", "lab.key"], 0);
    let signed = ["--public-key", "lab.pub"];
    verify(&folder, "run", &signed, 0);
    // Every character of the signature that is signed: its second line, the trusted comment, the fourth line.
    let text = folder.read("run/SHA256SUMS.minisig");
    for (place, c) in text.char_indices().filter(|(_, c)| c.is_ascii_digit()).step_by(9) {
        let other = if c == '7' { "8" } else { "7" };
        folder.write(
            "run/SHA256SUMS.minisig",
            &format!("{}{other}{}", &text[..place], &text[place + 1..]),
        );
        let differ = of(&verify(&folder, "run", &signed, 1), "differs");
        assert_eq!(differ[0].0, "SHA256SUMS.minisig", "{place}");
    }
    // A signature whose end is cut off is none.
    folder.write("run/SHA256SUMS.minisig", &text[..text.len() - 9]);
    assert_eq!(
        of(&verify(&folder, "run", &signed, 1), "differs")[0].0,
        "SHA256SUMS.minisig"
    );
}

#[test]
fn a_station_or_calibration_that_is_not_that_of_the_run_is_named() {
    let folder = bench();
    state_head(&folder);
    folder.isolux(&["scan", "bench/station.toml", "bench/plan.toml", "--out", "run"], 0);
    let station = ["--station", "bench/station.toml"];
    verify(&folder, "run", &station, 0);
    let text = folder.read("bench/station.toml");
    let changed = text.replacen("diameter_mm = 73.0", "diameter_mm = 78.0", 1);
    assert!(changed != text, "{text}");
    folder.write("bench/station.toml", &changed);
    let found = verify(&folder, "run", &station, 1);
    assert_eq!(of(&found, "differs")[0].0, "bench/station.toml");
    assert!(found.to_string().contains("diameter_mm = 78"), "{found}");
    folder.write("bench/station.toml", &text);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    flip(&folder.path("bench/spectroradiometer.csv"), &mut random);
    let differ = of(&verify(&folder, "run", &station, 1), "differs");
    assert!(
        differ.len() == 1 && differ[0].0.ends_with("spectroradiometer.csv"),
        "{differ:?}"
    );
    let head = folder.read("bench/head.csv");
    let changed = head.replacen("\n560,0.9989", "\n560,0.9988", 1);
    assert!(changed != head, "{head}");
    folder.write("bench/head.csv", &changed);
    let differ = of(&verify(&folder, "run", &station, 1), "differs");
    assert!(differ.len() == 2 && differ[0].0.ends_with("head.csv"), "{differ:?}");
}

#[test]
fn what_is_no_run_is_refused() {
    let folder = Folder::in_memory();
    assert!(folder.isolux(&["verify", "nowhere"], 2).contains("no run directory"));
}

/// Runs the official program, if it is there.
fn minisign(folder: &Path, arguments: &[&str]) -> Option<bool> {
    let mut command = Command::new("minisign");
    let output = command
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output();
    let Ok(output) = output else {
        let what = "no minisign here (Debian: apt-get install minisign)";
        assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{what}");
        eprintln!("skipped 1 test: {what}");
        return None;
    };
    Some(output.status.success())
}

#[test]
fn the_official_minisign_checks_our_signature_and_makes_one_for_us() {
    let folder = reduced();
    let run = folder.path("run");
    folder.isolux(&["verify", "run", "--sign", "--key", "lab.key"], 0);
    let check = ["-V", "-m", "SHA256SUMS", "-p", "../lab.pub"];
    let Some(valid) = minisign(&run, &check) else {
        return;
    };
    assert!(valid, "minisign takes our signature");
    let text = folder.read("run/SHA256SUMS");
    folder.write("run/SHA256SUMS", &text.replacen("  ", " ", 1));
    assert_eq!(minisign(&run, &check), Some(false), "and not for another list");
    folder.write("run/SHA256SUMS", &text);
    for more in [&[][..], &["-l"], &["-t", "report 17"]] {
        let sign = [&["-S", "-m", "SHA256SUMS", "-s", "../lab.key"], more].concat();
        assert_eq!(minisign(&run, &sign), Some(true));
        let found = verify(&folder, "run", &["--public-key", "lab.pub"], 0);
        assert_eq!(found["signature"]["by_this_key"], true, "{more:?}");
    }
    // A key that it makes now, and one that it was not signed with.
    assert_eq!(
        minisign(&folder.path("."), &["-G", "-W", "-f", "-s", "new.key", "-p", "new.pub"]),
        Some(true)
    );
    verify(&folder, "run", &["--public-key", "new.pub"], 1);
    folder.isolux(&["verify", "run", "--sign", "--key", "new.key", "--force"], 0);
    verify(&folder, "run", &["--public-key", "new.pub"], 0);
}
