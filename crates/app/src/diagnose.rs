//! `isolux diagnose`: where a model and observations disagree, which effect is missing, and the model that has it.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::diagnosis::{self, DiagnoseError, Diagnosis, digits};
pub use isolux_diagnose::document::Independence;
pub use isolux_diagnose::document::Verdict;
use isolux_diagnose::document::{Document, NoiseEntry, ParameterEntry};
use isolux_diagnose::search::Settings;
use isolux_model::Model;
use isolux_record::observation::{Need, Observations, open};
use isolux_units::digits::stated;
use sha2::{Digest as _, Sha256};

use crate::Failure;
use crate::diagnosis_report::report;
use crate::files::{self, Overwrite};
use crate::overlap::{self, Given};
use crate::own_readings;
use crate::progress::{Event, Progress};

/// What is asked.
#[derive(Debug, Clone)]
pub struct Request {
    /// The model file.
    pub model: Utf8PathBuf,
    /// Run directories, readings CSVs, `maps.toml`s, `spectra.toml`s.
    pub observations: Vec<Utf8PathBuf>,
    /// The folder to write.
    pub out: Utf8PathBuf,
    /// Observations that are predicted and never fitted.
    pub held_out: Option<Utf8PathBuf>,
    /// Seed of the simulated scans.
    pub seed: u64,
    /// Write the model with the effects beside the model, as its next version.
    pub accept: bool,
    /// Whether files may be replaced.
    pub overwrite: Overwrite,
}

/// What was found, and where it was written.
#[derive(Debug)]
pub struct Answer {
    /// As in `diagnosis.json`.
    pub document: Document,
    /// Lines that the model after has and the model as given has not (`+`), and the other way round (`-`).
    pub diff: Vec<String>,
    /// The adopted model, with `--accept`.
    pub accepted: Option<Utf8PathBuf>,
    /// Commands that take effects of the bench out of the run, where there is a run.
    pub reduce_with: Option<String>,
}

/// Diagnoses and writes `diagnosis.json`, `report.html`, both models with the files that they name, and plans.
///
/// # Errors
/// Bad input (exit 2) with file and line; nothing is written then.
pub fn run(request: &Request, progress: &dyn Progress) -> Result<Answer, Failure> {
    attempt(request, progress)?.map_err(Failure::bad_input)
}

/// As [`run`]; the inner error says that too few readings are left without those that made the model's distribution.
///
/// # Errors
/// As [`run`].
pub(crate) fn attempt(request: &Request, progress: &dyn Progress) -> Result<Result<Answer, String>, Failure> {
    let model = Model::load(&request.model).map_err(Failure::bad_input)?;
    let (observations, sha256, held_out, left_out) = observed(request, &model)?;
    let accepted = request.accept.then(|| next_version(&request.model));
    if let Some(path) = &accepted {
        files::refuse_existing(path, request.overwrite)?;
    }
    files::refuse_occupied(&request.out, request.overwrite)?;
    let same_record = diagnosis::independence(&model, &sha256) == Independence::SameRun;
    progress.event(Event::Began {
        step: if same_record { "self-check" } else { "diagnose" },
        total: None,
    });
    let settings = Settings {
        seed: request.seed,
        ..Settings::default()
    };
    let mut found = match diagnosis::diagnose(&model, &observations, held_out.as_ref(), &sha256, &settings) {
        Err(DiagnoseError::Nothing | DiagnoseError::TooFew { .. } | DiagnoseError::Dark)
            if same_record && !left_out.is_empty() =>
        {
            let none = format!(
                "{}; what is left is too little to check the model with",
                left_out.join("; ")
            );
            progress.event(Event::Ended(&none));
            return Ok(Err(none));
        }
        found => found.map_err(|error| Failure::bad_input(format!("{}: {error}", names(&request.observations))))?,
    };
    found.document.notes.extend(left_out);
    progress.event(Event::Ended(&found.document.sentence));
    let out = files::output_folder(&request.out, request.overwrite)?;
    let diff = diff(
        &model.beside_its_files().to_toml(),
        &found.after.beside_its_files().to_toml(),
    );
    write(request, &out, &model, &found, &diff)?;
    if let Some(path) = &accepted {
        files::write(path, found.after.to_toml().as_bytes(), request.overwrite)?;
    }
    let reduce_with = run_directory(&request.observations, &observations)
        .filter(|_| !found.of_bench.is_empty())
        .map(|run| format!("isolux reduce {run} --with {}", out.join("model.after.toml")));
    Ok(Ok(Answer {
        diff,
        document: found.document,
        accepted,
        reduce_with,
    }))
}

/// Refuses a model or observations that no diagnosis could use, without diagnosing.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub(crate) fn check(request: &Request) -> Result<(), Failure> {
    let model = Model::load(&request.model).map_err(Failure::bad_input)?;
    observed(request, &model).map(|_| ())
}

/// Sets that are fitted, the fingerprint of their data, the set that is predicted, and notes.
type Observed = (Vec<Observations>, String, Option<Observations>, Vec<String>);

/// The observations of a request, no reading twice among them and none that made the distribution of `model`.
fn observed(request: &Request, model: &Model) -> Result<Observed, Failure> {
    let paths: Vec<&Utf8PathBuf> = request.observations.iter().chain(&request.held_out).collect();
    let sha256 = paths
        .iter()
        .map(|path| fingerprint(path))
        .collect::<Result<Vec<_>, _>>()?;
    let mut given: Vec<Given<'_>> = Vec::new();
    let mut notes = Vec::new();
    for (k, (path, sha256)) in paths.iter().zip(&sha256).enumerate() {
        let set = open(path, Need::Values).map_err(Failure::bad_input)?;
        if let Observations::Readings(readings) = &set {
            notes.extend_from_slice(readings.notices());
        }
        let mut later = Given { path, sha256, set };
        let role = if k < request.observations.len() {
            "to be fitted"
        } else {
            "as --held-out"
        };
        for earlier in &given {
            notes.extend(overlap::beyond(&mut later, earlier, role)?);
        }
        given.push(later);
    }
    for given in &mut given {
        notes.extend(own_readings::leave_out(model, given));
    }
    if let Some(held) = given.last().filter(|_| request.held_out.is_some())
        && matches!(&held.set, Observations::Readings(readings) if readings.rows().is_empty())
    {
        let message = format!(
            "{}, given as --held-out, made the model's distribution and holds no other readings",
            held.path
        );
        return Err(Failure::bad_input(message));
    }
    let held_out = request.held_out.is_some().then(|| given.pop()).flatten();
    let fitted = sha256[..request.observations.len()].join("+");
    let sets = given.into_iter().map(|given| given.set).collect();
    Ok((sets, fitted, held_out.map(|given| given.set), notes))
}

/// What a diagnosis of a model against its own readings is worth.
pub(crate) const SAME_RECORD: &str = "the model was made from these readings, so this checks the record against itself: \
    what disagrees is a fault of the record or of its reduction, what agrees is no evidence for the model; \
    a test needs readings that the model was not made from";

/// How many of the simulated noise-only scans disagree as much as these readings; none where that would be no evidence.
pub(crate) fn reached_by_chance(noise: &NoiseEntry) -> Option<usize> {
    let scans = (noise.p_global? * (noise.n_null + 1) as f64).round() as usize;
    Some(scans.saturating_sub(1))
}

/// `value ± U unit (k = 2)` of a parameter.
pub(crate) fn with_uncertainty(parameter: &ParameterEntry) -> String {
    let unit = if parameter.unit == "1" { "" } else { parameter.unit };
    if !(parameter.u.is_finite() && parameter.u > 0.0) {
        return format!("{} {unit}", digits(parameter.value, 6)).trim_end().to_owned();
    }
    stated(parameter.value, parameter.u, unit).replace("  (", " (")
}

/// The answer in lines for a person, in the order: disagreement, place, ranking, verdict, gap, next, blind spots, diff.
pub fn words(answer: &Answer) -> Vec<String> {
    let document = &answer.document;
    let (noise, gap) = (&document.noise, &document.gap);
    let mut lines = vec![format!("found         {}", document.plain)];
    if document.independence == Independence::SameRun {
        lines.push(format!("consistency   {SAME_RECORD}"));
    }
    let chance = reached_by_chance(noise).map_or_else(String::new, |k| {
        format!("; {k} of {} simulated scans disagree as much", noise.n_null)
    });
    lines.push(format!(
        "disagreement  gap {:.3} σ rms as given, {:.3} with nuisance refitted, {:.3} expected; noise {:.3} × stated, \
         autocorrelation {:.2}{chance}",
        gap.as_given, gap.before, gap.floor, noise.scale, noise.autocorrelation
    ));
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
    for place in document.places.iter().take(3) {
        lines.push(format!(
            "where         {} {} … {}: {} ({:.1} σ)",
            place.coordinate,
            digits(place.range[0], 4),
            digits(place.range[1], 4),
            place.note,
            place.significance_sigma
        ));
    }
    for (effect, ranked) in document.effects.iter().zip(&document.ranked) {
        lines.push(format!("effect        {} ({})", effect.name, effect.standard_name));
        for (key, parameter) in &effect.parameters {
            let before = parameter
                .before
                .map_or_else(String::new, |before| format!("; {} in the model", digits(before, 4)));
            let flag = if parameter.implausible {
                "  outside the plausible range"
            } else {
                ""
            };
            lines.push(format!(
                "              {key} = {}  (plausible {} … {}{before}){flag}",
                with_uncertainty(parameter),
                parameter.plausible[0],
                parameter.plausible[1]
            ));
        }
        for row in ranked {
            let name = match row.name.strip_prefix("unnamed:") {
                Some(coordinate) => format!("no name, along {coordinate}"),
                None => row.name.clone(),
            };
            lines.push(format!(
                "              {:>6.1} %  {:>5.1} σ  {name}",
                100.0 * row.posterior,
                row.significance_sigma
            ));
        }
    }
    lines.push(format!("verdict       {}", document.sentence));
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
    for next in &document.next_measurement {
        let plan = next.plan.as_deref().unwrap_or("no plan file");
        lines.push(format!(
            "next          {} ({plan}): {} and {} would lie {:.1} σ apart, {:.0} min",
            next.what, next.splits[0], next.splits[1], next.expected_sigma, next.minutes
        ));
    }
    let blind: Vec<&str> = document
        .blind_spots
        .iter()
        .filter(|spot| spot.blind)
        .map(|spot| spot.effect)
        .collect();
    if !blind.is_empty() {
        lines.push(format!(
            "blind spots   these data cannot show a plausible amount of: {}",
            blind.join(", ")
        ));
    }
    lines.extend(document.notes.iter().map(|note| format!("note          {note}")));
    lines.extend(answer.diff.iter().map(|line| format!("model         {line}")));
    lines.extend(
        answer
            .reduce_with
            .iter()
            .map(|command| format!("reduce        {command}")),
    );
    lines.extend(answer.accepted.iter().map(|path| format!("accepted      {path}")));
    lines
}

/// Lines of a terminal.
const BRIEF: usize = 10;

/// The answer in at most ten lines: what was found, its numbers, what to do next; the rest is in the report.
pub fn brief(answer: &Answer, out: &Utf8Path) -> Vec<String> {
    let all = words(answer);
    let starts = |line: &&String, words: &[&str]| words.iter().any(|word| line.starts_with(word));
    let commands = ["reduce ", "accepted "];
    let mut tail: Vec<String> = all.iter().filter(|line| starts(line, &commands)).cloned().collect();
    tail.push(format!("more          {out}/report.html"));
    // Parameters stand below their effect; ranked rivals, places, notes and the change of the model file are in the
    // report.
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
pub fn statistics(answer: &Answer) -> Vec<String> {
    let mut lines = words(answer);
    lines.retain(|line| {
        !["found ", "consistency ", "model "]
            .iter()
            .any(|word| line.starts_with(word))
    });
    lines
}

fn names(paths: &[Utf8PathBuf]) -> String {
    paths.iter().map(|path| path.as_str()).collect::<Vec<_>>().join(", ")
}

fn run_directory(paths: &[Utf8PathBuf], observations: &[Observations]) -> Option<Utf8PathBuf> {
    paths
        .iter()
        .zip(observations)
        .find(|(path, set)| path.is_dir() && matches!(set, Observations::Readings(_)))
        .map(|(path, _)| path.clone())
}

/// SHA-256 of the data of one observation: the file itself and the table beside it.
fn fingerprint(path: &Utf8Path) -> Result<String, Failure> {
    let file = if path.is_dir() {
        path.join("readings.csv")
    } else {
        path.to_owned()
    };
    let mut hash = Sha256::new();
    hash.update(files::read(&file)?);
    let table = file.with_extension("csv");
    if table != file && table.exists() {
        hash.update(files::read(&table)?);
    }
    Ok(hash.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = std::fmt::Write::write_fmt(&mut text, format_args!("{byte:02x}"));
        text
    }))
}

/// `ring.model.toml` → `ring.model.v2.toml`; `ring.v2.toml` → `ring.v3.toml`.
fn next_version(path: &Utf8Path) -> Utf8PathBuf {
    let extension = path.extension().unwrap_or("toml");
    let stem = path.file_stem().unwrap_or("model");
    let (base, version) = match stem.rsplit_once(".v") {
        Some((base, number)) => number.parse::<u32>().map_or((stem, 2), |number| (base, number + 1)),
        None => (stem, 2),
    };
    path.with_file_name(format!("{base}.v{version}.{extension}"))
}

fn write(request: &Request, out: &Utf8Path, model: &Model, found: &Diagnosis, diff: &[String]) -> Result<(), Failure> {
    for (name, from) in model.files() {
        let name = Utf8Path::new(&name).file_name().unwrap_or("distribution").to_owned();
        let target = out.join(name);
        // A model that lies in the output folder already has its files beside it.
        if target != from {
            files::write(&target, &files::read(&from)?, request.overwrite)?;
        }
    }
    let write = |name: &str, bytes: &[u8]| files::write(&out.join(name), bytes, request.overwrite);
    write(
        "model.baseline.toml",
        found.baseline.beside_its_files().to_toml().as_bytes(),
    )?;
    write("model.after.toml", found.after.beside_its_files().to_toml().as_bytes())?;
    for (name, plan) in &found.plans {
        write(name, plan.as_bytes())?;
    }
    let report = report(found, diff);
    for (name, svg) in &report.pictures {
        write(name, svg.as_bytes())?;
    }
    write("report.html", report.page.as_bytes())?;
    let mut json = serde_json::to_vec_pretty(&found.document).map_err(Failure::instrument)?;
    json.push(b'\n');
    write("diagnosis.json", &json)
}

/// The lines that differ, in order; both texts come from the same writer, so a longest common subsequence is short
/// work.
fn diff(old: &str, new: &str) -> Vec<String> {
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    let mut common = vec![vec![0_usize; new.len() + 1]; old.len() + 1];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            common[i][j] = if old[i] == new[j] {
                common[i + 1][j + 1] + 1
            } else {
                common[i + 1][j].max(common[i][j + 1])
            };
        }
    }
    let (mut i, mut j, mut lines) = (0, 0, Vec::new());
    while i < old.len() || j < new.len() {
        if i < old.len() && j < new.len() && old[i] == new[j] {
            i += 1;
            j += 1;
        } else if j < new.len() && (i == old.len() || common[i][j + 1] >= common[i + 1][j]) {
            lines.push(format!("+ {}", new[j]));
            j += 1;
        } else {
            lines.push(format!("- {}", old[i]));
            i += 1;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_count_up() {
        assert_eq!(next_version("a/ring.model.toml".into()), "a/ring.model.v2.toml");
        assert_eq!(next_version("ring.v2.toml".into()), "ring.v3.toml");
        assert_eq!(next_version("ring.velvet.toml".into()), "ring.velvet.v2.toml");
    }

    #[test]
    fn the_diff_shows_what_was_added() {
        assert_eq!(diff("a\nb\nc", "a\nc\nd"), ["- b", "+ d"]);
    }
}
