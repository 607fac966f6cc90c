//! What was corrected, and where the uncertainty comes from.

use crate::document::Section;
use isolux_record::spectra::{Made, SpectralCorrections};
use isolux_reduce::{Correction, MeterFactors, Quantity};
use isolux_units::digits::{K, significant};

use super::results::DayResults;
use isolux_reduce::no_uncertainty;

pub fn section(day_results: &DayResults) -> Section {
    let mut section = Section::new("Corrections and uncertainty");
    section.table(&["correction", "", "how much"], corrections(day_results));
    section.paragraph(
        "Each budget gives standard uncertainties (k = 1) in the unit of the number; parts add in squares, and the share is of that sum. \
         A number of which a part was neither measured nor stated has no uncertainty.",
    );
    let reduction = &day_results.reduction;
    let mut numbers = vec![
        ("Luminous flux", &reduction.flux),
        ("Largest luminous intensity", &reduction.i_max),
    ];
    if let Some(line) = &reduction.electrical {
        numbers.extend([
            ("Active power", &line.power),
            ("Luminous efficacy", &line.luminous_efficacy),
        ]);
    }
    if let Some(spectral) = &reduction.spectral {
        numbers.extend(
            spectral
                .colour
                .cct
                .as_ref()
                .map(|cct| ("Correlated colour temperature", cct)),
        );
        numbers.push(("Luminous efficacy of radiation", &spectral.ler));
    }
    for (name, quantity) in numbers {
        budget(&mut section, name, quantity);
    }
    section
}

fn budget(section: &mut Section, name: &str, quantity: &Quantity) {
    section.subheading(format!("{name}: {}", value_words(quantity)));
    let total = quantity.u_of_parts * quantity.u_of_parts;
    if !total.is_finite() {
        section.paragraph(
            "No budget: one of its parts is beyond the range of numbers, by times or uncertainties of the record that no bench has.",
        );
        return;
    }
    let mut parts: Vec<(&str, f64)> = quantity.parts.iter().map(|(name, u)| (name.as_ref(), *u)).collect();
    parts.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Below this nothing of a part is seen in the sum, and its digits are those of the arithmetic.
    let least = 1e-4 * quantity.u_of_parts;
    let row = |name: String, u: f64| {
        let digits = if u < least {
            format!("< {}", significant(least, 1))
        } else {
            significant(u, 2)
        };
        let share = if total > 0.0 { 100.0 * u * u / total } else { 0.0 };
        vec![name, digits, percent(u / quantity.value.abs()), format!("{share:.1} %")]
    };
    let mut rows: Vec<Vec<String>> = parts
        .into_iter()
        .map(|(name, u)| row(source(name).to_owned(), u))
        .collect();
    match quantity.u {
        Some(u) => {
            rows.push(row("combined standard uncertainty u, k = 1".to_owned(), u));
            rows.push(vec![
                "expanded uncertainty U, k = 2".to_owned(),
                significant(K * u, 2),
                percent(K * u / quantity.value.abs()),
                String::new(),
            ]);
        }
        None => rows.push(row(
            "of the known parts alone, no uncertainty of the number".to_owned(),
            quantity.u_of_parts,
        )),
    }
    section.numbers(
        vec![
            "source".to_owned(),
            format!("u in {}", quantity.unit),
            "relative".to_owned(),
            "share".to_owned(),
        ],
        rows,
    );
    if !quantity.missing.is_empty() {
        section.paragraph(format!("Missing: {}.", quantity.missing.join("; ")));
    }
}

/// A share in per cent, to a thousandth; one that is no share in few digits.
fn percent(share: f64) -> String {
    if share < 1e4 {
        format!("{:.3} %", 100.0 * share)
    } else {
        format!("{:.1e} %", 100.0 * share)
    }
}

fn value_words(quantity: &Quantity) -> String {
    match quantity.u {
        Some(_) => quantity.stated(),
        None => format!(
            "{} {}, {}",
            quantity.rounded().value,
            quantity.unit,
            no_uncertainty(&quantity.missing)
        ),
    }
}

/// The part of a budget in the words of its reader.
fn source(part: &str) -> &str {
    match part {
        "calibration" => "calibration of the meter",
        "calibration_shape" => "spectral shape of the calibration, tilt",
        "calibration_bow" => "spectral shape of the calibration, bow",
        "angle" => "γ: zero of the axis and mounting of the luminaire",
        "dark_digit" => "rounding of the readings without light",
        "dark_noise" => "scatter of the readings without light",
        "digit" => "rounding of the display",
        "noise" => "scatter of the readings",
        "distance" => "photometric distance",
        "drift" => "drift of lamp and meter",
        "interpolation" => "interpolation between the directions",
        "interpolation_over_c" => "interpolation over C between chosen half-planes",
        "smoothing" => "smoothing within rounding and scatter",
        "offset" => "offset that was not measured",
        "ambient" => "ambient light that was not measured",
        "stray" => "stray light that was not measured",
        "near_field" | "near_field_at_sensor" => "limited photometric distance",
        "wavelength" => "wavelength scale",
        "spectral_mismatch" => "spectral mismatch of the lux meter",
        "linearity" => "linearity of the lux meter",
        "temperature" => "temperature of the lux meter",
        "cosine" => "directional response of the lux meter",
        "fatigue" => "fatigue of the lux meter",
        "bandpass" => "bandpass of the spectroradiometer",
        "scatter" => "light scattered inside the spectroradiometer",
        "spectral_linearity" | "spectral_linearity_bend" => "linearity of the spectroradiometer",
        "efficacy" => "luminous efficacy of radiation",
        "flux" => "luminous flux",
        "power" => "active power",
        other => other,
    }
}

/// Whether the station names a correction of the spectroradiometer, and how much it is; of others that they are on.
fn of_instrument(found: Option<&SpectralCorrections>, correction: Correction) -> (bool, String) {
    let found = found.cloned().unwrap_or_default();
    let from = |words: String, made: &Made| Some(format!("{words}, {} of {}", made.with, made.day));
    let (key, how_much) = match correction {
        Correction::Wavelengths => (
            "wavelengths",
            found.wavelengths.and_then(|scale| {
                let offset_nm = significant(scale.true_nm(550.0) - 550.0, 2);
                from(format!("true less stated {offset_nm} nm at 550 nm"), &scale.made)
            }),
        ),
        Correction::Bandpass => (
            "wavelengths",
            found
                .wavelengths
                .and_then(|scale| from(format!("{} nm", significant(scale.fwhm_nm, 3)), &scale.made)),
        ),
        Correction::Scatter => (
            "scatter",
            found.scatter.and_then(|scatter| {
                let most = scatter.share_rel.iter().flatten().copied().fold(0.0, f64::max);
                from(format!("{} of the light", percent(most)), &scatter.made)
            }),
        ),
        Correction::SpectralLinearity => (
            "linearity",
            found.linearity.and_then(|linearity| {
                let half = percent(linearity.divisor(0.5) - 1.0);
                from(format!("{half} at half of full scale"), &linearity.made)
            }),
        ),
        _ => return (true, String::new()),
    };
    let named = how_much.is_some();
    (
        named,
        how_much.unwrap_or_else(|| format!("not corrected: the station names no `{key}`")),
    )
}

fn corrections(day_results: &DayResults) -> Vec<Vec<String>> {
    let reduction = &day_results.reduction;
    let background = reduction.background.parts_lx(0.0);
    let level = |place: usize| match background[place] {
        Some(lx) => format!("{} lx on the axis", significant(lx, 2)),
        None => "not measured by this run".to_owned(),
    };
    let spectrum = if reduction.spectral.is_some() {
        "the dark spectrum of the same integration time".to_owned()
    } else {
        "no spectrum".to_owned()
    };
    let smoothing = match &reduction.grid.smoothed {
        Some((_, facts)) => format!(
            "rms {} cd, at most {} cd",
            significant(facts.rms_cd, 2),
            significant(facts.max_cd, 2)
        ),
        None => "not needed".to_owned(),
    };
    let mismatch = reduction.luxmeter.spectral_mismatch.as_ref();
    let factors = |found: Option<MeterFactors>| {
        found.map_or_else(
            || "not corrected".to_owned(),
            |found| format!("× {:.5} to {:.5}", found.factor[0], found.factor[1]),
        )
    };
    let meter = &reduction.luxmeter;
    let found = reduction.spectral.as_ref().map(|spectral| &spectral.corrections);
    let of_instrument = |correction: Correction| of_instrument(found, correction);
    let words = |correction: Correction| -> (&str, String) {
        match correction {
            Correction::Dark => ("offset of the meter", level(0)),
            Correction::Ambient => ("ambient light", level(1)),
            Correction::Stray => ("stray light of the lamp", level(2)),
            Correction::SpectralMismatch => (
                "spectral mismatch of the lux meter",
                mismatch.map_or_else(
                    || "not corrected: no responsivity of the head, or no spectrum".to_owned(),
                    |found| format!("F* {:.4} on the axis", found.f_star_on_axis),
                ),
            ),
            Correction::Linearity => ("linearity of the lux meter", factors(meter.linearity)),
            Correction::Temperature => ("temperature of the lux meter", factors(meter.temperature)),
            Correction::Cosine => ("directional response of the lux meter", factors(meter.cosine)),
            Correction::Fatigue => ("fatigue of the lux meter", factors(meter.fatigue)),
            Correction::InverseSquare => (
                "distance of each reading, I = E·d²",
                format!("{} m", reduction.distance_mm * 1e-3),
            ),
            Correction::Drift => ("drift of lamp and meter", "see Stability".to_owned()),
            Correction::SpectralDark => ("dark signal of the spectroradiometer", spectrum.clone()),
            Correction::Wavelengths => ("wavelength scale of the spectroradiometer", of_instrument(correction).1),
            Correction::Bandpass => ("bandpass of the spectroradiometer", of_instrument(correction).1),
            Correction::Scatter => (
                "light scattered inside the spectroradiometer",
                of_instrument(correction).1,
            ),
            Correction::SpectralLinearity => ("linearity of the spectroradiometer", of_instrument(correction).1),
            Correction::Smoothing => ("smoothing within rounding and scatter", smoothing.clone()),
        }
    };
    // That the spectral mismatch of a meter is not corrected concerns every lamp.
    let listed = |correction: &Correction| meter.has(*correction) || *correction == Correction::SpectralMismatch;
    let mut rows: Vec<Vec<String>> = Correction::ALL
        .into_iter()
        .filter(listed)
        .map(|correction| {
            let (name, how_much) = words(correction);
            let off = !meter.has(correction) || reduction.without.contains(&correction) || !of_instrument(correction).0;
            vec![name.to_owned(), if off { "off" } else { "on" }.to_owned(), how_much]
        })
        .collect();
    if !reduction.removed_effects.is_empty() {
        rows.push(vec![
            "effects of the bench, by a model".to_owned(),
            "on".to_owned(),
            reduction.removed_effects.join(", ").replace('_', " "),
        ]);
    }
    rows
}
