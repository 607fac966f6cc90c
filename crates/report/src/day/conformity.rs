//! What is judged: conditions against their limits, results against requirements, the report against what it has to
//! state.

use isolux_conformity::{Decision, JudgedCondition, Outcome, Standing};
use isolux_units::digits::{place_of, shortest, significant};

use super::results::DayResults;
use crate::document::{Block, Section};

/// The requirements of the job; none where it has none.
pub fn requirements(day_results: &DayResults) -> Option<Section> {
    let conformity = &day_results.conformity;
    let sentence = conformity.sentence()?;
    let [_, fail, not_decided] = conformity.counts();
    let mut section = Section::new("Conformity");
    section.add(Block::Verdict(format!("{sentence}."), fail + not_decided == 0));
    let rows = conformity.requirements.iter().map(|one| {
        vec![
            one.what.clone(),
            one.measured
                .as_ref()
                .map_or_else(|| "not measured".to_owned(), isolux_reduce::Quantity::stated),
            limits(one.smallest, one.largest, unit(one)),
            one.source.clone().unwrap_or_else(|| "–".to_owned()),
            one.rule.name().to_owned(),
            one.outcome.words().to_owned(),
            one.probability_false.map_or_else(|| "–".to_owned(), probability),
        ]
    });
    section.table(
        &[
            "quantity",
            "measured",
            "limits",
            "source",
            "rule",
            "decision",
            "false with probability",
        ],
        rows.collect(),
    );
    let why = conformity
        .requirements
        .iter()
        .filter(|one| one.outcome == Outcome::NotDecided);
    let why: Vec<String> = why
        .filter_map(|one| Some(format!("{}: {}", one.what, one.reason.as_ref()?)))
        .collect();
    if !why.is_empty() {
        section.paragraph(format!("Not decided: {}.", why.join(". ")));
    }
    section.paragraph(
        "Rules (ISO/IEC 17025, 7.8.6; ILAC-G8:09/2019): simple acceptance compares the value itself; guarded by U passes a value that keeps \
         the limit by U, fails one that misses it by U and decides nothing between; shared risk compares the value itself where U is not above \
         what was agreed. The probability is that of a true value on the other side of the limit, for a normal distribution about the value.",
    );
    Some(section)
}

/// The conditions against their limits.
pub fn conditions(section: &mut Section, day_results: &DayResults) {
    let conformity = &day_results.conformity;
    if conformity.conditions.is_empty() {
        return;
    }
    section.subheading("Conditions against their limits");
    let rows = conformity.conditions.iter().map(|one| {
        vec![
            one.what.clone(),
            measured(one),
            limits(one.smallest, one.largest, &one.unit),
            one.clause.clone().unwrap_or_else(|| "–".to_owned()),
            match (&one.reason, one.standing) {
                (Some(reason), standing) if standing != Standing::Met => format!("{}: {reason}", standing.words()),
                (_, standing) => standing.words().to_owned(),
            },
        ]
    });
    section.table(
        &["condition", "measured", "limits", "clause", "judgement"],
        rows.collect(),
    );
    let of = conformity.standard.as_ref().map_or_else(
        || "The job names no standard for the limits.".to_owned(),
        |standard| format!("The job takes the limits from {standard}."),
    );
    section.paragraph(format!(
        "{of} A condition is met where the whole range that was measured keeps the limits by its expanded uncertainty U (k = 2); a \
         tolerance interval is of the true value."
    ));
}

/// What the report has to state, and what is missing.
pub fn checklist(day_results: &DayResults) -> Section {
    let mut section = Section::new("What this report has to state");
    let items = &day_results.conformity.checklist;
    let missing = items.iter().filter(|item| item.stated.is_none()).count();
    section.paragraph(format!(
        "{} of {} items are stated.",
        items.len() - missing,
        items.len()
    ));
    let rows = items.iter().map(|item| {
        let stated = item.stated.clone();
        let missing = || format!("missing: {}", item.remedy.as_deref().unwrap_or_default());
        vec![item.what.clone(), item.asked_by.clone(), stated.unwrap_or_else(missing)]
    });
    section.table(&["item", "asked by", "stated"], rows.collect());
    section
}

fn unit(one: &Decision) -> &str {
    one.measured.as_ref().map_or("", |found| found.unit.as_ref())
}

/// The range that was measured, to the digits that its uncertainty leaves.
fn measured(one: &JudgedCondition) -> String {
    let Some([least, most]) = one.measured else {
        return "–".to_owned();
    };
    let unit = if one.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", one.unit)
    };
    let expanded = one.expanded.filter(|expanded| *expanded > 0.0);
    let number = |value: f64| match expanded.and_then(place_of) {
        Some(place) => format!("{value:.*}", usize::try_from(-place).unwrap_or(0)),
        None => significant(value, 4),
    };
    let range = if number(least) == number(most) {
        number(least)
    } else {
        format!("{} to {}", number(least), number(most))
    };
    match expanded {
        Some(expanded) => format!("{range}{unit}, U {}{unit}", number(expanded)),
        None => format!("{range}{unit}"),
    }
}

fn limits(smallest: Option<f64>, largest: Option<f64>, unit: &str) -> String {
    let number = |value: f64| shortest(value, 6);
    let words = match (smallest, largest) {
        (Some(smallest), Some(largest)) => format!("{} to {}", number(smallest), number(largest)),
        (Some(smallest), None) => format!("at least {}", number(smallest)),
        (None, Some(largest)) => format!("at most {}", number(largest)),
        (None, None) => return "–".to_owned(),
    };
    format!("{words} {unit}").trim_end().to_owned()
}

/// In per cent; one that is too small to say, as below it.
fn probability(of: f64) -> String {
    if of < 1e-4 {
        "below 0.01 %".to_owned()
    } else {
        format!("{} %", significant(100.0 * of, 2))
    }
}
