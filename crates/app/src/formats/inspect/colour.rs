//! The colour of a lamp over angle: of a model with spectra over angle, or of TM-33-23 with them.

use camino::Utf8Path;
use isolux_formats::{Content, Finding, Format, ReadOptions, tm33};
use isolux_model::{ColourOverAngle, Model};
use isolux_photometry::IntensityDistribution;
use isolux_spectrum::{Spectrum, cie, quantities};

use super::coloured::{AngularColour, ColourOfDirection, ColouredQuantities};
use super::inspection::{Inspection, Quantities};
use crate::files;

/// What is said of a model file: its distribution, and its spectra over angle where it has them.
pub(super) fn of_model(path: &Utf8Path, options: ReadOptions) -> Vec<Inspection> {
    let model = match Model::load(path) {
        Ok(model) => model,
        Err(error) => return vec![Inspection::unreadable(path, Finding::error("model", error.to_string()))],
    };
    let beside = path.parent().unwrap_or(Utf8Path::new(""));
    let named = distribution_of(path).map(|name| beside.join(name));
    let mut all = named.map_or_else(Vec::new, |file| super::file(&file, options));
    for inspection in &mut all {
        inspection.file = format!("{path}: {}", inspection.file);
        if let Some(colour) = model.colour() {
            inspection.add_colour(colour);
        }
    }
    all
}

/// The file that a model names as its distribution.
fn distribution_of(path: &Utf8Path) -> Option<String> {
    let text = String::from_utf8(files::read(path).ok()?).ok()?;
    let table: toml::Table = toml::from_str(&text).ok()?;
    Some(table.get("luminaire")?.get("distribution")?.as_str()?.to_owned())
}

/// Whether a file is a model, by its name and its first key.
pub(super) fn is_model(path: &Utf8Path) -> bool {
    path.extension() == Some("toml")
        && files::read(path).is_ok_and(|bytes| String::from_utf8_lossy(&bytes).contains("\"isolux-model/1\""))
}

/// Adds what the spectra of a TM-33-23 document say.
pub(super) fn of_tm33(path: &Utf8Path, inspection: &mut Inspection) {
    if inspection.format != Some(Format::TM33) || !inspection.readable {
        return;
    }
    let Ok(bytes) = files::read(path) else { return };
    match tm33::spectra(&bytes) {
        Ok(spectra) if spectra.is_empty() => {}
        Ok(spectra) => match ColourOverAngle::new(spectra) {
            Ok(colour) => inspection.add_colour(&colour),
            Err(error) => {
                let finding = Finding::warning("tm33-spectrum", error.to_string());
                inspection.findings.push(finding.assumed("no spectra over angle"));
            }
        },
        Err(finding) => inspection.findings.push(finding),
    }
}

impl Inspection {
    fn add_colour(&mut self, colour: &ColourOverAngle) {
        let (Quantities::Distribution(of), Some(Content::Distribution(distribution))) =
            (&self.quantities, &self.content)
        else {
            return;
        };
        if let Some(colour_over_angle) = angular(colour, &distribution.intensity) {
            let of = (**of).clone();
            self.quantities = Quantities::Coloured(Box::new(ColouredQuantities { of, colour_over_angle }));
        }
    }
}

/// None where the light has no chromaticity.
fn angular(colour: &ColourOverAngle, intensity: &IntensityDistribution) -> Option<AngularColour> {
    let mut total = [0.0; cie::V_LAMBDA.len()];
    let weights = intensity.flux_weights_sr();
    let gammas = intensity.gamma_deg();
    for (plane, &c_deg) in intensity.c_deg().iter().enumerate() {
        for (place, &gamma_deg) in gammas.iter().enumerate() {
            let lumens = weights[plane * gammas.len() + place] * intensity.row(plane)[place];
            let of = colour.at(c_deg, gamma_deg);
            total.iter_mut().zip(of).for_each(|(sum, value)| *sum += lumens * value);
        }
    }
    let nm = (0..total.len()).map(|k| 360.0 + k as f64).collect();
    let total = of_direction(None, &Spectrum::new(nm, total.to_vec()).ok()?)?;
    let places = colour.directions_deg().iter().zip(colour.spectra());
    let directions: Vec<_> = places
        .map(|(at, spectrum)| of_direction(Some(*at), spectrum))
        .collect::<Option<_>>()?;
    let least_cd = 0.1 * intensity.peak().intensity_cd;
    let away = |of: &ColourOfDirection| (of.u_prime - total.u_prime).hypot(of.v_prime - total.v_prime);
    let bright = colour.directions_deg().iter().zip(&directions);
    let delta_u_prime_v_prime = bright
        .filter(|((c_deg, gamma_deg), _)| intensity.intensity_cd_at(*c_deg, *gamma_deg) >= least_cd)
        .map(|(_, of)| away(of))
        .fold(0.0, f64::max);
    Some(AngularColour {
        total,
        delta_u_prime_v_prime,
        directions,
    })
}

fn of_direction(at: Option<(f64, f64)>, spectrum: &Spectrum) -> Option<ColourOfDirection> {
    let of = quantities(spectrum);
    Some(ColourOfDirection {
        c_deg: at.map(|at| at.0),
        gamma_deg: at.map(|at| at.1),
        u_prime: of.u_prime?,
        v_prime: of.v_prime?,
        cct_k: of.cct_k,
    })
}
