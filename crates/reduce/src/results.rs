//! The files of `results/` that reduction makes. No clock and no path in them: the same run gives the same bytes.

use isolux_formats::distribution::Luminaire;
use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{Distribution, Format, eulumdat, ies, tm33};
use isolux_photometry::{IntensityDistribution, Symmetry};
use isolux_record::run::Run;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::budget::noise_of_directions;
use crate::error::ReduceError;
use crate::gate;
use crate::headline::NEAR_FIELD_AT_SENSOR;
use crate::{Drift, Quantity, Reduction, SENSOR_MM};

/// One file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultFile {
    /// Its name in the folder of results.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

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
    let model = model_toml(reduction, diameter_mm(run), run_files);
    files.push(ResultFile {
        name: named("luminaire.model.toml"),
        bytes: model.into_bytes(),
    });
    files.push(ResultFile {
        name: named("budget.json"),
        bytes: pretty(&budget(reduction, &shown)),
    });
    let provenance = provenance(reduction, run, run_files, program, &files);
    files.push(ResultFile {
        name: named("provenance.json"),
        bytes: pretty(&provenance),
    });
    Ok(files)
}

/// The name of a result: `luminaire.partial.ldt` where the scan is not finished.
pub fn file_name(reduction: &Reduction, name: &str) -> String {
    match (&reduction.partial, name.split_once('.')) {
        (Some(_), Some((stem, extension))) => format!("{stem}.partial.{extension}"),
        _ => name.to_owned(),
    }
}

/// The luminaire's name as the job states it; the name of the station is that of a bench.
fn name(run: &Run) -> String {
    run.header.luminaire.name.clone().unwrap_or_default()
}

/// The day of the measurement.
fn date(run: &Run) -> String {
    run.header.started_utc.chars().take(10).collect()
}

/// The general colour rendering index of the measured spectrum.
fn ra(reduction: &Reduction) -> Option<f64> {
    let spectral = reduction.spectral.as_ref()?;
    isolux_spectrum::quantities(&spectral.spectrum).ra
}

fn diameter_mm(run: &Run) -> Option<f64> {
    run.header.station.lamp().and_then(|lamp| lamp.diameter_mm)
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

/// What EULUMDAT says beside the light; `state` follows the distance.
fn header(state: &str, reduction: &Reduction, run: &Run) -> eulumdat::Header {
    let (luminaire, report) = (&run.header.luminaire, &run.header.report);
    let colour = reduction
        .spectral
        .as_ref()
        .and_then(|spectral| spectral.colour.cct.as_ref());
    eulumdat::Header {
        company: luminaire.maker.clone().unwrap_or_default(),
        report: format!(
            "{}isolux {:.0} mm{state}{}",
            report
                .number
                .as_ref()
                .map_or_else(String::new, |number| format!("{number}; ")),
            reduction.distance_mm,
            match reduction.grid.assumed {
                Symmetry::None => "",
                _ => ", symmetry assumed",
            }
        ),
        name: name(run),
        number: luminaire.catalogue_number.clone().unwrap_or_default(),
        date_user: date_user(reduction, run),
        length_mm: diameter_mm(run),
        width_mm: Some(0.0),
        height_mm: Some(0.0),
        luminous_length_mm: diameter_mm(run),
        luminous_width_mm: Some(0.0),
        luminous_height_mm: [Some(0.0); 4],
        lorl_percent: Some(100.0),
        tilt_deg: Some(0.0),
        lamp_sets: vec![eulumdat::LampSet {
            count: Some(-1.0),
            lamp: luminaire.light_source.clone().unwrap_or_default(),
            flux_lm: Some(reduction.flux.value),
            watts: watts(reduction),
            colour: colour.map_or_else(String::new, |cct| format!("{:.0} K", cct.value)),
            rendering: ra(reduction).map_or_else(String::new, |ra| format!("{ra:.0}")),
        }],
        ..eulumdat::Header::default()
    }
}

fn ldt(shown: &IntensityDistribution, header: &eulumdat::Header) -> Result<Vec<u8>, ReduceError> {
    let written = eulumdat::write(shown, header).map_err(|finding| ReduceError::Format {
        file: "luminaire.ldt",
        message: finding.message.into(),
    })?;
    Ok(written.bytes)
}

/// Mean active power to five digits, as many as power meters show; none without one.
fn watts(reduction: &Reduction) -> Option<f64> {
    let watts = reduction.electrical.as_ref()?.power_w.mean;
    format!("{watts:.4e}").parse().ok()
}

/// The line of 78 characters for date and user: the day, the operator, and what the flux in the file lacks.
fn date_user(reduction: &Reduction, run: &Run) -> String {
    let parts = [
        date(run),
        run.header.report.operator.clone().unwrap_or_default(),
        ldt_remark(reduction),
    ];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    parts.join("; ").chars().take(78).collect()
}

/// What the flux in the file lacks, in the line of 78 signs that EULUMDAT has for date and user.
fn ldt_remark(reduction: &Reduction) -> String {
    let missing = &reduction.flux.missing;
    let Some(first) = missing
        .iter()
        .find(|phrase| phrase.starts_with("partial") || *phrase == gate::ACCEPTED)
        .or(missing.first())
    else {
        return String::new();
    };
    let mut text = ascii(&format!("no uncertainty: {first}"));
    if missing.len() > 1 {
        text.truncate(60);
        text.push_str(&format!("; {} more", missing.len() - 1));
    }
    text
}

/// The text in the letters that every reader of these files knows.
fn ascii(text: &str) -> String {
    let plain = text
        .replace('γ', "gamma")
        .replace('°', " deg")
        .replace('±', "+-")
        .replace('′', "'");
    plain.chars().map(|c| if c.is_ascii() { c } else { ' ' }).collect()
}

fn ies(shown: &IntensityDistribution, reduction: &Reduction, run: &Run, program: &str) -> Vec<u8> {
    let metres = diameter_mm(run).unwrap_or(0.0) * 1e-3;
    let (luminaire, report) = (&run.header.luminaire, &run.header.report);
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let test = report
        .number
        .as_ref()
        .map_or_else(String::new, |number| format!("{number}; "));
    let mut keywords = vec![
        (
            "TEST",
            format!("{test}goniophotometer, {:.0} mm", reduction.distance_mm),
        ),
        ("TESTLAB", text(&report.laboratory)),
        ("ISSUEDATE", date(run)),
        ("MANUFAC", text(&luminaire.maker)),
        ("LUMCAT", text(&luminaire.catalogue_number)),
        ("LUMINAIRE", name(run)),
    ];
    let stated = [
        ("LAMP", "", &luminaire.light_source),
        ("BALLAST", "", &luminaire.driver),
        ("OTHER", "sample ", &luminaire.sample),
        ("OTHER", "burning position ", &luminaire.burning_position),
        ("OTHER", "customer ", &report.customer),
        ("OTHER", "operator ", &report.operator),
    ];
    keywords.extend(
        stated
            .into_iter()
            .filter_map(|(keyword, what, text)| Some((keyword, format!("{what}{}", text.as_ref()?)))),
    );
    keywords.push(("OTHER", format!("{program}; {}", flux_words(&reduction.flux))));
    keywords.extend(reduction.grid.smoothed.as_ref().map(|_| {
        let text = "smoothed within the rounding and the scatter of the readings";
        ("OTHER", text.to_owned())
    }));
    let missing = reduction.flux.missing.iter();
    keywords.extend(missing.map(|phrase| ("OTHER", ascii(&format!("no uncertainty: {phrase}")))));
    keywords.extend(crate::circle::note(reduction.grid.assumed).map(|note| {
        // The first clause: LM-63 has short lines of ASCII.
        let clause = note.split(',').next().unwrap_or_default();
        ("OTHER", clause.to_owned())
    }));
    let facts = ies::Facts {
        keywords: keywords
            .into_iter()
            .map(|(keyword, text)| (keyword.to_owned(), text))
            .collect(),
        lamp_flux_lm: None,
        lamp_count: 1.0,
        // LM-63: a circular opening has minus its diameter as width and length.
        opening_m: [-metres, -metres, 0.0],
        watts: watts(reduction).unwrap_or(0.0),
        generation: None,
        tilt: None,
    };
    ies::write(shown, &facts, ies::Edition::E2002).bytes
}

/// The flux in words of ASCII.
fn flux_words(flux: &Quantity) -> String {
    let said = flux.rounded();
    match flux.u {
        Some(_) => format!(
            "flux {} lm, expanded uncertainty {} lm (k = 2)",
            said.value, said.expanded
        ),
        None => format!("flux {} lm, uncertainty not evaluated", said.value),
    }
}

/// The distribution as TM-33-18, with the laboratory and the number of the report in fields of their own.
fn xml(shown: &IntensityDistribution, state: &str, reduction: &Reduction, run: &Run) -> Vec<u8> {
    tm33::write(&document(shown, state, reduction, run), tm33::Edition::E2018).bytes
}

/// What TM-33 has no element for: sample, conditions, people, and how good the flux is.
fn comments(reduction: &Reduction, run: &Run) -> String {
    let (luminaire, report) = (&run.header.luminaire, &run.header.report);
    let stated = [
        ("sample", &luminaire.sample),
        ("control gear", &luminaire.driver),
        ("burning position", &luminaire.burning_position),
        ("customer", &report.customer),
        ("operator", &report.operator),
    ];
    let mut parts: Vec<String> = stated
        .into_iter()
        .filter_map(|(what, text)| Some(format!("{what} {}", text.as_ref()?)))
        .collect();
    parts.push(format!("photometric distance {:.0} mm", reduction.distance_mm));
    parts.push(flux_words(&reduction.flux));
    parts.extend(
        reduction
            .flux
            .missing
            .iter()
            .map(|phrase| format!("no uncertainty: {phrase}")),
    );
    parts.join("; ")
}

/// The distribution with what formats say of a luminaire, as the readers of this workspace would have it from a file.
pub fn photometric(reduction: &Reduction, run: &Run) -> Distribution {
    document(&reduction.grid.distribution, "", reduction, run)
}

fn document(shown: &IntensityDistribution, state: &str, reduction: &Reduction, run: &Run) -> Distribution {
    let header = header(state, reduction, run);
    let set = header.lamp_sets.first().cloned().unwrap_or_default();
    let report = &run.header.report;
    Distribution {
        intensity: shown.clone(),
        symmetry: Symmetry::None,
        lamp_flux_lm: Some(reduction.flux.value),
        absolute: true,
        native: None,
        luminaire: Luminaire {
            manufacturer: header.company,
            name: header.name,
            number: header.number,
            report: report.number.clone().unwrap_or_default(),
            date: date(run),
            laboratory: report.laboratory.clone().unwrap_or_default(),
            luminous_length_mm: header.luminous_length_mm,
            luminous_width_mm: header.luminous_width_mm,
            lamp: set.lamp,
            lamp_count: Some(1.0),
            colour: set.colour,
            rendering: set.rendering,
            watts: set.watts,
            ..Luminaire::default()
        },
        header: serde_json::Map::from_iter([("comments".to_owned(), comments(reduction, run).into())]),
        eulumdat: None,
    }
}

fn spectral_files(reduction: &Reduction, run: &Run, program: &str) -> Vec<ResultFile> {
    let Some(spectral) = &reduction.spectral else {
        return Vec::new();
    };
    let mut file = SpectrumFile::new(&spectral.spectrum, Some("irradiance"), Some("W/(m2*nm)"));
    let text = |value: String| Value::String(value);
    file.header.insert(
        "Description".to_owned(),
        text(format!(
            "{}on the axis at {} mm",
            run.header
                .luminaire
                .name
                .as_ref()
                .map_or_else(String::new, |name| format!("{name}, ")),
            spectral.distance_mm
        )),
    );
    file.header
        .insert("DocumentCreator".to_owned(), text(program.to_owned()));
    file.header.insert("ReportDate".to_owned(), text(date(run)));
    let (luminaire, report) = (&run.header.luminaire, &run.header.report);
    for (key, value) in [
        ("Manufacturer", &luminaire.maker),
        ("CatalogNumber", &luminaire.catalogue_number),
        ("Laboratory", &report.laboratory),
        ("ReportNumber", &report.number),
    ] {
        if let Some(value) = value {
            file.header.insert(key.to_owned(), text(value.clone()));
        }
    }
    [("luminaire.spdx", Format::SPDX), ("luminaire.spd", Format::SPD)]
        .into_iter()
        .filter_map(|(name, format)| {
            Some(ResultFile {
                name: file_name(reduction, name),
                bytes: isolux_formats::write_spectrum(&file, format)?.bytes,
            })
        })
        .collect()
}

/// The model of the run: its distribution and spectrum with a disc of 1 mm as emitter, and the offset, ambient and
/// stray light that were taken out of the readings as effects of the bench, so that its predictions are readings again.
fn model_toml(reduction: &Reduction, diameter_mm: Option<f64>, run_files: &[(String, Vec<u8>)]) -> String {
    let mut text = format!(
        "format = \"isolux-model/1\"\n\n[luminaire]\ndistribution = \"{}\"\n",
        file_name(reduction, "luminaire.ldt")
    );
    if reduction.spectral.is_some() {
        text.push_str(&format!("spectrum = \"{}\"\n", file_name(reduction, "luminaire.spdx")));
    }
    text.push_str("emitter = { shape = \"disc\", diameter_mm = 1.0 }\n\n");
    text.push_str("[luminaire.trust]\nshape = \"smooth\"\nc_harmonics = [2]\n\n");
    text.push_str(&uncertainty_toml(reduction, diameter_mm));
    let (direction_rel, direction_cd) = noise_of_directions(&reduction.grid);
    text.push_str(&format!(
        "direction_rel = {direction_rel:.8}\ndirection_cd = {direction_cd:.6}\n"
    ));
    text.push_str("\n[luminaire.provenance]\n");
    for (file, hash) in hashes(run_files) {
        if file == "readings.csv" {
            text.push_str(&format!("readings_sha256 = \"{hash}\"\n"));
        }
    }
    // First and last of each run of numbers.
    let runs = reduction.made_of.chunk_by(|a, b| a + 1 == *b);
    let runs: Vec<String> = runs
        .map(|run| format!("[{}, {}]", run[0], run[run.len() - 1]))
        .collect();
    text.push_str(&format!("distribution_rows = [{}]\n", runs.join(", ")));
    if !reduction.removed_effects.is_empty() {
        text.push_str(&format!("removed = {:?}\n", reduction.removed_effects));
    }
    if let Some(accepted) = &reduction.accepted {
        text.push_str(&format!("accepted = {}\n", toml::Value::from(gate::note(accepted))));
    }
    text.push_str("\n[noise]\nu_scale = \"stated\"\n");
    for effect in bench_effects(reduction) {
        text.push_str(&format!("\n[[effect]]\n{effect}"));
    }
    text
}

/// `[luminaire.u]`: relative standard uncertainties of the intensities near the axis, of the flux, and of the efficacy,
/// each where nothing is missing in it; what is missing; the size of the luminous area, which the emitter of 1 mm
/// leaves out.
fn uncertainty_toml(reduction: &Reduction, diameter_mm: Option<f64>) -> String {
    let mut text = String::from("[luminaire.u]\n");
    // The near field at some sensor's distance is the simulation's, which knows the distance.
    let near_axis = reduction.sensor_illuminance.without_part(NEAR_FIELD_AT_SENSOR);
    let ler = reduction.spectral.as_ref().map(|spectral| &spectral.ler);
    let mut missing: Vec<&String> = Vec::new();
    for (key, quantity) in [
        ("intensity_rel", Some(&near_axis)),
        ("flux_rel", Some(&reduction.flux)),
        ("ler_rel", ler),
    ] {
        let Some(quantity) = quantity else { continue };
        // Where the axis was not measured there is no light to be uncertain of.
        if let Some(rel) = quantity.u_rel().filter(|rel| rel.is_finite()) {
            text.push_str(&format!("{key} = {rel:.6}\n"));
        }
        for phrase in &quantity.missing {
            if !missing.contains(&phrase) {
                missing.push(phrase);
            }
        }
    }
    if !missing.is_empty() {
        let list: Vec<toml::Value> = missing.into_iter().map(|phrase| phrase.as_str().into()).collect();
        text.push_str(&format!("missing = {}\n", toml::Value::Array(list)));
    }
    if let Some(diameter_mm) = diameter_mm {
        text.push_str(&format!("luminous_diameter_mm = {diameter_mm:?}\n"));
    }
    text
}

/// Offset and ambient light as the run measured them, and the drift of the lamp. A level within its uncertainty of
/// nothing is still what was subtracted.
fn bench_effects(reduction: &Reduction) -> Vec<String> {
    let [offset, ambient, _] = reduction.levels.parts_lx(0.0);
    let mut effects = Vec::new();
    if let Some(offset) = offset.filter(|_| reduction.subtract.dark) {
        effects.push(format!("name = \"dark_offset\"\noffset_lx = {offset:.6}\n"));
    }
    if let Some(ambient) = ambient.filter(|_| reduction.subtract.ambient) {
        effects.push(format!("name = \"ambient_stray\"\nilluminance_lx = {ambient:.6}\n"));
    }
    effects.extend(reduction.bench_effects.iter().cloned());
    effects.extend(lamp_drift(&reduction.drift));
    effects
}

/// The drift that was taken out of the readings, which the lamp still has. The intensities are those of its reference
/// time.
fn lamp_drift(drift: &Drift) -> Option<String> {
    let Drift::Linear {
        rate_per_h,
        u_rate_per_h,
        centre_s,
        ..
    } = drift
    else {
        return None;
    };
    Some(format!(
        "name = \"lamp_drift\"\nrate_per_h = {rate_per_h:.8}\nreference_s = {centre_s:.3}\n\n[effect.u]\n\
         rate_per_h = {u_rate_per_h:.8}\n\n[effect.provenance]\nby = \"reduce\"\nfrom = \"visits to the reference point\"\n"
    ))
}

/// budget.json.
fn budget(reduction: &Reduction, shown: &IntensityDistribution) -> Value {
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
        "flux_added_by_them_lm": shown.flux().value() - reduction.grid.distribution.flux().value(),
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

fn hashes(files: &[(String, Vec<u8>)]) -> Vec<(String, String)> {
    files
        .iter()
        .map(|(name, bytes)| (name.clone(), sha256(bytes)))
        .collect()
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

fn pretty(value: &Value) -> Vec<u8> {
    format!("{value:#}\n").into_bytes()
}
