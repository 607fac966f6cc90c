//! Seeded damages of good files: each that changes what a file says must give a warning or an error.
//!
//! Runs over the files in `tests/good`; `ISOLUX_DAMAGE_FOLDER` adds a folder, `ISOLUX_DAMAGE_LIST=1` prints every miss.

#![expect(clippy::print_stdout, reason = "the rates are what a person runs this for")]

use std::path::{Path, PathBuf};

use isolux_formats::{Content, Finding, Severity, read_any};

/// SplitMix64: the same damages everywhere.
struct Seeded(u64);

impl Seeded {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

struct Answer {
    /// Angles and candela as text, lamp flux: what a file means; none when it could not be read.
    meaning: Option<String>,
    loud: Vec<Finding>,
}

fn ask(bytes: &[u8], name: &str) -> Answer {
    let mut parsed = read_any(bytes, name);
    let only = parsed.remove(0);
    let meaning = match only.document {
        Some(Content::Distribution(d)) => Some(format!(
            "{:?}{:?}{:?}",
            d.intensity.c_deg(),
            d.intensity.gamma_deg(),
            d.intensity.intensity_cd()
        )),
        _ => None,
    };
    let loud = only
        .findings
        .into_iter()
        .filter(|finding| finding.severity >= Severity::Warning)
        .collect();
    Answer { meaning, loud }
}

const DAMAGES: [&str; 10] = [
    "line dropped",
    "line doubled",
    "neighbours swapped",
    "numbers swapped",
    "letter in number",
    "NaN",
    "1e300",
    "cut off",
    "count off",
    "digit changed",
];

/// Byte ranges of the numbers from `from` on.
fn numbers(bytes: &[u8], from: usize) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut at = from;
    while at < bytes.len() {
        if bytes[at].is_ascii_digit() || matches!(bytes[at], b'-' | b'.' | b'+') {
            let start = at;
            while at < bytes.len() && !matches!(bytes[at], b' ' | b',' | b'\t' | b'\r' | b'\n') {
                at += 1;
            }
            found.push((start, at));
        } else {
            at += 1;
        }
    }
    found
}

/// Where the numbers of the light begin, after header texts.
fn light_from(bytes: &[u8], ldt: bool) -> usize {
    if ldt {
        let mut line = 0;
        return bytes
            .iter()
            .position(|&byte| {
                line += usize::from(byte == b'\n');
                line >= 42
            })
            .unwrap_or(0);
    }
    let upper = bytes.to_ascii_uppercase();
    upper.windows(5).position(|w| w == b"TILT=").map_or(0, |at| at + 10)
}

fn damaged(kind: &str, bytes: &[u8], ldt: bool, seeded: &mut Seeded) -> Option<Vec<u8>> {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let from = light_from(bytes, ldt);
    let numbers = numbers(bytes, from);
    if lines.len() < 8 || numbers.len() < 30 {
        return None;
    }
    let put = |range: (usize, usize), text: &[u8]| [&bytes[..range.0], text, &bytes[range.1..]].concat();
    let any = numbers[seeded.below(numbers.len())];
    match kind {
        "line dropped" => {
            lines.remove(seeded.below(lines.len()));
            Some(lines.concat())
        }
        "line doubled" => {
            let at = seeded.below(lines.len());
            lines.insert(at, lines[at]);
            Some(lines.concat())
        }
        "neighbours swapped" | "numbers swapped" => {
            let i = seeded.below(numbers.len() - 1);
            let j = if kind == "numbers swapped" {
                seeded.below(numbers.len())
            } else {
                i + 1
            };
            let (a, b) = (numbers[i.min(j)], numbers[i.max(j)]);
            if i == j {
                return None;
            }
            Some(
                [
                    &bytes[..a.0],
                    &bytes[b.0..b.1],
                    &bytes[a.1..b.0],
                    &bytes[a.0..a.1],
                    &bytes[b.1..],
                ]
                .concat(),
            )
        }
        "letter in number" => {
            let at = any.0 + seeded.below(any.1 - any.0);
            Some(put((at, at + 1), &[b"OlISBxq"[seeded.below(7)]]))
        }
        "NaN" => Some(put(any, b"NaN")),
        "1e300" => Some(put(any, b"1e300")),
        "cut off" => Some(bytes[..seeded.below(bytes.len())].to_vec()),
        "count off" => {
            let line = if ldt { [3, 5, 25][seeded.below(3)] } else { 0 };
            let start: usize = if ldt {
                lines[..line].iter().map(|l| l.len()).sum()
            } else {
                from
            };
            let all = self::numbers(bytes, start);
            let range = all[if ldt { 0 } else { 3 + seeded.below(2) }];
            let count: i64 = std::str::from_utf8(&bytes[range.0..range.1]).ok()?.parse().ok()?;
            let off = count + if seeded.below(2) == 0 { 1 } else { -1 };
            Some(put(range, off.to_string().as_bytes()))
        }
        "digit changed" => {
            let at = any.0 + seeded.below(any.1 - any.0);
            bytes[at]
                .is_ascii_digit()
                .then(|| put((at, at + 1), &[b'0' + seeded.below(10) as u8]))
        }
        _ => None,
    }
}

fn numbers_text(bytes: &[u8], ldt: bool) -> Vec<String> {
    let from = light_from(bytes, ldt);
    numbers(bytes, from)
        .into_iter()
        .map(|(a, b)| String::from_utf8_lossy(&bytes[a..b]).into_owned())
        .collect()
}

fn files(folder: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            files(&path, into);
        } else if path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("ldt") || end.eq_ignore_ascii_case("ies"))
        {
            into.push(path);
        }
    }
}

#[test]
fn damage_is_reported() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = Vec::new();
    files(&root.join("tests/good"), &mut all);
    if let Ok(folder) = std::env::var("ISOLUX_DAMAGE_FOLDER") {
        files(Path::new(&folder), &mut all);
    }
    let list = std::env::var("ISOLUX_DAMAGE_LIST").is_ok();
    let mut seeded = Seeded(20_251_121);
    let mut seen = std::collections::HashSet::new();
    let (mut good, mut loud) = (0, 0);
    let mut tally = vec![(0usize, 0usize); DAMAGES.len()];
    for path in &all {
        let bytes = std::fs::read(path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let ldt = name.to_ascii_lowercase().ends_with("ldt");
        let before = ask(&bytes, &name);
        let meaning = match &before.meaning {
            Some(meaning) if bytes.len() < 300_000 && meaning.len() > 300 && seen.insert(meaning.clone()) => {
                meaning.clone()
            }
            _ => continue,
        };
        if before.loud.iter().any(|finding| finding.severity == Severity::Error) {
            continue;
        }
        good += 1;
        let outlier = before
            .loud
            .iter()
            .filter(|finding| finding.code == "intensity-outlier")
            .count();
        loud += usize::from(outlier > 0);
        if list && outlier > 0 {
            println!(
                "quiet file is loud: {name}: {:?}",
                before
                    .loud
                    .iter()
                    .map(|f| (f.code, f.line, &f.message))
                    .collect::<Vec<_>>()
            );
        }
        for (kind, tally) in DAMAGES.iter().zip(&mut tally) {
            for _ in 0..4 {
                let original = bytes.clone();
                let Some(bytes) = damaged(kind, &bytes, ldt, &mut seeded) else {
                    continue;
                };
                let after = ask(&bytes, &name);
                if after.meaning.as_ref() == Some(&meaning) {
                    continue;
                }
                tally.0 += 1;
                let reported = after.loud.iter().any(|finding| !before.loud.contains(finding));
                assert!(
                    reported || after.meaning.is_some(),
                    "{name}: {kind}: unreadable without an error"
                );
                tally.1 += usize::from(reported);
                if list && !reported {
                    let (a, b) = (numbers_text(&original, ldt), numbers_text(&bytes, ldt));
                    let odd: Vec<usize> = (0..a.len().min(b.len())).filter(|&i| a[i] != b[i]).take(3).collect();
                    let around = odd
                        .first()
                        .map(|&i| a[i.saturating_sub(4)..(i + 6).min(a.len())].join(" "));
                    println!("missed: {name}: {kind}: {odd:?} in {around:?}");
                }
            }
        }
    }
    println!("{good} good files, {loud} with an outlier finding");
    for (kind, (damaged, reported)) in DAMAGES.iter().zip(&tally) {
        println!(
            "{kind:20} {reported:5} of {damaged:5} reported ({:.1} %)",
            100.0 * *reported as f64 / (*damaged).max(1) as f64
        );
    }
    let rate = |kind: &str| {
        let (damaged, reported) = tally[DAMAGES.iter().position(|other| *other == kind).unwrap()];
        if damaged == 0 {
            1.0
        } else {
            reported as f64 / damaged as f64
        }
    };
    for kind in [
        "line dropped",
        "line doubled",
        "letter in number",
        "NaN",
        "1e300",
        "count off",
    ] {
        assert_eq!(rate(kind), 1.0, "{kind}");
    }
    // A finding that good files have too says nothing.
    assert!(20 * loud <= good, "{loud} of {good} good files are warned of");
    assert!(rate("cut off") > 0.98);
    // Values that are exchanged or changed are reported where they contradict their neighbours; no rate is promised.
}
