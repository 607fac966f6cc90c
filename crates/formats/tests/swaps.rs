//! Two intensities exchanged: heard wherever the light changed by more than the file's own scatter hides.
//!
//! Every pair of neighbours in the files of `tests/good`, and seeded pairs in the shared corpus where it is present.

#![expect(clippy::print_stdout, reason = "the rates are what a person runs this for")]

use std::ops::Range;
use std::path::{Path, PathBuf};

use isolux_formats::{Severity, read_any};

/// A file with the places of its intensities.
struct File {
    name: String,
    bytes: Vec<u8>,
    places: Vec<Range<usize>>,
    values: Vec<f64>,
    /// Intensities a plane.
    ng: usize,
    peak: f64,
}

impl File {
    /// None where the file has an error, is very large, or its numbers are not laid out in the plain way.
    fn open(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().into_owned();
        let bytes = std::fs::read(path).ok().filter(|bytes| bytes.len() < 60_000)?;
        let findings = read_any(&bytes, &name).remove(0).findings;
        if findings.iter().any(|finding| finding.severity == Severity::Error) {
            return None;
        }
        let (ng, places) = if name.to_ascii_lowercase().ends_with("ldt") {
            let lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
            let count = |line: usize| std::str::from_utf8(lines[line]).ok()?.trim().parse::<usize>().ok();
            let (isym, mc, ng) = (count(2)?, count(3)?, count(5)?);
            let planes = [mc, 1, mc / 2 + 1, mc / 2 + 1, mc / 4 + 1][isym];
            let header: usize = lines.iter().take(26).map(|line| line.len() + 1).sum();
            let mut places = numbers(&bytes, header);
            (ng, places.split_off(places.len().checked_sub(planes * ng)?))
        } else {
            let tilt = bytes.windows(9).position(|window| window == b"TILT=NONE")?;
            let mut places = numbers(&bytes, tilt + 9);
            let count = |at: usize| {
                std::str::from_utf8(&bytes[places[at].clone()])
                    .ok()?
                    .parse::<usize>()
                    .ok()
            };
            let (ng, planes) = (count(3)?, count(4)?);
            (ng, places.split_off(places.len().checked_sub(planes * ng)?))
        };
        let value = |place: &Range<usize>| std::str::from_utf8(&bytes[place.clone()]).ok()?.parse::<f64>().ok();
        let values: Vec<f64> = places.iter().map(value).collect::<Option<_>>()?;
        let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        (ng > 6 && peak > 0.0).then_some(Self {
            name,
            bytes,
            places,
            values,
            ng,
            peak,
        })
    }

    /// Whether exchanging two intensities gives a warning that the file does not have.
    fn hears(&self, one: usize, other: usize) -> bool {
        let (a, b) = (self.places[one].clone(), self.places[other].clone());
        let parts = [
            &self.bytes[..a.start],
            &self.bytes[b.clone()],
            &self.bytes[a.end..b.start],
            &self.bytes[a],
            &self.bytes[b.end..],
        ];
        let loud = |bytes: &[u8]| {
            let findings = read_any(bytes, &self.name).remove(0).findings;
            let loud = findings
                .into_iter()
                .filter(|finding| finding.severity >= Severity::Warning);
            loud.collect::<Vec<_>>()
        };
        let before = loud(&self.bytes);
        loud(&parts.concat()).iter().any(|finding| !before.contains(finding))
    }

    /// Pairs of neighbours along γ that differ by more than `share` of the peak.
    fn neighbours(&self, share: f64) -> Vec<usize> {
        let differs = |at: &usize| (self.values[at + 1] - self.values[*at]).abs() > share * self.peak;
        (0..self.values.len() - 1)
            .filter(|at| (at + 1) % self.ng != 0)
            .filter(differs)
            .collect()
    }

    /// The same across planes.
    fn across(&self, share: f64) -> Vec<usize> {
        let differs = |at: &usize| (self.values[at + self.ng] - self.values[*at]).abs() > share * self.peak;
        (0..self.values.len() - self.ng).filter(differs).collect()
    }
}

fn numbers(bytes: &[u8], from: usize) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = from;
    while at < bytes.len() {
        let end = bytes[at..]
            .iter()
            .position(u8::is_ascii_whitespace)
            .map_or(bytes.len(), |length| at + length);
        if end > at {
            found.push(at..end);
        }
        at = end + 1;
    }
    found
}

fn files(folder: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, into);
        } else if path.extension().is_some_and(|end| end == "ldt" || end == "ies") {
            into.push(path);
        }
    }
}

fn opened(folder: &Path) -> Vec<File> {
    let mut paths = Vec::new();
    files(folder, &mut paths);
    paths.iter().filter_map(|path| File::open(path)).collect()
}

#[test]
fn every_exchange_of_neighbours_that_matters_is_heard() {
    let own = opened(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good"));
    assert_eq!(own.len(), 8);
    let mut tried = 0;
    for file in &own {
        for at in file.neighbours(0.01) {
            tried += 1;
            let (here, next) = (file.values[at], file.values[at + 1]);
            assert!(
                file.hears(at, at + 1),
                "{}: {here} and {next}, intensity {at}",
                file.name
            );
        }
    }
    println!("{tried} pairs of neighbours, all heard");
    assert!(tried > 300);
}

#[test]
fn exchanges_across_planes_are_heard() {
    let own = opened(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/good"));
    let (mut tried, mut heard) = (0, 0);
    for file in &own {
        for at in file.across(0.01) {
            tried += 1;
            let told = file.hears(at, at + file.ng);
            heard += usize::from(told);
            if !told {
                let (here, next) = (file.values[at], file.values[at + file.ng]);
                println!("{}: {here} and {next}, intensity {at}", file.name);
            }
        }
    }
    println!("{heard} of {tried} pairs across planes heard");
    assert!(tried > 100 && heard == tried);
}

#[test]
fn exchanges_in_the_shared_corpus_are_heard() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/corpus");
    if !folder.exists() {
        println!("shared corpus absent");
        return;
    }
    let (mut near, mut across, mut far) = ((0, 0), (0, 0), (0, 0));
    for file in opened(&folder) {
        let pairs = file.neighbours(0.01);
        for &at in pairs.iter().step_by(pairs.len() / 4 + 1) {
            near = (near.0 + 1, near.1 + usize::from(file.hears(at, at + 1)));
        }
        let pairs = file.across(0.01);
        for &at in pairs.iter().step_by(pairs.len() / 3 + 1) {
            across = (across.0 + 1, across.1 + usize::from(file.hears(at, at + file.ng)));
        }
        // Steps of the golden ratio spread over the file without a pattern.
        let count = file.values.len();
        for turn in 1..6 {
            let at = |turn: f64| ((turn * 0.618_034).fract() * count as f64) as usize;
            let (one, other) = (at(f64::from(turn)), at(f64::from(turn) * 7.0 + 0.3));
            let (one, other) = (one.min(other), one.max(other));
            if (file.values[one] - file.values[other]).abs() > 0.01 * file.peak {
                far = (far.0 + 1, far.1 + usize::from(file.hears(one, other)));
            }
        }
    }
    let rate = |(tried, heard): (usize, usize)| heard as f64 / f64::max(tried as f64, 1.0);
    println!(
        "neighbours along γ {near:?} {:.3}, across planes {across:?} {:.3}, apart {far:?} {:.3}",
        rate(near),
        rate(across),
        rate(far)
    );
    assert!(rate(near) > 0.93);
    assert!(rate(across) > 0.85);
    assert!(rate(far) > 0.95);
}
