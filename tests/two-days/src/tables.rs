//! What the answers add up to: the shares that are wanted, who was taken for whom, and how long it took.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::case::{Case, Order, Outcome};
use crate::days::DayError;
use crate::faults::Kind;
use crate::lamps::Lamp;
use crate::plans::Grid;
use crate::suite::SIGMAS;

/// A probability above this is a claim.
const SURE: f64 = 0.95;

/// One share that is asked for.
struct Share {
    what: &'static str,
    wanted: &'static str,
    /// Whether a case counts, and whether it is a hit.
    of: fn(&Case) -> Option<bool>,
}

fn sigma(case: &Case) -> f64 {
    case.order.fault.map_or(0.0, |(_, sigma)| sigma)
}

/// Whether the truth is among the names of an answer.
fn holds(case: &Case, truth: &str) -> bool {
    let mut effects = case.stated.effects.iter();
    effects.any(|(name, others, _)| name == truth || others.iter().any(|other| other == truth))
}

fn alone_and_right(case: &Case) -> Option<bool> {
    let truth = case.truth().filter(|_| case.separable())?;
    let [(name, others, _)] = case.stated.effects.as_slice() else {
        return Some(false);
    };
    Some(case.stated.verdict == "named" && name == truth && others.is_empty())
}

/// Whether an answer is sure of a name that is not the truth.
fn sure_and_wrong(case: &Case) -> bool {
    let sure =
        |others: &[String], posterior: f64| posterior > SURE || case.stated.verdict == "named" && others.is_empty();
    let mut effects = case.stated.effects.iter();
    effects.any(|(name, others, posterior)| sure(others, *posterior) && Some(name.as_str()) != case.truth())
}

const SHARES: [Share; 9] = [
    Share {
        what: "no fault: a disagreement reported",
        wanted: "≤ 2 %",
        of: |case| case.order.fault.is_none().then(|| case.stated.verdict != "consistent"),
    },
    Share {
        what: "10 and 30 σ: called consistent",
        wanted: "0",
        of: |case| (sigma(case) >= 10.0).then(|| case.stated.verdict == "consistent"),
    },
    Share {
        what: "10 and 30 σ: truth in the 95 % set",
        wanted: "≥ 97 %",
        of: |case| {
            case.truth()
                .filter(|_| sigma(case) >= 10.0)
                .map(|truth| holds(case, truth))
        },
    },
    Share {
        what: "10 σ, separable: named alone and right",
        wanted: "≥ 85 %",
        of: |case| alone_and_right(case).filter(|_| sigma(case) == 10.0),
    },
    Share {
        what: "30 σ, separable: named alone and right",
        wanted: "≥ 95 %",
        of: |case| alone_and_right(case).filter(|_| sigma(case) == 30.0),
    },
    Share {
        what: "all: sure and wrong",
        wanted: "≤ 1 %",
        of: |case| Some(sure_and_wrong(case)),
    },
    Share {
        what: "30 σ: 95 % of the gap gone where nobody looked",
        wanted: "all",
        of: |case| {
            case.removed
                .filter(|_| sigma(case) == 30.0)
                .map(|removed| removed >= 0.95)
        },
    },
    Share {
        what: "3 σ: a disagreement reported",
        wanted: "",
        of: |case| (sigma(case) == 3.0).then(|| case.stated.verdict != "consistent"),
    },
    Share {
        what: "10 and 30 σ: the plan can separate it",
        wanted: "",
        of: |case| (case.truth().is_some() && sigma(case) >= 10.0).then(|| case.separable()),
    },
];

/// A column of the table of shares.
type Column = (String, Box<dyn Fn(&Case) -> bool>);

fn columns() -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for (name, kind) in [("readings", Kind::Readings), ("maps", Kind::Maps)] {
        columns.push((name.to_owned(), Box::new(move |case: &Case| case.order.kind == kind)));
        if kind == Kind::Readings {
            for grid in Grid::ALL {
                let of = move |case: &Case| case.order.kind == kind && case.order.grid == grid;
                columns.push((format!("{name}, {}", grid.name()), Box::new(of)));
            }
        }
        for lamp in Lamp::ALL {
            let of = move |case: &Case| case.order.kind == kind && case.order.lamp == lamp;
            columns.push((format!("{name}, {}", lamp.name()), Box::new(of)));
        }
    }
    columns
}

/// The whole report of played cases.
pub fn report(played: &[(Order, Result<Outcome, DayError>)]) -> String {
    let cases: Vec<&Case> = played
        .iter()
        .filter_map(|(_, outcome)| match outcome {
            Ok(Outcome::Answered(case)) => Some(case.as_ref()),
            _ => None,
        })
        .collect();
    [
        confusion(&cases, Kind::Readings),
        confusion(&cases, Kind::Maps),
        shares(&cases),
        others(played),
    ]
    .join("\n")
}

fn shares(cases: &[&Case]) -> String {
    let mut columns = columns();
    columns.retain(|(_, of)| cases.iter().any(|case| of(case)));
    let heads: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let mut text = format!(
        "| share | wanted | {} |\n|---|---|{}\n",
        heads.join(" | "),
        "---|".repeat(heads.len())
    );
    for requested in &SHARES {
        let _ = write!(text, "| {} | {} |", requested.what, requested.wanted);
        for (_, of) in &columns {
            let judged: Vec<bool> = cases
                .iter()
                .filter(|case| of(case))
                .filter_map(|case| (requested.of)(case))
                .collect();
            let hits = judged.iter().filter(|hit| **hit).count();
            let _ = match judged.len() {
                0 => write!(text, " |"),
                n => write!(text, " {:.1} % ({hits}/{n}) |", 100.0 * hits as f64 / n as f64),
            };
        }
        text.push('\n');
    }
    for (what, of) in [
        (
            "30 σ: gap gone where nobody looked, median",
            (|case| case.removed.filter(|_| sigma(case) == 30.0)) as fn(&Case) -> Option<f64>,
        ),
        ("time of diagnosis, median, s", |case| Some(case.seconds)),
    ] {
        let _ = write!(text, "| {what} | |");
        for (_, within) in &columns {
            let mut values: Vec<f64> = cases
                .iter()
                .filter(|case| within(case))
                .filter_map(|case| of(case))
                .collect();
            values.sort_by(f64::total_cmp);
            let _ = match values.get(values.len() / 2) {
                Some(median) => write!(text, " {median:.3} |"),
                None => write!(text, " |"),
            };
        }
        text.push('\n');
    }
    let _ = write!(text, "| time of diagnosis, worst, s | |");
    for (_, within) in &columns {
        let worst = cases
            .iter()
            .filter(|case| within(case))
            .map(|case| case.seconds)
            .fold(0.0, f64::max);
        let _ = write!(text, " {worst:.3} |");
    }
    text.push('\n');
    text
}

/// Fault by fault what was said, at each strength: a name alone, a name with the size of its set (∋ where the truth
/// is in it), or a verdict.
fn confusion(cases: &[&Case], kind: Kind) -> String {
    let mut stated: BTreeMap<&str, [BTreeMap<String, usize>; SIGMAS.len()]> = BTreeMap::new();
    let mut faultless: BTreeMap<String, usize> = BTreeMap::new();
    for case in cases.iter().filter(|case| case.order.kind == kind) {
        let words = words(case);
        match case.order.fault {
            None => *faultless.entry(words).or_default() += 1,
            Some((fault, sigma)) => {
                let step = SIGMAS.iter().position(|of| *of == sigma).unwrap_or(0);
                *stated.entry(fault.label).or_default()[step].entry(words).or_default() += 1;
            }
        }
    }
    if stated.is_empty() && faultless.is_empty() {
        return String::new();
    }
    let cell = |counts: &BTreeMap<String, usize>| {
        let mut counts: Vec<(&String, &usize)> = counts.iter().collect();
        counts.sort_by(|a, b| b.1.cmp(a.1));
        let words: Vec<String> = counts.iter().map(|(words, n)| format!("{words} {n}")).collect();
        words.join(", ")
    };
    let mut text = format!("{kind:?}\n\n| fault | 3 σ | 10 σ | 30 σ |\n|---|---|---|---|\n");
    for (label, steps) in &stated {
        let cells: Vec<String> = steps.iter().map(cell).collect();
        let _ = writeln!(text, "| {label} | {} |", cells.join(" | "));
    }
    if !faultless.is_empty() {
        let _ = writeln!(text, "\nno fault: {}", cell(&faultless));
    }
    text
}

fn words(case: &Case) -> String {
    let Some((name, others, _)) = case.stated.effects.first() else {
        return case.stated.verdict.clone();
    };
    let mark = match case.truth() {
        Some(truth) if name == truth => "✓",
        Some(truth) if holds(case, truth) => "∋",
        _ => "",
    };
    let rest = case.stated.effects.len() - 1;
    let further = if rest > 0 {
        format!(" and {rest} more")
    } else {
        String::new()
    };
    let set = if others.is_empty() {
        String::new()
    } else {
        format!(" of {}", 1 + others.len())
    };
    let beside = if case.stated.verdict == "unexplained" {
        "unexplained beside "
    } else {
        ""
    };
    format!("{beside}{name}{mark}{set}{further}")
}

/// What gave no answer: too weak, stopped by the scan, failed.
fn others(played: &[(Order, Result<Outcome, DayError>)]) -> String {
    let mut weak: BTreeMap<String, usize> = BTreeMap::new();
    let mut stopped: BTreeMap<String, usize> = BTreeMap::new();
    let mut text = String::new();
    for (order, outcome) in played {
        let what = order.fault.map_or_else(
            || "no fault".to_owned(),
            |(fault, sigma)| format!("{:?} {} {sigma} σ", order.kind, fault.label),
        );
        match outcome {
            Ok(Outcome::Answered(_)) => {}
            Ok(Outcome::TooWeak) => *weak.entry(what).or_default() += 1,
            Ok(Outcome::Stopped(why)) => *stopped.entry(format!("{what}: {why}")).or_default() += 1,
            Err(error) => {
                let _ = writeln!(text, "FAILED {what}, {order:?}: {error}");
            }
        }
    }
    for (title, counts) in [
        ("beyond the plausible range on every lamp", weak),
        ("the second scan ended early", stopped),
    ] {
        let all: usize = counts.values().sum();
        let list: Vec<String> = counts.iter().map(|(what, n)| format!("{what} {n}")).collect();
        let _ = writeln!(
            text,
            "{title}: {all} cases{}{}",
            if all > 0 { ": " } else { "" },
            list.join(", ")
        );
    }
    text
}
