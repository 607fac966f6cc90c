//! The diagnosis of a run as it lies in its results: what it found, what was measured and simulated, and the effects
//! added to the model and taken out of it again.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_diagnose::document::{Document, EffectEntry, GapEntry, Independence, NextEntry, ParameterEntry};
use isolux_model::Model;
use isolux_record::disk::sha256;
use isolux_report::answer::{SAME_RECORD, effect_words, key_words};
use isolux_units::digits::{significant, stated};
use serde::{Deserialize, Serialize};

use super::curves::{Curve, curves};
use super::{Figure, StatedNumber, job, reduced_model};
use crate::Failure;
use crate::diagnosis::diagnose;
use crate::files::{self, Overwrite};

/// A diagnosis as the page shows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosed {
    /// The plain sentence.
    pub plain: String,
    /// The same with its statistics.
    pub sentence: String,
    /// Whether the model was made from these readings: then it is a check of the record.
    pub same_record: Option<&'static str>,
    /// The gap before and after, held-out readings included, as (name, before, after, expected of noise) in σ rms.
    pub gaps: Vec<(String, f64, f64, f64)>,
    /// The effects with their parameters.
    pub effects: Vec<Found>,
    /// Its pictures.
    pub figures: Vec<Figure>,
    /// What was measured and simulated, half-plane by half-plane.
    pub curves: Vec<Curve>,
    /// The model that it judges.
    pub model: String,
    /// Where its effects were added, if they were.
    pub added: Option<String>,
    /// What could be measured next.
    pub next: Vec<Proposal>,
    /// How many diagnoses the run has.
    pub round: usize,
}

/// An effect that was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// The term of the standards.
    pub name: String,
    /// What else would explain the readings as well.
    pub equivalents: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<StatedNumber>,
}

/// A measurement that would settle the answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Proposal {
    /// What, in words.
    pub what: String,
    /// What it tells apart.
    pub splits: [String; 2],
    /// How far apart their predictions would lie, in σ.
    pub expected_sigma: f64,
    /// Its plan file in the folder of the diagnosis; none where it is no plan of the axes.
    pub plan: Option<String>,
}

/// What was diagnosed: the model and the observations.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Case {
    /// The model.
    pub model: Utf8PathBuf,
    /// The observations.
    pub observations: Vec<Utf8PathBuf>,
}

/// Beside a diagnosis that followed a further measurement.
const CASE: &str = "case.json";
/// Beside a diagnosis whose effects were added to the model: where, and what was written.
const ADDED: &str = "added.json";

impl Case {
    /// Of the newest diagnosis in a run.
    pub(super) fn of(run: &Utf8Path) -> Self {
        let kept = std::fs::read(latest(run).0.join(CASE)).ok();
        if let Some(case) = kept.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            return case;
        }
        match job(run).as_ref().and_then(isolux_record::Job::diagnose) {
            Some((model, observations)) => Self {
                model: model.to_owned(),
                observations: observations.to_vec(),
            },
            None => Self {
                model: reduced_model(run),
                observations: vec![run.to_owned()],
            },
        }
    }

    /// Diagnoses the case into the next folder of `run`.
    ///
    /// # Errors
    /// As [`diagnose::run`].
    pub(super) fn diagnose(
        &self,
        run: &Utf8Path,
        progress: &dyn crate::front_end::progress::Progress,
    ) -> Result<(), Failure> {
        let (_, round) = latest(run);
        let out = folder(run, round + 1);
        let request = diagnose::DiagnoseRequest {
            model: self.model.clone(),
            observations: self.observations.clone(),
            out: out.clone(),
            held_out: None,
            seed: 1,
            accept: false,
            overwrite: Overwrite::Never,
        };
        diagnose::run(&request, progress)?;
        let named = Self {
            model: files::in_document(&self.model).into(),
            observations: self
                .observations
                .iter()
                .map(|path| files::in_document(path).into())
                .collect(),
        };
        let text = serde_json::to_vec_pretty(&named).map_err(Failure::instrument)?;
        files::write(&out.join(CASE), &text, Overwrite::Force)
    }
}

fn folder(run: &Utf8Path, round: usize) -> Utf8PathBuf {
    let results = run.join("results");
    match round {
        0 | 1 => results.join("diagnosis"),
        round => results.join(format!("diagnosis-{round}")),
    }
}

/// The newest diagnosis of a run, and how many there are.
pub(super) fn latest(run: &Utf8Path) -> (Utf8PathBuf, usize) {
    let there = |round: &usize| folder(run, *round).join("diagnosis.json").is_file();
    let rounds = (1..1000).take_while(there).count();
    (folder(run, rounds), rounds)
}

/// The newest diagnosis of the run directory `run`; none where there is none.
///
/// # Errors
/// Bad input (exit 2) for files that cannot be read.
pub fn diagnosed(run: &Utf8Path) -> Result<Option<Diagnosed>, Failure> {
    let (folder, round) = latest(run);
    if round == 0 {
        return Ok(None);
    }
    let document: Document = files::read_json(&folder.join("diagnosis.json"))?;
    let case = Case::of(run);
    Ok(Some(Diagnosed {
        same_record: (document.independence == Independence::SameRun).then_some(SAME_RECORD),
        gaps: gaps(&document.gap),
        effects: document.effects.iter().map(found).collect(),
        figures: figures(&folder),
        curves: curves(&folder, &case.observations)?,
        model: case.model.to_string(),
        added: added(run).map(Utf8PathBuf::into_string),
        next: document.next_measurement.iter().map(proposal).collect(),
        round,
        plain: document.plain,
        sentence: document.sentence,
    }))
}

fn gaps(gap: &GapEntry) -> Vec<(String, f64, f64, f64)> {
    let mut rows = vec![("fitted readings".to_owned(), gap.before, gap.after, gap.floor)];
    if let Some(held_out) = &gap.held_out {
        rows.push((
            "held-out readings".to_owned(),
            held_out.before,
            held_out.after,
            held_out.floor,
        ));
    }
    rows
}

fn found(effect: &EffectEntry) -> Found {
    let parameters = effect.parameters.iter().map(|(key, parameter)| {
        let ParameterEntry { value, u, unit, .. } = parameter;
        let unit = if unit == "1" { "" } else { unit };
        let value = if *u > 0.0 {
            stated(*value, *u, unit).replace("  ", " ")
        } else if value.is_finite() {
            format!("{} {unit}, no uncertainty", significant(*value, 4))
        } else {
            "no number".to_owned()
        };
        StatedNumber {
            name: key_words(key),
            value,
            reported: None,
        }
    });
    Found {
        name: effect.standard_name.to_string(),
        equivalents: effect.equivalents.iter().map(|label| effect_words(label)).collect(),
        parameters: parameters.collect(),
    }
}

fn proposal(next: &NextEntry) -> Proposal {
    Proposal {
        what: next.what.replace('_', " "),
        splits: next.splits.each_ref().map(|label| effect_words(label)),
        expected_sigma: next.expected_sigma,
        plan: next.plan.clone().filter(|plan| plan.ends_with(".plan.toml")),
    }
}

fn figures(folder: &Utf8Path) -> Vec<Figure> {
    [
        ("gap.svg", "Gap before and after"),
        ("residuals_before.svg", "Residuals before"),
        ("residuals_after.svg", "Residuals after"),
        ("spectra_before.svg", "Residuals of the spectrum before"),
        ("spectra_after.svg", "Residuals of the spectrum after"),
        ("coordinate.svg", "Residuals along the strongest pattern"),
    ]
    .into_iter()
    .filter_map(|(name, title)| Some(Figure::new(title, std::fs::read_to_string(folder.join(name)).ok()?)))
    .collect()
}

/// What was written where.
#[derive(Serialize, Deserialize)]
struct Added {
    file: Utf8PathBuf,
    sha256: String,
}

fn added_record(run: &Utf8Path) -> Option<Added> {
    let bytes = std::fs::read(latest(run).0.join(ADDED)).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// The model with the effects of the newest diagnosis, if they were added.
pub fn added(run: &Utf8Path) -> Option<Utf8PathBuf> {
    added_record(run).map(|added| added.file).filter(|file| file.is_file())
}

/// Adds the effects of the newest diagnosis: writes the next version of the model beside it. A sentence.
///
/// # Errors
/// Bad input (exit 2) where there is nothing to add, or it was added already; exit 3 when the disk refuses.
pub fn add_to_model(run: &Utf8Path) -> Result<String, Failure> {
    if let Some(file) = added(run) {
        return Err(Failure::bad_input(format!("the effects are in {file} already")));
    }
    let (folder, round) = latest(run);
    let found = diagnosed(run)?.filter(|found| round > 0 && !found.effects.is_empty());
    let Some(found) = found else {
        return Err(Failure::bad_input("no effect was found that could be added"));
    };
    let case = Case::of(run);
    let model = Model::load(&case.model).map_err(Failure::bad_input)?;
    let after = Model::load(&folder.join("model.after.toml")).map_err(Failure::bad_input)?;
    // The files that the model names stay where they are.
    let text = model
        .with_effects(after.effects().to_vec())
        .with_refined(after.refined().clone())
        .to_toml();
    let file = diagnose::next_version(&case.model);
    files::write(&file, text.as_bytes(), Overwrite::Never)?;
    let sha256 = sha256(text.as_bytes());
    let record = serde_json::to_vec_pretty(&Added {
        file: file.clone(),
        sha256,
    })
    .map_err(Failure::instrument)?;
    files::write(&folder.join(ADDED), &record, Overwrite::Force)?;
    let names: Vec<&str> = found.effects.iter().map(|effect| effect.name.as_str()).collect();
    Ok(format!("{} added: {file}", names.join(", ")))
}

/// Takes the effects out again: removes the file that [`add_to_model`] wrote. A sentence.
///
/// # Errors
/// Bad input (exit 2) where nothing was added, or the file was changed since; exit 3 when the disk refuses.
pub fn take_out_of_model(run: &Utf8Path) -> Result<String, Failure> {
    let Some(Added { file, sha256: expected }) = added_record(run) else {
        return Err(Failure::bad_input("nothing was added that could be taken out"));
    };
    let refused = |error: std::io::Error| Failure::instrument(format!("{file}: {error}"));
    if file.is_file() {
        if sha256(&files::read(&file)?) != expected {
            return Err(
                Failure::bad_input(format!("{file} was changed since; it is left as it is"))
                    .help("remove it by hand if it is not wanted"),
            );
        }
        std::fs::remove_file(&file).map_err(refused)?;
    }
    std::fs::remove_file(latest(run).0.join(ADDED)).map_err(refused)?;
    Ok(format!("{file} removed: the model is as before"))
}
