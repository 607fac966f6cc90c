//! `isolux reduce`: the record of a scan → distribution, spectrum, files and budget.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::Model;
use isolux_record::{Run, Subject};
use isolux_reduce::{Budget, COLOUR_FOLDER, Options, ReduceError, reduce};
pub use isolux_reduce::{Correction, Quantity, Reduction, ResultFile};

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::run::record;

/// Name and version, as it stands in files that this program writes.
pub const PROGRAM: &str = concat!("isolux ", env!("CARGO_PKG_VERSION"));

/// A reduced run and where its files are.
#[derive(Debug)]
pub struct Reduced {
    /// The run as it was read.
    pub run: Run,
    /// What it says.
    pub reduction: Reduction,
    /// The folder of results.
    pub folder: Utf8PathBuf,
    /// Names of the files written there.
    pub files: Vec<String>,
    /// Reports beside them that are of other results.
    pub outdated: Vec<&'static str>,
}

impl Reduced {
    /// The headline numbers, each with unit and expanded uncertainty (k = 2), the notes, and where the files are.
    pub fn sentences(&self) -> Vec<String> {
        let reduction = &self.reduction;
        let mut lines = vec![
            format!("flux {}", reduction.flux.stated()),
            format!(
                "I max {} at C {}° γ {}°",
                reduction.i_max.stated(),
                reduction.i_max_deg.0,
                reduction.i_max_deg.1
            ),
        ];
        if let Some(electrical) = &reduction.electrical {
            lines.push(format!("power {}", electrical.power.stated()));
            lines.push(format!("luminous efficacy {}", electrical.luminous_efficacy.stated()));
        }
        if let Some(spectral) = &reduction.spectral {
            lines.push(format!("efficacy of radiation {}", spectral.ler.stated()));
            lines.extend(spectral.colour.cct.as_ref().map(|cct| format!("CCT {}", cct.stated())));
            lines.push(format!(
                "irradiance on the axis at {} mm {}",
                spectral.distance_mm,
                spectral.irradiance.stated()
            ));
        }
        if let Some(found) = &reduction.over_angle {
            let facts = &found.facts;
            let cct = facts.total.colour.cct.as_ref();
            lines.extend(cct.map(|cct| format!("CCT of the whole light {}", cct.stated())));
            let cct = facts.average_lm79.cct.as_ref();
            lines.extend(cct.map(|cct| format!("CCT of the average of LM-79 {}", cct.stated())));
            let delta = &facts.delta_u_prime_v_prime;
            lines.push(format!(
                "Δu′v′ {} at C {}° γ {}°",
                delta.value.stated(),
                delta.c_deg,
                delta.gamma_deg
            ));
            lines.push(isolux_report::day::colour_sentence(found));
        }
        lines.extend(reduction.notes.iter().map(|note| format!("note: {note}")));
        if !self.outdated.is_empty() {
            lines.push(format!(
                "note: {} beside these results: of earlier ones; `isolux report {} --force` makes the report again",
                self.outdated.join(" and "),
                self.run.path
            ));
        }
        // Of the spectra of many directions their folder is enough.
        let of_directions = |name: &&String| Utf8Path::new(name).parent() == Some(COLOUR_FOLDER.into());
        let (colours, others): (Vec<&String>, Vec<&String>) = self.files.iter().partition(of_directions);
        let mut names: Vec<String> = others.into_iter().cloned().collect();
        if !colours.is_empty() {
            names.push(format!("{} spectra in {COLOUR_FOLDER}/", colours.len()));
        }
        lines.push(format!("{} in {}", names.join(", "), self.folder));
        lines
    }
}

/// What is asked of a reduction.
#[derive(Debug, Clone, Default)]
pub struct ReduceRequest<'a> {
    /// Folder of the results; without one `RUN/results`, or `RUN/results-partial` where the scan is not finished.
    pub out: Option<&'a Utf8Path>,
    /// Names of corrections to leave out.
    pub without: &'a [String],
    /// A model whose bench effects are taken out of the readings.
    pub with: Option<&'a Utf8Path>,
    /// Why a drift beyond the limits of the plan is accepted; none: it is refused.
    pub accept_drift: Option<&'a str>,
    /// What was measured and for whom, where that is known better than the record knows it.
    pub subject: Option<&'a Subject>,
}

/// Reduces the run in `run` and writes its results.
///
/// # Errors
/// "No" (exit 1) for a drift, an unstable reference or a closing half-plane beyond the limits of the plan. Bad input
/// (exit 2) for a record that gives no distribution, an unknown correction, a bench effect without inverse, or results
/// that exist. Nothing is written then.
pub fn run(run: &Utf8Path, request: &ReduceRequest<'_>, overwrite: Overwrite) -> Result<Reduced, Failure> {
    let (record, reduction, made, kept) = computed(run, request)?;
    let folder = folder(run, request, &reduction);
    let outdated = publish(&folder, &made, kept, overwrite)?;
    Ok(Reduced {
        run: record,
        reduction,
        folder,
        files: made.into_iter().map(|file| file.name).collect(),
        outdated,
    })
}

/// Reduces as [`run`] does: the reduction and its files, which are written where `overwrite` says how.
///
/// # Errors
/// As [`run`].
pub fn made(
    run: &Utf8Path,
    request: &ReduceRequest<'_>,
    overwrite: Option<Overwrite>,
) -> Result<(Reduction, Vec<ResultFile>), Failure> {
    let (_, reduction, made, kept) = computed(run, request)?;
    if let Some(overwrite) = overwrite {
        publish(&folder(run, request, &reduction), &made, kept, overwrite)?;
    }
    Ok((reduction, made))
}

fn folder(run: &Utf8Path, request: &ReduceRequest<'_>, reduction: &Reduction) -> Utf8PathBuf {
    request
        .out
        .map_or_else(|| results_folder(run, reduction), Utf8Path::to_owned)
}

/// Writes the files of a reduction; the reports beside them that are of other results.
fn publish(
    folder: &Utf8Path,
    made: &[ResultFile],
    kept: Option<KeptModel>,
    overwrite: Overwrite,
) -> Result<Vec<&'static str>, Failure> {
    for file in made {
        files::refuse_existing(&folder.join(&file.name), overwrite)?;
    }
    let outdated = outdated(folder, made);
    keep_model(folder, kept)?;
    remove_raw(folder, made)?;
    remove_colours(folder, made)?;
    for file in made {
        files::write(&folder.join(&file.name), &file.bytes, overwrite)?;
    }
    Ok(outdated)
}

/// The files of the model that was given, by name.
type KeptModel = Vec<(String, Vec<u8>)>;

/// The run, what it says, its files, and the files of the model that was given.
type Computed = (Run, Reduction, Vec<ResultFile>, Option<KeptModel>);

fn computed(run: &Utf8Path, request: &ReduceRequest<'_>) -> Result<Computed, Failure> {
    let without = request
        .without
        .iter()
        .map(|word| word.parse::<Correction>())
        .collect::<Result<BTreeSet<_>, _>>()
        .map_err(Failure::bad_input)?;
    let model = request.with.map(Model::load).transpose().map_err(Failure::bad_input)?;
    // Read before anything is written: the model may lie among the results that are replaced.
    let kept = model.as_ref().map(model_files).transpose()?;
    let mut record = record::read_at_rest(run)?;
    if let Some(subject) = request.subject {
        record.header.state(subject);
    }
    let accept_drift = request.accept_drift.map(str::to_owned);
    let reduction = reduce(&record, &Options { without, accept_drift }, model).map_err(|error| refused(run, &error))?;
    let mut inputs = run_files(run, &record)?;
    inputs.extend(kept_inputs(kept.as_deref()));
    let made = isolux_reduce::files(&reduction, &record, &inputs, PROGRAM).map_err(Failure::bad_input)?;
    Ok((record, reduction, made, kept))
}

/// The reports in a folder whose results are about to become others; provenance.json names the program too, which is no
/// result.
fn outdated(folder: &Utf8Path, made: &[ResultFile]) -> Vec<&'static str> {
    let others = made
        .iter()
        .filter(|file| !file.name.starts_with("provenance"))
        .any(|file| std::fs::read(folder.join(&file.name)).ok().as_ref() != Some(&file.bytes));
    ["report.html", "report.pdf"]
        .into_iter()
        .filter(|name| others && folder.join(name).is_file())
        .collect()
}

/// With which options the results were made beside which `budget` lies; none where it is not there.
///
/// # Errors
/// Bad input (exit 2) for a file that is no budget.
pub(crate) fn options_of(budget: &Utf8Path) -> Result<Option<Options>, Failure> {
    if !budget.is_file() {
        return Ok(None);
    }
    let Budget {
        without,
        accepted_drift,
        ..
    } = files::read_json(budget)?;
    Ok(Some(Options {
        without,
        accept_drift: accepted_drift.map(|accepted| accepted.reason),
    }))
}

/// Where the results of a run lie: those of a scan that is not finished in a folder of their own, so that nothing takes
/// them for the whole.
pub fn results_folder(run: &Utf8Path, reduction: &Reduction) -> Utf8PathBuf {
    run.join(if reduction.partial.is_some() {
        "results-partial"
    } else {
        "results"
    })
}

/// The distribution before it was smoothed.
const RAW: &str = "luminaire.raw.ldt";

/// The failure of a record that gives no result.
pub(super) fn refused(run: &Utf8Path, error: &ReduceError) -> Failure {
    let message = format!("{run}: {error}");
    match error {
        ReduceError::Unsteady { .. } => Failure::no(message).help(
            "nothing was written; look at these rows, measure again what they spoil, or give --accept-drift=REASON: then every \
             result says so and carries no uncertainty",
        ),
        _ => Failure::bad_input(message),
    }
}

/// Folder in the results with the model whose bench effects were taken out, and the file's name there.
pub(crate) const REDUCED_WITH: [&str; 2] = ["reduced_with", "model.toml"];

/// The model that was given to the reduction whose results lie in `results`, if one was.
///
/// # Errors
/// Bad input (exit 2) for a model that cannot be read.
pub(crate) fn kept_model(results: &Utf8Path) -> Result<Option<Model>, Failure> {
    let [folder, name] = REDUCED_WITH;
    let file = results.join(folder).join(name);
    file.is_file()
        .then(|| Model::load(&file).map_err(Failure::bad_input))
        .transpose()
}

/// The files of a model by name, each beside the other.
fn model_files(model: &Model) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut kept = Vec::new();
    for (name, from) in model.files() {
        let name = Utf8Path::new(&name).file_name().unwrap_or("distribution");
        kept.push((name.to_owned(), files::read(&from)?));
    }
    let text = model.beside_its_files().to_toml().into_bytes();
    kept.push((REDUCED_WITH[1].to_owned(), text));
    Ok(kept)
}

/// Keeps the model of the reduction with its results, from which the report makes it again; takes away that of an
/// earlier one.
fn keep_model(results: &Utf8Path, kept: Option<Vec<(String, Vec<u8>)>>) -> Result<(), Failure> {
    let folder = results.join(REDUCED_WITH[0]);
    if folder.join(REDUCED_WITH[1]).is_file() {
        std::fs::remove_dir_all(&folder).map_err(|error| Failure::instrument(format!("{folder}: {error}")))?;
    }
    for (name, bytes) in kept.into_iter().flatten() {
        files::write(&folder.join(name), &bytes, Overwrite::Force)?;
    }
    Ok(())
}

/// The files of the kept model by their names in the results, for their hashes in provenance.json.
fn kept_inputs(kept: Option<&[(String, Vec<u8>)]>) -> impl Iterator<Item = (String, Vec<u8>)> {
    let kept = kept.into_iter().flatten();
    kept.map(|(name, bytes)| (format!("{}/{name}", REDUCED_WITH[0]), bytes.clone()))
}

/// Removes the raw distribution of an earlier reduction where this one is not smoothed and writes none.
fn remove_raw(results: &Utf8Path, made: &[isolux_reduce::ResultFile]) -> Result<(), Failure> {
    let file = results.join(RAW);
    if made.iter().any(|file| file.name == RAW) || !file.is_file() {
        return Ok(());
    }
    std::fs::remove_file(&file).map_err(|error| Failure::instrument(format!("{file}: {error}")))
}

/// Removes the spectra of directions that an earlier reduction wrote and this one does not.
fn remove_colours(results: &Utf8Path, made: &[isolux_reduce::ResultFile]) -> Result<(), Failure> {
    let folder = results.join(COLOUR_FOLDER);
    let failed = |error: std::io::Error| Failure::instrument(format!("{folder}: {error}"));
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in folder.read_dir_utf8().map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = format!("{}/{}", COLOUR_FOLDER, entry.file_name());
        if entry.path().extension() == Some("spdx") && !made.iter().any(|file| file.name == name) {
            std::fs::remove_file(entry.path()).map_err(failed)?;
        }
    }
    Ok(())
}

/// Names and bytes of the record's own files, for their hashes.
pub(crate) fn run_files(folder: &Utf8Path, run: &Run) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let spectra = run
        .spectra
        .iter()
        .map(|spectrum| format!("spectra/{:03}.csv", spectrum.index));
    std::iter::once("readings.csv".to_owned())
        .chain(spectra)
        .map(|name| Ok((name.clone(), files::read(&folder.join(&name))?)))
        .collect()
}
