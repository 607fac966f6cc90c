//! The answer of a diagnosis in lines for a person.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::diagnosis::{along_words, digits};
use isolux_diagnose::document::{
    Document, EffectEntry, GapEntry, Independence, NoiseEntry, ParameterEntry, RankedEntry,
};
use isolux_model::effects;
use isolux_units::digits::stated;

/// What was found, and where it was written.
#[derive(Debug)]
pub struct DiagnosisResult {
    /// As in `diagnosis.json`.
    pub document: Document,
    /// Lines that the model after has and the model as given has not (`+`), and the other way round (`-`).
    pub diff: Vec<String>,
    /// The adopted model, with `--accept`.
    pub accepted: Option<Utf8PathBuf>,
    /// Commands that take effects of the bench out of the run, where there is a run.
    pub reduce_with: Option<String>,
}

/// What a diagnosis of a model against its own readings is worth.
pub const SAME_RECORD: &str = "the model was made from these readings, so this checks the record against itself: \
    what disagrees is a fault of the record or of its reduction, what agrees is no evidence for the model; \
    a test needs readings that the model was not made from";

/// How many of the simulated noise-only scans disagree as much as these readings; none where that would be no evidence.
pub fn reached_by_chance(noise: &NoiseEntry) -> Option<usize> {
    let scans = (noise.p_global? * (noise.n_null + 1) as f64).round() as usize;
    Some(scans.saturating_sub(1))
}

/// An effect as standards call it; the name of a pattern without one says along what it runs.
pub fn effect_words(name: &str) -> String {
    match name.strip_prefix("unnamed:") {
        Some(coordinate) => format!("no name, along {}", along_words(coordinate)),
        None => effects::by_name(name).map_or_else(|| key_words(name), |spec| spec.standard_name.to_owned()),
    }
}

/// A key of the model file in words; its unit stands beside its value.
pub fn key_words(key: &str) -> String {
    const UNITS: [&str; 14] = [
        "_lm_per_w",
        "_per_k",
        "_rel",
        "_deg",
        "_mm",
        "_lx",
        "_nm",
        "_px",
        "_hz",
        "_cd",
        "_s",
        "_c",
        "_k",
        "_v",
    ];
    let stem = UNITS.iter().find_map(|unit| key.strip_suffix(unit)).unwrap_or(key);
    stem.replace('_', " ")
}

/// `value ± U unit (k = 2)` of a parameter.
pub fn with_uncertainty(parameter: &ParameterEntry) -> String {
    let unit = if parameter.unit == "1" {
        ""
    } else {
        parameter.unit.as_ref()
    };
    if !(parameter.u.is_finite() && parameter.u > 0.0) {
        return format!("{} {unit}", digits(parameter.value, 6)).trim_end().to_owned();
    }
    stated(parameter.value, parameter.u, unit).replace("  (", " (")
}

/// The answer in lines for a person, in the order: disagreement, place, ranking, verdict, gap, next, blind spots, diff.
pub fn words(answer: &DiagnosisResult) -> Vec<String> {
    let document = &answer.document;
    let mut lines = vec![format!("found         {}", document.plain)];
    if document.independence == Independence::SameRun {
        lines.push(format!("consistency   {SAME_RECORD}"));
    }
    lines.extend(disagreement(document));
    for (effect, ranked) in document.effects.iter().zip(&document.ranked) {
        lines.extend(effect_found(effect));
        lines.extend(ranked.iter().map(alternative));
    }
    lines.push(format!("verdict       {}", document.sentence));
    lines.extend(gap(&document.gap));
    for next in &document.next_measurement {
        let plan = next.plan.as_deref().unwrap_or("no plan file");
        lines.push(format!(
            "next          {} ({plan}): {} and {} would lie {:.1} σ apart, {:.0} min",
            next.what, next.splits[0], next.splits[1], next.expected_sigma, next.minutes
        ));
    }
    let blind = document.blind_spots.iter().filter(|spot| spot.blind);
    let blind: Vec<&str> = blind.map(|spot| spot.effect.as_ref()).collect();
    if !blind.is_empty() {
        lines.push(format!(
            "blind spots   these data cannot show a plausible amount of: {}",
            blind.join(", ")
        ));
    }
    lines.extend(document.notes.iter().map(|note| format!("note          {note}")));
    lines.extend(answer.diff.iter().map(|line| format!("model         {line}")));
    let commands = answer.reduce_with.iter();
    lines.extend(commands.map(|command| format!("reduce        {command}")));
    lines.extend(answer.accepted.iter().map(|path| format!("accepted      {path}")));
    lines
}

/// How large the disagreement is, what of it is no noise, and where it lies.
fn disagreement(document: &Document) -> Vec<String> {
    let (noise, gap) = (&document.noise, &document.gap);
    let chance = reached_by_chance(noise).map_or_else(String::new, |k| {
        format!("; {k} of {} simulated scans disagree as much", noise.n_null)
    });
    let mut lines = vec![format!(
        "disagreement  gap {:.3} σ rms as given, {:.3} within what the model knows of itself, {:.3} expected; noise {:.3} × stated, \
         autocorrelation {:.2}{chance}",
        gap.as_given, gap.before, gap.floor, noise.scale, noise.autocorrelation
    )];
    if let Some(test) = noise.test.as_ref().filter(|test| !test.findings.is_empty()) {
        let period = test.spectrum.first().map_or_else(String::new, |peak| {
            let unit = if peak.coordinate == "index" { "readings" } else { "s" };
            format!("; strongest period {} {unit}", digits(peak.period, 3))
        });
        lines.push(format!(
            "noise         what is left is no noise (p = {:.2e}): it scatters {:.2} × stated, and up to {:.2} would count as noise{period}",
            test.p_value, test.scatter, test.scatter_limit
        ));
    }
    lines.extend(document.places.iter().take(3).map(|place| {
        format!(
            "where         {} {} … {}: {} ({:.1} σ)",
            place.coordinate,
            digits(place.range[0], 4),
            digits(place.range[1], 4),
            place.note,
            place.significance_sigma
        )
    }));
    lines
}

/// An effect and its parameters.
fn effect_found(effect: &EffectEntry) -> Vec<String> {
    let mut lines = vec![format!("effect        {} ({})", effect.name, effect.standard_name)];
    lines.extend(effect.parameters.iter().map(|(key, parameter)| {
        let before = parameter
            .before
            .map_or_else(String::new, |before| format!("; {} in the model", digits(before, 4)));
        let flag = if parameter.implausible {
            "  outside the plausible range"
        } else {
            ""
        };
        format!(
            "              {key} = {}  (plausible {} … {}{before}){flag}",
            with_uncertainty(parameter),
            parameter.plausible[0],
            parameter.plausible[1]
        )
    }));
    lines
}

/// What else could explain the readings, and how likely it is.
fn alternative(row: &RankedEntry) -> String {
    let name = match row.name.strip_prefix("unnamed:") {
        Some(coordinate) => format!("no name, along {coordinate}"),
        None => row.name.clone(),
    };
    format!(
        "              {:>6.1} %  {:>5.1} σ  {name}",
        100.0 * row.posterior,
        row.significance_sigma
    )
}

/// What the effects removed of the gap.
fn gap(gap: &GapEntry) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(removed) = gap.removed {
        lines.push(format!(
            "gap           {:.3} → {:.3}, noise floor {:.3}: {:.1} % removed on fitted readings",
            gap.before,
            gap.after,
            gap.floor,
            100.0 * removed
        ));
    }
    match &gap.held_out {
        Some(held) => lines.push(format!(
            "held out      {:.3} → {:.3}, noise floor {:.3}: {:.1} % removed on {} readings ({})",
            held.before,
            held.after,
            held.floor,
            100.0 * held.removed,
            held.readings,
            gap.held_out_note
        )),
        None if gap.removed.is_some() => lines.push(format!("held out      {}", gap.held_out_note)),
        None => {}
    }
    lines
}

/// Lines of a terminal.
const BRIEF: usize = 10;

/// The answer in at most ten lines: what was found, its numbers, what to do next; the rest is in the report.
pub fn brief(answer: &DiagnosisResult, out: &Utf8Path) -> Vec<String> {
    let all = words(answer);
    let starts = |line: &&String, words: &[&str]| words.iter().any(|word| line.starts_with(word));
    let commands = ["reduce ", "accepted "];
    let mut tail: Vec<String> = all.iter().filter(|line| starts(line, &commands)).cloned().collect();
    tail.push(format!("more          {out}/report.html"));
    // Parameters stand below their effect; ranked alternatives, places, notes and the change of the model file are in
    // the report.
    let wanted = [
        "found ",
        "consistency ",
        "verdict ",
        "effect ",
        "held out ",
        "next ",
        "blind ",
    ];
    let parameter = |line: &&String| line.starts_with(' ') && line.contains(" = ");
    let mut lines: Vec<String> = all
        .iter()
        .filter(|line| starts(line, &wanted) || parameter(line))
        .cloned()
        .collect();
    lines.truncate(BRIEF - tail.len());
    lines.extend(tail);
    lines
}

/// The lines of [`words`] that are of the record and the search: neither the verdict nor the change of the model file.
pub fn statistics(answer: &DiagnosisResult) -> Vec<String> {
    let mut lines = words(answer);
    lines.retain(|line| {
        !["found ", "consistency ", "model "]
            .iter()
            .any(|word| line.starts_with(word))
    });
    lines
}
