//! The files of `results/` that reduction makes. No clock and no path in them: the same run gives the same bytes.

mod file;
mod model_file;
mod photometric;

use isolux_photometry::IntensityDistribution;
use isolux_record::disk::sha256;
use isolux_record::run::Run;
use serde_json::{Value, json};

pub use file::ResultFile;
pub use photometric::photometric;

use crate::error::ReduceError;
use crate::{Reduction, SENSOR_MM};
pub use file::file_name;
use file::hashes;
use model_file::model_toml;
use photometric::{header, ies, ldt, spectral_files, xml};

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
    files.extend(spectral_files(reduction, run, program));
    let model = model_toml(reduction, run, run_files);
    files.push(ResultFile {
        name: named("luminaire.model.toml"),
        bytes: model.into_bytes(),
    });
    files.push(ResultFile {
        name: named("budget.json"),
        bytes: pretty(&budget_of(reduction, &shown)),
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
pub fn budget_json(reduction: &Reduction) -> Result<Value, ReduceError> {
    Ok(budget_of(reduction, &without_negative(&reduction.grid.distribution)?))
}

/// budget.json; `shown` is the distribution as files hold it.
fn budget_of(reduction: &Reduction, shown: &IntensityDistribution) -> Value {
    let [offset, ambient, stray] = reduction.levels.parts_lx(0.0);
    let spectral = reduction.spectral.as_ref();
    // A sensor outside the measured zone has no number, not one of 0 ± 0.
    let seen = reduction.sensor_illuminance.u_of_parts_rel().is_finite();
    let mut budget = json!({
        "coverage": "standard uncertainties, k = 1; u is null where something is missing that was neither measured nor stated",
        "flux": reduction.flux,
        "i_max": reduction.i_max,
        "i_max_c_deg": reduction.i_max_deg.0,
        "i_max_gamma_deg": reduction.i_max_deg.1,
        "angles": reduction.angles,
        "sensor_mm": SENSOR_MM.0,
        "sensor_distance_mm": SENSOR_MM.1,
        "sensor_mean_illuminance": seen.then_some(&reduction.sensor_illuminance),
        "sensor_mean_irradiance": reduction.sensor_irradiance.as_ref().filter(|_| seen),
        "efficacy": spectral.map(|spectral| &spectral.ler),
        "cct": spectral.and_then(|spectral| spectral.colour.cct.as_ref()),
        "colour": spectral.map(|spectral| &spectral.colour),
        "on_axis_irradiance": spectral.map(|spectral| &spectral.irradiance),
        "on_axis_illuminance": spectral.map(|spectral| &spectral.illuminance),
        "on_axis_distance_mm": spectral.map(|spectral| spectral.distance_mm),
        "common": reduction.common,
        "subtracted": {
            "dark": reduction.subtract.dark, "ambient": reduction.subtract.ambient, "stray": reduction.subtract.stray,
            "offset_lx": offset, "ambient_lx": ambient, "stray_on_axis_lx": stray,
            "levels": reduction.levels,
        },
        "negative_points_written_as_zero": reduction.grid.distribution.intensity_cd().iter().filter(|cd| **cd < 0.0).count(),
        "flux_added_by_them_lm": shown.flux_lm() - reduction.grid.distribution.flux_lm(),
        "smoothing": reduction.grid.smoothed.as_ref().map(|(_, facts)| facts),
        "drift": reduction.drift,
        "closing_plane": reduction.closing,
        "pole_spread_cd": reduction.grid.pole_spread_cd,
        "distance_mm": reduction.distance_mm,
        "other_distances": reduction.other_distances,
        "readings_used": reduction.readings.0,
        "readings": reduction.readings.1,
        "without": reduction.without,
        "accepted_drift": reduction.accepted,
        "removed_effects": reduction.removed_effects,
        "notes": reduction.notes,
    });
    if let Some(partial) = &reduction.partial {
        budget["partial"] = json!(partial);
    }
    if let Some(electrical) = &reduction.electrical {
        budget["electrical"] = json!(electrical);
    }
    budget
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
