//! Damage to the files of a completed day: a file that is cut, a line that is lost, doubled or exchanged, a byte that
//! is changed, a file that is missing, empty or of another run. `reduce`, `report` and `run --resume` then either
//! refuse and name the file, or give the very same numbers; never another number with exit code 0.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use crate::folder::Folder;
use crate::support::{random, rounds};

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

/// A completed day, another one of a brighter lamp, and what the first one says of itself.
struct Days {
    folder: Folder,
    flux: String,
    page: String,
}

impl Days {
    fn new() -> Self {
        let folder = Folder::in_memory();
        folder.isolux(&["init", "bench"], 0);
        folder.write("bench/plan.toml", PLAN);
        let scene = folder.read("bench/scene.toml");
        folder.write("bench/scene.toml", &scene.replace("[2048, 2048]", "[32, 32]"));
        folder.isolux(&["run", "bench/job.toml", "--out", "day"], 0);
        // The same plan and station file in a room with another lamp.
        let station = folder.read("bench/station.toml");
        let named = "name = \"virtual darkroom\"\n";
        assert!(station.contains(named));
        folder.write(
            "bench/room.toml",
            "format = \"isolux-darkroom/1\"\n[lamp]\nflux_lm = 400.0\n",
        );
        folder.write(
            "bench/station.toml",
            &station.replace(named, &format!("{named}darkroom = \"room.toml\"\n")),
        );
        folder.isolux(&["run", "bench/job.toml", "--out", "other"], 0);
        let mut days = Self {
            folder,
            flux: String::new(),
            page: String::new(),
        };
        days.restore();
        days.flux = days.numbers(&days.run(&["reduce", "damaged", "--out", "again"]));
        days.run(&["report", "damaged", "--out", "page.html"]);
        days.page = days.shown();
        assert!(days.flux.contains("flux") && days.page.contains("luminous flux"));
        days
    }

    /// A fresh copy of the day, and no results of the last round.
    fn restore(&self) {
        for name in ["damaged", "again"] {
            let _ = fs::remove_dir_all(self.folder.path(name));
        }
        let _ = fs::remove_file(self.folder.path("page.html"));
        copy(&self.folder.path("day"), &self.folder.path("damaged"));
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.folder.start(arguments).wait_with_output().unwrap()
    }

    /// budget.json of the reduction; the notes say what is known of the record and are no numbers.
    fn numbers(&self, output: &Output) -> String {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mut budget = self.folder.json("again/budget.json");
        budget["notes"].take();
        budget.to_string()
    }

    /// The report without its list of files and without the paragraphs on the record.
    fn shown(&self) -> String {
        let page = self.folder.read("page.html");
        // Hashes and the list of files say what is of another time; they hold no number.
        let (before, _) = page.split_once("<h2>Provenance</h2>").unwrap();
        // Warm-up and stabilisation are told by the journal, without which every number is the same.
        let (until, after) = before.split_once("<h3>Stability</h3>").unwrap();
        let page: String = until
            .lines()
            .filter(|line| !line.contains("<td>stabilisation</td>"))
            .chain(after.split_once("Drift:").map(|(_, rest)| rest))
            .collect();
        let notices = ["events.jsonl", "is ignored", "are ignored", "was never stopped"];
        page.split("<p>")
            .map(|paragraph| match paragraph.split_once("</p>") {
                Some((words, rest)) if notices.iter().any(|notice| words.contains(notice)) => rest.trim_start(),
                _ => paragraph,
            })
            .map(|paragraph| paragraph.replace("damaged/", "").replace("day/", ""))
            .collect()
    }

    /// What the day says of itself after `file` was damaged in it.
    fn judge(&self, file: &str, what: &str) -> Verdict {
        let name = Path::new(file).file_name().unwrap().to_str().unwrap();
        let mut refused = 0;
        for (arguments, reduces) in [
            (["reduce", "damaged", "--out", "again"], true),
            (["report", "damaged", "--out", "page.html"], false),
        ] {
            let output = self.run(&arguments);
            let stated = String::from_utf8_lossy(&output.stderr).into_owned();
            let command = arguments[0];
            match output.status.code() {
                Some(0) if reduces => assert_eq!(self.numbers(&output), self.flux, "{command}, {file} {what}"),
                Some(0) => assert!(self.shown() == self.page, "{command}, {file} {what}: another page"),
                Some(2) => {
                    refused += 1;
                    // A folder of copies is named with any of its files.
                    let folder = Path::new(file).parent().and_then(Path::to_str).unwrap_or_default();
                    let named = stated.contains(name) || !folder.is_empty() && stated.contains(folder);
                    assert!(named, "{command}, {file} {what}: {stated}");
                }
                other => panic!("{command}, {file} {what}: {other:?} {stated}"),
            }
        }
        if refused == 0 { Verdict::Same } else { Verdict::Refused }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Same,
    Refused,
}

pub fn a_damaged_record_is_refused_or_gives_the_same_numbers() {
    let days = Days::new();
    // Pages that nobody computes from, and what `report` makes again or marks as not of this day.
    let not_read = ["results/report.html", "results/irradiance", "results/diagnosis/"];
    let files: Vec<String> = files(&days.folder.path("day"))
        .into_iter()
        .filter(|file| !not_read.iter().any(|start| file.starts_with(start)))
        .collect();
    assert!(files.len() > 12, "{files:?}");
    let mut seen = BTreeSet::new();
    for round in 0..rounds(files.len() as u64) {
        let mut random = random(round);
        let file = &files[round as usize % files.len()];
        days.restore();
        let damaged = days.folder.path(&format!("damaged/{file}"));
        let other = days.folder.path(&format!("other/{file}"));
        let what = damage(&damaged, &other, &mut random);
        if fs::read(&damaged).ok() == fs::read(days.folder.path(&format!("day/{file}"))).ok() {
            continue;
        }
        let verdict = days.judge(file, &what);
        // What numbers are computed from is never merely ignored.
        let bound = ["run.toml", "readings.csv"].contains(&file.as_str()) || file.starts_with("spectra/");
        assert!(
            !bound || verdict == Verdict::Refused,
            "{file} {what}: taken as if nothing were"
        );
        seen.insert(file.clone());
    }
    assert!(seen.len() > files.len() / 2, "{seen:?}");
}

/// The damages that gave a wrong number with exit code 0 before there were hashes.
pub fn rows_and_pixels_that_are_lost_are_named_and_can_be_read_again() {
    let days = Days::new();
    for (file, kept) in [("readings.csv", 60), ("spectra/000.csv", 700)] {
        days.restore();
        let damaged = format!("damaged/{file}");
        let text = days.folder.read(&damaged);
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        assert!(kept < lines.len());
        days.folder.write(&damaged, &lines[..kept].concat());
        assert_eq!(days.judge(file, "cut"), Verdict::Refused);
        // The advice ends the matter: one command, no circle.
        let stated = days.folder.isolux(&["run", "--resume", "damaged"], 2);
        assert!(stated.contains("isolux run --resume damaged --reread"), "{stated}");
    }
    days.restore();
    let text = days.folder.read("damaged/readings.csv");
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // The last rows are those with the lamp off; the station is again that of the day.
    let station = days.folder.read("bench/station.toml");
    days.folder
        .write("bench/station.toml", &station.replace("darkroom = \"room.toml\"\n", ""));
    days.folder
        .write("damaged/readings.csv", &lines[..lines.len() - 4].concat());
    days.folder.isolux(&["run", "--resume", "damaged", "--reread"], 0);
    let again = days.folder.read("damaged/readings.csv");
    assert!(again.starts_with(&lines[..lines.len() - 4].concat()));
    assert_eq!(again.lines().count(), lines.len());
    assert_eq!(
        days.folder.read("damaged/damaged-1/readings.csv").lines().count(),
        lines.len() - 4
    );
    let stated = days.folder.isolux(&["reduce", "damaged", "--out", "again"], 0);
    assert!(
        stated.contains("was read again") && stated.contains("damaged-1"),
        "{stated}"
    );
}

/// One damage, in words.
fn damage(file: &Path, other: &Path, random: &mut ChaCha8Rng) -> String {
    let mut bytes = fs::read(file).unwrap();
    let place = |random: &mut ChaCha8Rng, length: usize| random.random_range(0..length.max(1));
    let mut lines: Vec<Vec<u8>> = bytes
        .split_inclusive(|byte| *byte == b'\n')
        .map(<[u8]>::to_vec)
        .collect();
    let line = place(random, lines.len());
    match random.random_range(0..8) {
        0 => {
            bytes.truncate(place(random, bytes.len()));
            fs::write(file, &bytes).unwrap();
            format!("cut to {} bytes", bytes.len())
        }
        1 if lines.len() > 1 => {
            lines.remove(line);
            fs::write(file, lines.concat()).unwrap();
            format!("without line {}", line + 1)
        }
        2 if lines.len() > 1 => {
            lines.insert(line, lines[line].clone());
            fs::write(file, lines.concat()).unwrap();
            format!("with line {} doubled", line + 1)
        }
        3 if lines.len() > 2 => {
            let line = place(random, lines.len() - 1);
            lines.swap(line, line + 1);
            fs::write(file, lines.concat()).unwrap();
            format!("with lines {} and {} exchanged", line + 1, line + 2)
        }
        4 => {
            fs::remove_file(file).unwrap();
            "missing".to_owned()
        }
        5 if other.is_file() => {
            fs::copy(other, file).unwrap();
            "of another run".to_owned()
        }
        6 => {
            fs::write(file, b"").unwrap();
            "empty".to_owned()
        }
        _ if !bytes.is_empty() => {
            let at = place(random, bytes.len());
            bytes[at] ^= 1 << random.random_range(0..7);
            fs::write(file, &bytes).unwrap();
            format!("with byte {at} changed")
        }
        _ => "as it was".to_owned(),
    }
}

/// The files below `folder`, by their names in it.
fn files(folder: &Path) -> Vec<String> {
    fn below(folder: &Path, root: &Path, found: &mut Vec<String>) {
        let mut entries: Vec<PathBuf> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                below(&path, root, found);
            } else {
                found.push(path.strip_prefix(root).unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    let mut found = Vec::new();
    below(folder, folder, &mut found);
    found
}

fn copy(from: &Path, to: &Path) {
    for file in files(from) {
        let target = to.join(&file);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(from.join(file), target).unwrap();
    }
}
