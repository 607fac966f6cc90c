//! `isolux diagnose`: where a model and observations disagree, which effect is missing, and the model that has it.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::diagnosis::{self, DiagnoseError, Diagnosis};
pub use isolux_diagnose::document::Independence;
pub use isolux_diagnose::document::Verdict;
use isolux_diagnose::overlap::{self, Given};
use isolux_diagnose::search::Settings;
use isolux_diagnose::{heads, own_readings};
use isolux_model::Model;
use isolux_record::observation::{Need, Observations, open};
pub use isolux_report::answer::{DiagnosisResult, brief, words};
use isolux_report::diagnosis_page::report;
use sha2::{Digest as _, Sha256};
use similar::{ChangeTag, TextDiff};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};

/// What is asked.
#[derive(Debug, Clone)]
pub struct DiagnoseRequest {
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

/// Diagnoses and writes `diagnosis.json`, `report.html`, both models with the files that they name, and plans.
///
/// # Errors
/// Bad input (exit 2) with file and line; nothing is written then.
pub fn run(request: &DiagnoseRequest, progress: &dyn Progress) -> Result<DiagnosisResult, Failure> {
    attempt(request, progress)?.map_err(Failure::bad_input)
}

/// As [`run`]; the inner error says that too few readings are left without those that made the model's distribution.
///
/// # Errors
/// As [`run`].
pub(crate) fn attempt(
    request: &DiagnoseRequest,
    progress: &dyn Progress,
) -> Result<Result<DiagnosisResult, String>, Failure> {
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
    Ok(Ok(DiagnosisResult {
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
pub(crate) fn check(request: &DiagnoseRequest) -> Result<(), Failure> {
    let model = Model::load(&request.model).map_err(Failure::bad_input)?;
    observed(request, &model).map(|_| ())
}

/// Sets that are fitted, the fingerprint of their data, the set that is predicted, and notes.
type Observed = (Vec<Observations>, String, Option<Observations>, Vec<String>);

/// The observations of a request, no reading twice among them and none that made the distribution of `model`.
fn observed(request: &DiagnoseRequest, model: &Model) -> Result<Observed, Failure> {
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
            let left_out = overlap::beyond(&mut later, earlier, role).map_err(|error| {
                Failure::bad_input(error).help(
                    "give readings that were taken by themselves; without --held-out, whole planes, maps and dark blocks are kept back",
                )
            })?;
            notes.extend(left_out);
        }
        given.push(later);
    }
    for given in &mut given {
        notes.extend(own_readings::leave_out(model, given));
    }
    notes.extend(heads::number(model, &mut given));
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
    Ok(hex::encode(hash.finalize()))
}

/// `ring.model.toml` → `ring.model.v2.toml`; `ring.v2.toml` → `ring.v3.toml`.
pub(crate) fn next_version(path: &Utf8Path) -> Utf8PathBuf {
    let extension = path.extension().unwrap_or("toml");
    let stem = path.file_stem().unwrap_or("model");
    let (base, version) = match stem.rsplit_once(".v") {
        Some((base, number)) => number.parse::<u32>().map_or((stem, 2), |number| (base, number + 1)),
        None => (stem, 2),
    };
    path.with_file_name(format!("{base}.v{version}.{extension}"))
}

fn write(
    request: &DiagnoseRequest,
    out: &Utf8Path,
    model: &Model,
    found: &Diagnosis,
    diff: &[String],
) -> Result<(), Failure> {
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
    TextDiff::from_slices(&old, &new)
        .iter_all_changes()
        .filter(|change| change.tag() != ChangeTag::Equal)
        .map(|change| format!("{} {}", change.tag(), change.value()))
        .collect()
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
