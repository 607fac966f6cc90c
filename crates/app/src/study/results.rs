//! The results of a run with corrections switched on and off: its readings are reduced again, nothing is written.

use std::collections::BTreeSet;

use camino::Utf8Path;

use isolux_reduce::{Correction, Options, Quantity, Reduction, reduce};
use isolux_report::plots::{
    IsoluxOptions, PolarOptions, SpectrumOptions, cartesian, isocandela, isolux, polar, spectrum, zones,
};
use isolux_report::viewer::Solid;
use serde::Serialize;

use super::{Figure, StatedNumber};
use crate::Failure;
use crate::run::record;
use crate::run::reduce::{kept_model, options_of};

/// Step of the zones of flux, in degrees.
const ZONE_DEG: f64 = 10.0;

/// What a run says with these corrections.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Results {
    /// The headline numbers.
    pub numbers: Vec<StatedNumber>,
    /// Every correction.
    pub corrections: Vec<Switch>,
    /// Whether the run ended before its plan did.
    pub partial: bool,
    /// What a person should know.
    pub notes: Vec<String>,
    /// The report's pictures of the distribution and the spectrum.
    pub figures: Vec<Figure>,
    /// The distribution.
    pub solid: Solid,
}

/// A correction that can be left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Switch {
    /// Its word on the command line.
    pub word: &'static str,
    /// What it takes out.
    pub what: &'static str,
    /// Whether it was applied here.
    pub on: bool,
    /// Whether it was applied in the results that lie in the folder.
    pub on_in_report: bool,
}

const fn what(correction: Correction) -> &'static str {
    match correction {
        Correction::Dark => "offset of the lux meter, from capped readings",
        Correction::Ambient => "light of the room, from readings with the lamp off",
        Correction::Stray => "stray light of the lamp, from baffled readings",
        Correction::SpectralMismatch => "spectral mismatch of the lux meter, by F* of the lamp's spectra",
        Correction::Linearity => "departure of the lux meter from proportion to the light",
        Correction::Temperature => "temperature of the lux meter, by that of the room",
        Correction::Cosine => "response of the lux meter to light along a slant, by the size of the lamp",
        Correction::Fatigue => "what light took from the lux meter's responsivity",
        Correction::InverseSquare => "each reading's own distance; off: the station's",
        Correction::Drift => "drift of lamp and meter, from the reference point",
        Correction::SpectralDark => "dark spectrum",
        Correction::Wavelengths => "wavelength scale of the spectroradiometer, from a line lamp",
        Correction::Bandpass => "bandpass of the spectroradiometer, from a line lamp",
        Correction::Scatter => "light scattered inside the spectroradiometer, from a long-pass filter",
        Correction::SpectralLinearity => "linearity of the spectroradiometer, from integration times",
        Correction::Smoothing => "smoothing within rounding and scatter; off: the raw distribution",
    }
}

/// The results of the run directory `run` without the corrections of these names; `None`: as they lie in its folder, or
/// with all of them.
///
/// # Errors
/// Bad input (exit 2) for what is no run, an unknown correction, or a record that gives no distribution; "no" (exit 1)
/// for one whose drift is beyond the limits of its plan.
pub fn results(run: &Utf8Path, without: Option<&[String]>) -> Result<Results, Failure> {
    let record = record::read(run)?;
    // As they were made; with every correction where there are none.
    let made = options_of(&run.join("results/budget.json"))?.unwrap_or_default();
    let requested = match without {
        Some(words) => words.iter().map(|word| word.parse::<Correction>()).collect(),
        None => Ok(made.without.clone()),
    };
    let requested: BTreeSet<Correction> = requested.map_err(Failure::bad_input)?;
    let model = kept_model(&run.join("results"))?;
    let reduced = |without: &BTreeSet<Correction>| {
        let options = Options {
            without: without.clone(),
            accept_drift: made.accept_drift.clone(),
        };
        reduce(&record, &options, model.clone()).map_err(|error| Failure::bad_input(format!("{run}: {error}")))
    };
    let now = reduced(&requested)?;
    let reported = (requested != made.without)
        .then(|| reduced(&made.without))
        .transpose()?
        .map(|reduction| numbers(&reduction));
    let numbers = numbers(&now).into_iter().map(|(name, value)| {
        let before = reported.iter().flatten().find(|(other, _)| *other == name);
        let reported = before
            .map(|(_, before)| before.clone())
            .filter(|before| *before != value);
        StatedNumber { name, value, reported }
    });
    Ok(Results {
        numbers: numbers.collect(),
        corrections: Correction::ALL
            .into_iter()
            .filter(|correction| now.luxmeter.has(*correction))
            .map(|correction| Switch {
                word: correction.as_str(),
                what: what(correction),
                on: !requested.contains(&correction),
                on_in_report: !made.without.contains(&correction),
            })
            .collect(),
        partial: now.partial.is_some(),
        notes: now.notes.clone(),
        figures: figures(&now),
        solid: solid(&now),
    })
}

/// Name and statement of each headline number.
fn numbers(reduction: &Reduction) -> Vec<(String, String)> {
    let (c_deg, gamma_deg) = reduction.i_max_deg;
    let at = format!("largest intensity, C {c_deg}° γ {gamma_deg}°");
    let mut numbers: Vec<(String, &Quantity)> =
        vec![("luminous flux".to_owned(), &reduction.flux), (at, &reduction.i_max)];
    let mut add = |name: &str, quantity| numbers.push((name.to_owned(), quantity));
    if let Some(electrical) = &reduction.electrical {
        add("power", &electrical.power);
        add("luminous efficacy", &electrical.luminous_efficacy);
    }
    if let Some(spectral) = &reduction.spectral {
        add("efficacy of radiation", &spectral.ler);
        if let Some(cct) = &spectral.colour.cct {
            add("CCT", cct);
        }
    }
    if let Some(found) = &reduction.over_angle {
        if let Some(cct) = &found.facts.total.colour.cct {
            add("CCT of the whole light", cct);
        }
        add("Δu′v′ over angle", &found.facts.delta_u_prime_v_prime.value);
    }
    let (side_mm, distance_mm) = isolux_reduce::SENSOR_MM;
    let on_sensor = format!("on a sensor of {side_mm} mm at {distance_mm} mm");
    match &reduction.sensor_irradiance {
        Some(irradiance) => add(&on_sensor, irradiance),
        None => add(&on_sensor, &reduction.sensor_illuminance),
    }
    numbers
        .into_iter()
        .map(|(name, quantity)| (name, quantity.stated()))
        .collect()
}

fn figures(reduction: &Reduction) -> Vec<Figure> {
    let shown = &reduction.grid.distribution;
    let options = PolarOptions {
        title: String::new(),
        per_lamp_flux_lm: Some(reduction.flux.value),
        doubtful_cd: None,
    };
    let mut figures = vec![
        Figure::new("Polar diagram", polar(shown, &options)),
        Figure::new("Intensity over γ", cartesian(shown, &options)),
        Figure::new("Isocandela diagram", isocandela(shown, &options)),
        Figure::new(
            "Illuminance on a plane at 1 m",
            isolux(shown, &IsoluxOptions::at_one_metre(shown, "")),
        ),
        Figure::new("Zonal luminous flux", zones(&shown.zonal_flux_lm(ZONE_DEG), ZONE_DEG)),
    ];
    if let Some(spectral) = &reduction.spectral {
        let options = SpectrumOptions {
            title: String::new(),
            value_label: format!("spectral irradiance at {} mm in W/(m²·nm)", spectral.distance_mm),
        };
        figures.push(Figure::new("Spectrum", spectrum(&spectral.spectrum, &options)));
    }
    let over_angle = isolux_report::day::colour_figures(reduction);
    figures.extend(
        over_angle
            .into_iter()
            .map(|figure| Figure::new(figure.caption.trim_end_matches('.'), figure.svg)),
    );
    figures
}

fn solid(reduction: &Reduction) -> Solid {
    let shown = &reduction.grid.distribution;
    let planes = 0..shown.c_deg().len();
    Solid {
        c_deg: shown.c_deg().to_vec(),
        gamma_deg: shown.gamma_deg().to_vec(),
        intensity_cd: planes.flat_map(|plane| shown.row(plane).to_vec()).collect(),
    }
}
