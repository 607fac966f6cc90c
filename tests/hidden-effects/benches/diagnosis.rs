//! The benchmark of the diagnosis: `cargo bench -p isolux-hidden-effects --bench diagnosis -- [all|gonio|sensor] [cases
//! a class] [class] [seed]`.
//!
//! Every case is written into a folder that holds what an operator has; its truth stays in this process. The answer is
//! the document of the diagnosis; the gap is scored from what `model.after.toml`, read again from its file, predicts at
//! held-out coordinates. Without a number each class has as many cases as an hour or less allows; `-` stands for that.

use std::collections::BTreeMap;
use std::io::Write as _;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::diagnosis::{Diagnosis, diagnose};
use isolux_diagnose::document::{RankedEntry, Verdict};
use isolux_diagnose::search::Settings;
use isolux_hidden_effects::case::{self, Case, Order};
use isolux_hidden_effects::follow_up::follow_up;
use isolux_hidden_effects::suite::{self, Answer, Class, Next};
use isolux_hidden_effects::tables::{Calibration, Confusion, Worth};
use isolux_model::Model;
use isolux_record::observation::{Need, Observations, open};
use rayon::prelude::*;

/// Maps or readings, what is hidden, how many cases: every effect and every strange one at least once, false alarms,
/// the rarer, oftener where they are cheap. What the goals name comes first.
const SUITE: [(bool, Class, u64); 29] = [
    (false, Class::CleanWhite, 150),
    (false, Class::Single(10), 44),
    (false, Class::Single(5), 44),
    (false, Class::Pair, 33),
    (false, Class::Outside(10), 24),
    (false, Class::Single(30), 22),
    (false, Class::CleanCorrelated, 48),
    (false, Class::Common, 22),
    (true, Class::CleanWhite, 20),
    (true, Class::Single(10), 15),
    (true, Class::Outside(10), 12),
    (false, Class::CleanOutliers, 24),
    (false, Class::Single(3), 22),
    (false, Class::Outside(20), 12),
    (true, Class::Single(30), 15),
    (false, Class::Developed(10), 12),
    (false, Class::Developed(30), 12),
    (false, Class::Fresh(10), 24),
    (false, Class::Fresh(30), 24),
    (false, Class::Later(10), 24),
    (false, Class::Later(30), 24),
    (false, Class::Unforeseen(10), 36),
    (false, Class::Unforeseen(30), 36),
    (false, Class::Second(10), 24),
    (false, Class::Second(30), 24),
    (false, Class::Third(10), 24),
    (false, Class::Third(30), 24),
    (false, Class::Fourth(10), 24),
    (false, Class::Fourth(30), 24),
];

fn main() {
    let words: Vec<String> = std::env::args()
        .skip(1)
        .filter(|word| !word.starts_with("--"))
        .collect();
    let kind = words.first().map_or("all", String::as_str);
    let count: Option<u64> = words.get(1).and_then(|word| word.parse().ok());
    let only = words.get(2).cloned().unwrap_or_default();
    let seed: u64 = words.get(3).and_then(|word| word.parse().ok()).unwrap_or(20_261);
    let wanted = |(sensor, class, _): &&(bool, Class, u64)| {
        format!("{class:?}").contains(&only)
            && match kind {
                "gonio" => !sensor,
                "sensor" => *sensor,
                _ => true,
            }
    };
    let mut calibration = Calibration::default();
    let mut worth = Worth::default();
    let mut confusions = [Confusion::default(), Confusion::default()];
    let mut pooled: BTreeMap<&'static str, (usize, usize)> = BTreeMap::new();
    for &(sensor, class, cases) in SUITE.iter().filter(wanted) {
        let orders = suite::orders(class, sensor, count.unwrap_or(cases), seed);
        let answers: Vec<(Order, Answer)> = orders
            .par_iter()
            .filter_map(|order| {
                let case = case::make(order)?;
                let answer = answer(&case);
                tell(class, order, &answer, &case);
                Some((order.clone(), answer))
            })
            .collect();
        say(&format!("\n{}", if sensor { "MAPS" } else { "READINGS" }));
        say(&score(class, &answers).join("\n"));
        say("");
        for (order, answer) in &answers {
            calibration.add(order, answer);
            worth.add(order, answer);
            if matches!(class, Class::Single(_)) {
                confusions[usize::from(sensor)].add(order, answer);
            }
            for (goal, met) in suite::judge(class, order, answer) {
                let entry = pooled.entry(goal).or_default();
                entry.0 += usize::from(met);
                entry.1 += 1;
            }
        }
        // What is done is kept, should the rest be broken off.
        if let Ok(file) = std::env::var("RELIABILITY_SVG") {
            std::fs::write(&file, calibration.svg()).expect("the diagram can be written");
        }
    }
    for (of, confusion) in ["READINGS", "MAPS"].iter().zip(&confusions) {
        say(&format!("\n{of}\n{}", confusion.markdown()));
    }
    say("ALL TOGETHER");
    for (goal, (hits, n)) in pooled {
        say(&format!("{goal:<40} {}", suite::share(hits, n)));
    }
    say(&calibration.markdown());
    say(&worth.markdown());
}

fn say(text: &str) {
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

fn score(class: Class, answers: &[(Order, Answer)]) -> Vec<String> {
    let mut scores: BTreeMap<&'static str, (usize, usize)> = BTreeMap::new();
    for (order, answer) in answers {
        for (goal, met) in suite::judge(class, order, answer) {
            let entry = scores.entry(goal).or_default();
            entry.0 += usize::from(met);
            entry.1 += 1;
        }
    }
    let label = format!("{class:?}");
    let mut lines: Vec<String> = scores
        .iter()
        .map(|(goal, (hits, n))| format!("{label:<16} {goal:<32} {}", suite::share(*hits, *n)))
        .collect();
    for (what, share) in [
        (
            "held-out gap removed",
            (|answer| answer.removed) as fn(&Answer) -> Option<f64>,
        ),
        ("held-out gap removed, floor 0", |answer| answer.removed_of_all),
        ("… by the best possible fit", |answer| answer.removable),
        ("held-out deviation before, σ", |answer| answer.deviation.map(|d| d.0)),
        ("held-out deviation after, σ", |answer| answer.deviation.map(|d| d.1)),
    ] {
        let mut removed: Vec<f64> = answers
            .iter()
            .filter(|_| matches!(class, Class::Single(_) | Class::Pair))
            .filter_map(|(_, answer)| share(answer))
            .collect();
        removed.sort_by(f64::total_cmp);
        if let (Some(median), Some(low)) = (removed.get(removed.len() / 2), removed.get(removed.len() / 10)) {
            lines.push(format!("{label:<16} {what:<32} median {median:.4}, tenth {low:.4}"));
        }
    }
    let seconds: f64 = answers.iter().map(|(_, answer)| answer.seconds).sum();
    lines.push(format!(
        "{label:<16} {:<32} {:.2} s",
        "mean time, two at once",
        seconds / answers.len().max(1) as f64
    ));
    lines
}

fn tell(class: Class, order: &Order, answer: &Answer, case: &Case) {
    let bad = suite::judge(class, order, answer)
        .iter()
        .any(|(goal, met)| match *goal {
            "false alarm" | "claimed > 95 % sure, but wrong" => *met,
            "detected" | "only that name" | "suggestion settles it" | "ambiguity has a suggestion of 3 σ" => false,
            _ => !met,
        });
    let mark = if bad {
        "✗"
    } else if answer.removed.is_some_and(|removed| removed < 0.9) {
        "-"
    } else {
        "·"
    };
    say(&format!(
        "{mark} {class:?} seed {} ρ {} {:?} → {} {:?} {:?} {:?} {:.1} s strength {:.2?} next {:?} p of scan and noise, scale, ρ {:.4?} ranked {:.3?}",
        order.seed,
        order.rho,
        order.hidden,
        answer.verdict,
        answer.effects,
        answer.place,
        answer.removed,
        answer.seconds,
        case.strength,
        answer.next,
        answer.noise,
        answer.ranked
    ));
}

fn read(folder: &Utf8Path, case: &Case) -> (Model, Observations) {
    let observations = folder.join(if case.order.sensor { "maps.toml" } else { "readings.csv" });
    (
        Model::load(&folder.join("model.toml")).expect("a model"),
        open(&observations, Need::Values).expect("observations"),
    )
}

fn answer(case: &Case) -> Answer {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = Utf8PathBuf::try_from(folder.path().to_owned()).expect("a UTF-8 path");
    case.write(folder.path()).expect("the case on disk");
    let started = std::time::Instant::now();
    let (model, observations) = read(&path, case);
    let found = diagnose(&model, &[observations], None, "", &Settings::default()).expect("a diagnosis");
    let seconds = started.elapsed().as_secs_f64();
    let document = &found.document;
    let gap = (!document.effects.is_empty())
        .then(|| gap(case, &path, &found))
        .flatten();
    Answer {
        verdict: match document.verdict {
            Verdict::Consistent => "consistent",
            Verdict::Named => "named",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
        .to_owned(),
        effects: document
            .effects
            .iter()
            .map(|effect| {
                (
                    effect.name.clone().into_owned(),
                    effect.equivalents.clone(),
                    effect.evidence.posterior,
                )
            })
            .collect(),
        place: document
            .unexplained
            .as_ref()
            .map(|place| format!("{}: {}", place.coordinate, place.note)),
        tests: document
            .noise
            .test
            .iter()
            .flat_map(|test| &test.findings)
            .map(|finding| format!("{:?}", finding.test))
            .collect(),
        removed: gap.map(|gap| gap.0),
        removed_of_all: gap.map(|gap| gap.1),
        removable: gap
            .and_then(|(_, _, (before, _))| Some(1.0 - case.unavoidable? / (before.powi(2) * case.truth.len() as f64))),
        deviation: gap.map(|gap| gap.2),
        next: next(case, &path, &found),
        seconds,
        noise: [
            document.noise.p_global.unwrap_or(f64::NAN),
            document.noise.test.as_ref().map_or(f64::NAN, |test| test.p_value),
            document.noise.scale,
            document.noise.autocorrelation,
        ],
        ranked: document
            .ranked
            .iter()
            .map(|of_one| {
                let line = |entry: &RankedEntry| {
                    (
                        entry.name.clone(),
                        entry.posterior,
                        entry.significance_sigma,
                        entry.ln_evidence,
                    )
                };
                of_one.iter().take(10).map(line).collect()
            })
            .collect(),
    }
}

/// Held-out gap removed, against noise-free truth: (before² − after²)/(before² − floor²), all in true σ, where `floor`
/// is what a refitted baseline leaves in the same noise with nothing hidden; and the same with a floor of zero.
fn gap(case: &Case, path: &Utf8Path, found: &Diagnosis) -> Option<(f64, f64, (f64, f64))> {
    let residual = |model: &Model, name: &str, truth: &dyn Fn(usize) -> f64| -> f64 {
        let file = path.join(name);
        std::fs::write(&file, model.beside_its_files().to_toml()).expect("a model on disk");
        let model = Model::load(&file).expect("the model again");
        let predicted = match open(&path.join(case.held_out.0), Need::Coordinates).expect("coordinates") {
            Observations::Readings(readings) => {
                model.predict_readings(&readings.rows().iter().map(|row| row.at).collect::<Vec<_>>())
            }
            Observations::Maps(maps) => model.predict_maps(&maps),
            Observations::Spectra(_) => Vec::new(),
        };
        assert_eq!(
            predicted.len(),
            case.truth.len(),
            "one prediction for each held-out row"
        );
        let deviation = |(i, value): (usize, f64)| ((truth(i) - value) / case.truth[i].1).powi(2);
        predicted.into_iter().enumerate().map(deviation).sum()
    };
    let before = residual(&found.baseline, "baseline.toml", &|i| case.truth[i].0);
    let after = residual(&found.after, "after.toml", &|i| case.truth[i].0);
    let twin = path.join("without");
    case.write(twin.as_std_path()).expect("the twin on disk");
    let values = if case.order.sensor { "maps.csv" } else { "readings.csv" };
    std::fs::write(twin.join(values), &case.without.values).expect("the twin on disk");
    let (model, observations) = read(&twin, case);
    let settings = Settings {
        nulls: 20,
        ..Settings::default()
    };
    let healthy = diagnose(&model, &[observations], None, "", &settings).ok()?;
    let floor = residual(&healthy.baseline, "healthy.toml", &|i| case.without.truth[i]);
    // Only where the held-out rows show the effect at all.
    let rms = |square: f64| (square / case.truth.len().max(1) as f64).sqrt();
    (before > floor + 16.0).then(|| {
        let share = (before - after) / (before - floor);
        (share, 1.0 - after / before, (rms(before), rms(after)))
    })
}

/// Suggestions below this separation (σ) are not worth a measurement.
const WORTH_SIGMA: f64 = 3.0;

/// Carries out the first suggestion of an ambiguous answer and diagnoses old and new data together.
fn next(case: &Case, path: &Utf8Path, found: &Diagnosis) -> Option<Next> {
    let [(hidden, _)] = case.order.hidden.as_slice() else {
        return None;
    };
    if found.document.verdict != Verdict::Ambiguous {
        return None;
    }
    let suggestion = found
        .document
        .next_measurement
        .first()
        .filter(|entry| entry.expected_sigma >= WORTH_SIGMA);
    let Some(entry) = suggestion else {
        return Some(Next {
            suggested: None,
            verdict: String::new(),
            settled: false,
        });
    };
    let plan = found.plans.iter().find(|(file, _)| Some(file) == entry.plan.as_ref())?;
    let files = follow_up(&case.order, &plan.1)?;
    let folder = path.join("next");
    std::fs::create_dir_all(&folder).expect("a folder");
    for (name, content) in &files {
        std::fs::write(folder.join(name), content).expect("new data on disk");
    }
    let (model, old) = read(path, case);
    let new = open(&folder.join(files[0].0), Need::Values).expect("new observations");
    let together = diagnose(&model, &[old, new], None, "", &Settings::default()).expect("a diagnosis");
    let effects = &together.document.effects;
    let settled = together.document.verdict == Verdict::Named && effects.len() == 1 && effects[0].name == *hidden;
    Some(Next {
        suggested: Some((entry.what.clone().into_owned(), entry.expected_sigma)),
        verdict: together.document.sentence,
        settled,
    })
}
