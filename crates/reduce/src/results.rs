//! The files of `results/` that reduction makes. No clock and no path in them: the same run gives the same bytes.

mod budget;
mod colours;
mod directions;
mod file;
mod model_file;
mod photometric;

use isolux_photometry::IntensityDistribution;
use isolux_record::disk::sha256;
use isolux_record::run::Run;
use serde_json::{Value, json};

pub use budget::{Budget, Subtracted};
pub use colours::FOLDER as COLOUR_FOLDER;
pub use file::ResultFile;
pub use photometric::photometric;

use crate::Reduction;
use crate::error::ReduceError;
pub use file::file_name;
use file::hashes;
use model_file::model_toml;
use photometric::{header, ies, ldt, observed_spectrum, spectral_files, xml, xml_with_spectra};

/// Every file of a reduction. `run_files` are the names and bytes of the run's own files, for their hashes.
///
/// # Errors
/// [`ReduceError::Format`] when a format cannot hold the result.
pub fn files(
    reduction: &Reduction,
    run: &Run,
    run_files: &[(String, Vec<u8>)],
    program: &str,
) -> Result<Vec<ResultFile>, ReduceError> {
    let shown = without_negative(&reduction.grid.distribution)?;
    let state = match (&reduction.partial, &reduction.grid.smoothed) {
        (Some(_), _) => ", PARTIAL",
        (None, Some(_)) => ", smoothed",
        (None, None) => "",
    };
    let named = |name: &str| file_name(reduction, name);
    let mut files = vec![ResultFile {
        name: named("luminaire.ldt"),
        bytes: ldt(&shown, &header(state, reduction, run))?,
    }];
    if let Some((raw, _)) = &reduction.grid.smoothed {
        files.push(ResultFile {
            name: named("luminaire.raw.ldt"),
            bytes: ldt(&without_negative(raw)?, &header(", as read", reduction, run))?,
        });
    }
    files.push(ResultFile {
        name: named("luminaire.ies"),
        bytes: ies(&shown, reduction, run, program),
    });
    files.push(ResultFile {
        name: named("luminaire.xml"),
        bytes: xml(&shown, state, reduction, run),
    });
    files.extend(xml_with_spectra(&shown, state, reduction, run).map(|bytes| ResultFile {
        name: named("luminaire.tm33-23.xml"),
        bytes,
    }));
    files.push(ResultFile {
        name: named("luminaire.directions.csv"),
        bytes: directions::directions(reduction).into_bytes(),
    });
    files.extend(spectral_files(reduction, run, program));
    files.extend(observed_spectrum(reduction, run));
    files.extend(colours::files(reduction, run, program));
    files.extend(crate::eu_label::file(reduction, run)?.map(|text| ResultFile {
        name: named(crate::eu_label::FILE),
        bytes: text.into_bytes(),
    }));
    let model = model_toml(reduction, run, run_files);
    files.push(ResultFile {
        name: named("luminaire.model.toml"),
        bytes: model.into_bytes(),
    });
    files.push(ResultFile {
        name: named("budget.json"),
        bytes: pretty(&json!(Budget::of(reduction, &shown))),
    });
    let provenance = provenance(reduction, run, run_files, program, &files);
    files.push(ResultFile {
        name: named("provenance.json"),
        bytes: pretty(&provenance),
    });
    Ok(files)
}

/// The distribution as files hold it: noise about zero that came out negative is written as zero there. The budget's
/// flux is that of the readings; what the zeros add to it stands in `budget.json`.
fn without_negative(measured: &IntensityDistribution) -> Result<IntensityDistribution, ReduceError> {
    let floor = measured.intensity_cd().iter().map(|value| value.max(0.0)).collect();
    Ok(IntensityDistribution::new(
        measured.c_deg().to_vec(),
        measured.gamma_deg().to_vec(),
        floor,
    )?)
}

/// budget.json of a reduction, without its other files.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a distribution that is one already.
pub fn budget_of(reduction: &Reduction) -> Result<Budget, ReduceError> {
    Ok(Budget::of(reduction, &without_negative(&reduction.grid.distribution)?))
}

fn provenance(
    reduction: &Reduction,
    run: &Run,
    run_files: &[(String, Vec<u8>)],
    program: &str,
    made: &[ResultFile],
) -> Value {
    let object = |pairs: Vec<(String, String)>| -> Value {
        Value::Object(
            pairs
                .into_iter()
                .map(|(name, hash)| (name, Value::String(hash)))
                .collect(),
        )
    };
    let made = made
        .iter()
        .map(|file| (file.name.clone(), sha256(&file.bytes)))
        .collect();
    json!({
        "program": program,
        "run": { "started_utc": run.header.started_utc, "sha256": object(hashes(run_files)) },
        "luminaire": run.header.luminaire,
        "report": run.header.report,
        "ratings": run.header.ratings,
        "eu_label": run.header.eu_label,
        "devices": run.header.device,
        "without": reduction.without,
        "accepted_drift": reduction.accepted,
        "missing_in_flux": reduction.flux.missing,
        "removed_effects": reduction.removed_effects,
        "results_sha256": object(made),
    })
}

fn pretty(value: &Value) -> Vec<u8> {
    format!("{value:#}\n").into_bytes()
}
