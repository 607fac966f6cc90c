//! The benchmark of the diagnosis: `cargo bench -p isolux-hidden-effects --bench diagnosis -- [gonio|sensor] [cases a class] [class]`.
//!
//! Every case is written into a folder that holds what an operator has; its truth stays in this process. The answer is read
//! from `diagnosis.json`; the gap from what `predict` says with `model.after.toml` alone.

use std::collections::BTreeMap;
use std::io::Write as _;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::files::Overwrite;
use isolux_app::progress::Silent;
use isolux_app::{diagnose, predict};
use isolux_hidden_effects::case::{self, Case};
use isolux_hidden_effects::suite::{self, Answer, Class};

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let sensors: Vec<bool> = match words.first().map(String::as_str) {
        Some("gonio") => vec![false],
        Some("sensor") => vec![true],
        _ => vec![false, true],
    };
    let count: u64 = words.get(1).and_then(|word| word.parse().ok()).unwrap_or(44);
    let only = words.get(2).cloned().unwrap_or_default();
    let seed: u64 = words.get(3).and_then(|word| word.parse().ok()).unwrap_or(20_261);
    let classes = [
        Class::CleanWhite,
        Class::CleanCorrelated,
        Class::CleanOutliers,
        Class::Single(3),
        Class::Single(5),
        Class::Single(10),
        Class::Single(30),
        Class::Pair,
        Class::Outside(10),
        Class::Outside(20),
        Class::Common,
    ];
    let mut out = std::io::stdout().lock();
    for sensor in sensors {
        let mut confusion: BTreeMap<(String, String), usize> = BTreeMap::new();
        let mut calibration: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
        let mut lines = Vec::new();
        let mut slowest: f64 = 0.0;
        for class in classes {
            if !format!("{class:?}").contains(&only) || sensor && matches!(class, Class::CleanCorrelated) {
                continue;
            }
            let mut scores: BTreeMap<&'static str, (usize, usize)> = BTreeMap::new();
            let (mut removed, mut made, mut seconds) = (Vec::new(), 0, 0.0);
            for order in suite::orders(class, sensor, count, seed) {
                let Some(case) = case::make(&order) else { continue };
                let answer = answer(&case);
                made += 1;
                seconds += answer.seconds;
                slowest = slowest.max(answer.seconds);
                let judged = suite::judge(class, &order, &answer);
                let bad = judged.iter().any(|(goal, met)| match *goal {
                    "false alarm" | "claimed > 95 % sure, but wrong" => *met,
                    "detected" | "only that name" => false,
                    _ => !met,
                });
                let mark = if bad || answer.removed.is_some_and(|r| r < 0.9) {
                    "✗"
                } else {
                    "·"
                };
                let strength = &case.strength;
                let _ = writeln!(
                    out,
                    "{mark} {class:?} seed {} {:?} → {answer:?} strength {strength:?}",
                    order.seed, order.hidden
                );
                let _ = out.flush();
                for (goal, met) in judged {
                    let entry = scores.entry(goal).or_default();
                    entry.0 += usize::from(met);
                    entry.1 += 1;
                }
                if let (Class::Single(_), Some((truth, _))) = (class, order.hidden.first()) {
                    let said = match answer.verdict.as_str() {
                        "consistent" | "unexplained" => answer.verdict.clone(),
                        _ => answer.effects[0].0.clone(),
                    };
                    *confusion.entry(((*truth).to_owned(), said)).or_default() += 1;
                }
                for (name, _, posterior) in &answer.effects {
                    let bin = calibration.entry((posterior * 10.0).min(9.0) as u32).or_default();
                    bin.0 += usize::from(order.hidden.iter().any(|(truth, _)| truth == name));
                    bin.1 += 1;
                }
                removed.extend(
                    answer
                        .removed
                        .filter(|_| matches!(class, Class::Single(_) | Class::Pair)),
                );
            }
            for (goal, (hits, n)) in &scores {
                lines.push(format!(
                    "{class:<20} {goal:<32} {}",
                    suite::share(*hits, *n),
                    class = format!("{class:?}")
                ));
            }
            removed.sort_by(f64::total_cmp);
            if let Some(median) = removed.get(removed.len() / 2) {
                let low = removed[removed.len() / 10];
                lines.push(format!(
                    "{:<20} {:<32} median {median:.4}, tenth {low:.4}",
                    format!("{class:?}"),
                    "held-out gap removed"
                ));
            }
            lines.push(format!(
                "{:<20} {:<32} {:.2} s",
                format!("{class:?}"),
                "mean time",
                seconds / f64::from(made.max(1))
            ));
            let _ = writeln!(out, "{class:?} done: {made} cases");
            let _ = out.flush();
        }
        let _ = writeln!(
            out,
            "\n{}\n{}",
            if sensor { "SENSOR" } else { "GONIO" },
            lines.join("\n")
        );
        let _ = writeln!(out, "slowest {slowest:.2} s\n\nconfusion (hidden → said)");
        for ((truth, said), n) in &confusion {
            let _ = writeln!(out, "{truth:<20} {said:<20} {n}");
        }
        let _ = writeln!(out, "\ncalibration (claimed posterior: right/claims)");
        for (bin, (right, n)) in &calibration {
            let _ = writeln!(
                out,
                "{:.1}–{:.1}  {}",
                f64::from(*bin) / 10.0,
                f64::from(bin + 1) / 10.0,
                suite::share(*right, *n)
            );
        }
    }
}

fn answer(case: &Case) -> Answer {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).expect("a UTF-8 path");
    case.write(folder.path()).expect("the case on disk");
    let started = std::time::Instant::now();
    let observations = path.join(if case.order.sensor { "maps.toml" } else { "readings.csv" });
    let out = path.join("diagnosis");
    let request = diagnose::Request {
        model: path.join("model.toml"),
        observations: vec![observations],
        out: out.clone(),
        held_out: None,
        seed: 1,
        accept: false,
        overwrite: Overwrite::Never,
    };
    diagnose::run(&request, &Silent).expect("a diagnosis");
    let seconds = started.elapsed().as_secs_f64();
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("diagnosis.json")).expect("diagnosis.json")).expect("JSON");
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let effects: Vec<(String, Vec<String>, f64)> = json["effects"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|effect| {
            let equivalents = effect["equivalents"]
                .as_array()
                .into_iter()
                .flatten()
                .map(text)
                .collect();
            (
                text(&effect["name"]),
                equivalents,
                effect["evidence"]["posterior"].as_f64().unwrap_or(0.0),
            )
        })
        .collect();
    let removed = (!effects.is_empty()).then(|| gap(case, &path, &out)).flatten();
    Answer {
        verdict: text(&json["verdict"]),
        effects,
        removed,
        seconds,
    }
}

/// Held-out gap removed, against noise-free truth: 1 − after²/before², both in true σ.
fn gap(case: &Case, path: &Utf8Path, out: &Utf8Path) -> Option<f64> {
    let residual = |model: &str| -> Option<f64> {
        let file = out.join(format!("{model}.csv"));
        predict::run(&out.join(model), &path.join(case.held_out.0), &file, Overwrite::Never).expect("a prediction");
        let text = std::fs::read_to_string(&file).ok()?;
        let values = text
            .lines()
            .skip(1)
            .filter_map(|line| line.rsplit(',').next()?.parse::<f64>().ok());
        Some(
            case.truth
                .iter()
                .zip(values)
                .map(|((truth, sigma), value)| ((truth - value) / sigma).powi(2))
                .sum(),
        )
    };
    let (before, after) = (residual("model.baseline.toml")?, residual("model.after.toml")?);
    // Only where the held-out rows show the effect at all.
    (before > 16.0).then(|| 1.0 - after / before)
}
