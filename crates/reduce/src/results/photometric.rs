//! The distribution in the photometric and spectral formats, with what a job states of luminaire and report.

use isolux_formats::distribution::Luminaire;
use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{Distribution, Format, eulumdat, ies, tm33};
use isolux_photometry::{IntensityDistribution, Symmetry};
use isolux_record::run::Run;
use serde_json::Value;

use super::file::{ResultFile, diameter_mm, file_name};
use crate::error::ReduceError;
use crate::finding;
use crate::{Quantity, Reduction};

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

/// What EULUMDAT says beside the light; `state` follows the distance.
pub fn header(state: &str, reduction: &Reduction, run: &Run) -> eulumdat::Header {
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

pub fn ldt(shown: &IntensityDistribution, header: &eulumdat::Header) -> Result<Vec<u8>, ReduceError> {
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
pub fn ldt_remark(reduction: &Reduction) -> String {
    let missing = &reduction.flux.missing;
    let Some(first) = missing
        .iter()
        .find(|phrase| phrase.starts_with("partial") || *phrase == finding::ACCEPTED)
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

pub fn ies(shown: &IntensityDistribution, reduction: &Reduction, run: &Run, program: &str) -> Vec<u8> {
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
    let stated = flux.rounded();
    match flux.u {
        Some(_) => format!(
            "flux {} lm, expanded uncertainty {} lm (k = 2)",
            stated.value, stated.expanded
        ),
        None => format!("flux {} lm, uncertainty not evaluated", stated.value),
    }
}

/// The distribution as TM-33-18, with the laboratory and the number of the report in fields of their own.
pub fn xml(shown: &IntensityDistribution, state: &str, reduction: &Reduction, run: &Run) -> Vec<u8> {
    tm33::write(&document(shown, state, reduction, run), tm33::Edition::E2018).bytes
}

/// The distribution as TM-33-23 with the spectra over angle; none without them.
pub fn xml_with_spectra(
    shown: &IntensityDistribution,
    state: &str,
    reduction: &Reduction,
    run: &Run,
) -> Option<Vec<u8>> {
    let found = reduction.over_angle.as_ref()?;
    let directions: Vec<_> = found
        .facts
        .directions
        .iter()
        .zip(&found.intensity)
        .map(|(of, spectrum)| ((of.c_deg, of.gamma_deg), spectrum))
        .collect();
    let spectra = tm33::Spectra {
        total: &found.total,
        directions: &directions,
    };
    Some(tm33::write_2023(&document(shown, state, reduction, run), Some(&spectra)).bytes)
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

pub fn spectral_files(reduction: &Reduction, run: &Run, program: &str) -> Vec<ResultFile> {
    let Some(spectral) = &reduction.spectral else {
        return Vec::new();
    };
    let mut file = SpectrumFile::new(&spectral.spectrum, Some("irradiance"), Some("W/(m2*nm)"));
    let what = format!("on the axis at {} mm", spectral.distance_mm);
    describe(&mut file, &what, run, program);
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

/// What a spectrum is, of which luminaire, by whom.
pub fn describe(file: &mut SpectrumFile, what: &str, run: &Run, program: &str) {
    let text = |value: String| Value::String(value);
    let name = run.header.luminaire.name.as_ref();
    let name = name.map_or_else(String::new, |name| format!("{name}, "));
    file.header
        .insert("Description".to_owned(), text(format!("{name}{what}")));
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
}

/// The spectrum on the axis as observations, so that a diagnosis compares it with another day's model.
pub fn observed_spectrum(reduction: &Reduction, run: &Run) -> Vec<ResultFile> {
    let Some(spectral) = &reduction.spectral else {
        return Vec::new();
    };
    let mut text = format!(
        "# The spectrum on the axis with its noise: `isolux diagnose MODEL {}` compares it with that of a model.\n\
         quantity = \"irradiance\"\nunit = \"W/m2/nm\"\ndistance_mm = {:?}\nc_deg = {:?}\ngamma_deg = 0.0\n",
        file_name(reduction, SPECTRUM),
        spectral.distance_mm,
        spectral.c_deg,
    );
    if let Some(instrument) = instrument(run) {
        text.push_str(&format!("instrument = {}\n", toml::Value::from(instrument)));
    }
    text.push_str("\n[u]\n");
    let shared = spectral.shared;
    for (key, value) in [
        ("gain_rel", shared.gain_rel),
        ("shape_rel", shared.shape_rel),
        ("wavelength_nm", shared.wavelength_nm),
    ] {
        if let Some(value) = value {
            text.push_str(&format!("{key} = {value:.6}\n"));
        }
    }
    let mut rows = String::from("index,kind,wavelength_nm,value,u\n");
    let spectrum = &spectral.spectrum;
    for ((nm, value), u) in spectrum
        .wavelength_nm()
        .iter()
        .zip(spectrum.value())
        .zip(&spectral.u_expected_w_m2_nm)
    {
        rows.push_str(&format!("0,lit,{nm},{value:.6e},{u:.3e}\n"));
    }
    [(SPECTRUM, text), ("spectrum.csv", rows)]
        .map(|(name, text)| ResultFile {
            name: file_name(reduction, name),
            bytes: text.into_bytes(),
        })
        .into()
}

const SPECTRUM: &str = "spectrum.toml";

/// The spectroradiometer of a run and its calibration: the same words whenever both are the same.
pub fn instrument(run: &Run) -> Option<String> {
    let device = run
        .header
        .device
        .iter()
        .find(|device| device.role == "spectroradiometer")?;
    let calibration = run.header.spectral.as_ref()?;
    let serial = device.serial.as_ref()?;
    let hash = calibration.sha256.get(..12).unwrap_or(&calibration.sha256);
    Some(format!("{} {serial}, calibration {hash}", device.model))
}
