//! Colour over angle: the lux meter's dense distribution with the spectra of a few directions.
//!
//! Φ_λ = ∫ I_v(C, γ)·s_λ(C, γ)/K(s) dΩ with the luminous efficacy K of each spectrum, so that every spectrum
//! counts as the colour of its lumens and not by its strength. Between the directions that were read the spectra mix
//! lumen by lumen ([`HalfPlanes`]). Every number is computed again with one thing after the other moved by its standard
//! uncertainty (JCGM 100, 5.1.3, note 2).

mod blur;
mod chromaticity;
mod facts;
mod largest;
mod measured;
mod moved;
mod outcome;
mod weights;

use isolux_photometry::{HalfPlanes, HalfPlanesError, IntensityDistribution, Symmetry};
use isolux_record::{Run, apart_from_mm, seen_under_deg};
use isolux_spectrum::Spectrum;

pub use self::facts::{AverageColour, ColourOverAngle, DirectionColour, LargestDifference, TotalColour};
pub use self::measured::{LeftOut, Measured};

use self::measured::Direction;
use self::moved::Moved;
use self::outcome::Outcome;
use crate::budget::Common;
use crate::circle;
use crate::colour::{Colour, noise};
use crate::error::ReduceError;
use crate::instrument::{self, Chain};
use crate::known::Known;
use crate::quantity::Quantity;
use crate::{Options, partial::Partial};

/// Directions with less of the largest intensity do not count for Δu′v′ (IES LM-79-08, 12).
const LEAST_SHARE: f64 = 0.1;
/// More of the flux than this beyond the last spectra: the colour of the whole is not known.
const MOST_BEYOND: f64 = 0.02;
/// Fewer half-planes do not show how colour changes around C.
const LEAST_PLANES: usize = 4;

/// What the spectra of a run over angle say.
#[derive(Debug, Clone)]
pub struct OverAngle {
    /// Every number with its uncertainty.
    pub facts: ColourOverAngle,
    /// Total spectral flux in W/nm, at whole nanometres.
    pub total: Spectrum,
    /// Standard uncertainty of each of its values; none where something is missing.
    pub u_total_w_nm: Option<Vec<f64>>,
    /// Spectral radiant intensity in W/(sr·nm) of each of the directions of `facts`, in their order.
    pub intensity: Vec<Spectrum>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// What the distribution of the run gives.
pub struct Lamp<'a> {
    /// The distribution.
    pub distribution: &'a IntensityDistribution,
    /// What all its intensities share.
    pub common: &'a Common,
    /// Its flux.
    pub flux: &'a Quantity,
    /// The part of a scan that ended early.
    pub partial: Option<&'a Partial>,
}

/// Spectra of one lumen on their half-planes, and what each stands for.
struct Set {
    directions: Vec<Direction>,
    half_planes: HalfPlanes,
    directions_deg: Vec<(f64, f64)>,
    per_lumen: Vec<Spectrum>,
}

/// Colour over angle, or why there is none although spectra were read off the axis; none of a run without such spectra.
///
/// # Errors
/// [`ReduceError`] where counts make no irradiance at all.
pub fn of(run: &Run, options: &Options, lamp: &Lamp<'_>) -> Result<Option<Result<OverAngle, String>>, ReduceError> {
    let chain = Chain::without(&options.without);
    let Some(calibration) = &run.header.spectral else {
        return if run.spectra.is_empty() {
            Ok(None)
        } else {
            Err(ReduceError::NoCalibration)
        };
    };
    let Some(measured) = Measured::of(run, calibration, chain)? else {
        return Ok(None);
    };
    let why = |error: &dyn std::fmt::Display| Ok(Some(Err(format!("no colour over angle: {error}"))));
    if measured.directions.len() < 2 {
        let dark = measured.left_out.first();
        let because = dark.map_or_else(String::new, |first| {
            format!(
                ", the first at C {}° γ {}°: {}",
                first.c_deg, first.gamma_deg, first.reason
            )
        });
        return why(&format!(
            "{} of {} directions have a spectrum that shows colour{because}",
            measured.directions.len(),
            measured.directions.len() + measured.left_out.len()
        ));
    }
    let planned_deg: Vec<(f64, f64)> = (measured.directions.iter())
        .map(|direction| (direction.c_deg, direction.gamma_deg))
        .chain(measured.left_out.iter().map(|left| (left.c_deg, left.gamma_deg)))
        .collect();
    let planned = match HalfPlanes::new(&planned_deg) {
        Ok(planned) => planned,
        Err(error) => return why(&error),
    };
    let Measured {
        directions,
        left_out,
        distance_mm,
    } = measured;
    let set = match Set::new(directions) {
        Ok(set) => set,
        Err(error) => return why(&error),
    };
    let mut moved = Vec::new();
    for (part, calibration) in instrument::moved(calibration, chain) {
        let there = Measured::of(run, &calibration, chain)?.map_or_else(Vec::new, |there| there.directions);
        if there.len() == set.directions.len() {
            moved.push((part, there.iter().map(|of| of_one_lumen(&of.spectrum)).collect()));
        }
    }
    let known = Known::of(run, chain, distance_mm);
    let found = Found {
        run,
        lamp,
        set,
        planned,
        left_out,
        distance_mm,
        known,
        moved,
    };
    Ok(Some(found.over_angle()))
}

impl Set {
    fn new(directions: Vec<Direction>) -> Result<Self, HalfPlanesError> {
        let directions_deg: Vec<(f64, f64)> = directions.iter().map(|of| (of.c_deg, of.gamma_deg)).collect();
        let per_lumen = directions.iter().map(|of| of_one_lumen(&of.spectrum)).collect();
        Ok(Self {
            half_planes: HalfPlanes::new(&directions_deg)?,
            directions_deg,
            directions,
            per_lumen,
        })
    }
}

/// A spectrum scaled to one lumen (one lux, of an irradiance).
fn of_one_lumen(spectrum: &Spectrum) -> Spectrum {
    // One without light is none of a set; what changes its shape by parts in a hundred leaves it light.
    spectrum
        .scaled(spectrum.luminous_integral().recip())
        .unwrap_or_else(|_| spectrum.clone())
}

/// Σ weight·spectrum of spectra with the same wavelengths; none without any, or where the sum is no number.
fn sum<'a>(parts: impl IntoIterator<Item = (&'a Spectrum, f64)>) -> Option<Spectrum> {
    let mut parts = parts.into_iter();
    let (first, weight) = parts.next()?;
    let mut value: Vec<f64> = first.value().iter().map(|value| weight * value).collect();
    for (spectrum, weight) in parts {
        for (sum, part) in value.iter_mut().zip(spectrum.value()) {
            *sum += weight * part;
        }
    }
    Spectrum::new(first.wavelength_nm().to_vec(), value).ok()
}

/// The spectrum of one lumen at (C, γ).
fn mix(half_planes: &HalfPlanes, per_lumen: &[Spectrum], c_deg: f64, gamma_deg: f64) -> Option<Spectrum> {
    let mut parts = Vec::new();
    half_planes.each_weight(c_deg, gamma_deg, |index, weight| {
        parts.push((&per_lumen[index], weight));
    });
    sum(parts)
}

/// All that the numbers are made of.
struct Found<'a> {
    run: &'a Run,
    lamp: &'a Lamp<'a>,
    set: Set,
    planned: HalfPlanes,
    left_out: Vec<LeftOut>,
    distance_mm: f64,
    known: Known,
    /// Spectra of one lumen with a correction of the instrument moved by its uncertainty, by its part.
    moved: Vec<(&'static str, Vec<Spectrum>)>,
}

impl Found<'_> {
    fn over_angle(self) -> Result<OverAngle, String> {
        let none = || "no colour over angle: the spectra have no chromaticity".to_owned();
        let moved = Moved::of(&self).ok_or_else(none)?;
        let centre = &moved.centre;
        let missing = self.missing();
        let of_whole = self.missing_in_whole(&moved);
        let flux_lm = self.lamp.flux.value;
        let variance = self.variance_of_total(&centre.lumens);
        let u: Vec<f64> = variance.iter().map(|variance| variance.sqrt()).collect();
        let noise_of_total = noise(&centre.total, &u, &centre.whole);
        let parts = moved.of_whole.iter().map(|(name, other)| {
            let change = other.whole_from(centre);
            (*name, change.map(|change| change * moved::share(name)))
        });
        let whole = moved::largest_of_each(std::iter::once(("noise", noise_of_total)).chain(parts));
        let lacking: Vec<String> = missing.iter().chain(&of_whole).cloned().collect();
        let colour = Colour::from_parts(&centre.whole, &whole, &lacking);
        let efficacy = Self::efficacy(&moved, &variance).lacking(lacking.iter().cloned());
        let radiant_flux = self.lamp.flux.over(&efficacy, "W", "efficacy");
        let u_total = radiant_flux
            .u
            .map(|_| moved.u_of_total(&u, self.lamp.flux.u_of_parts / flux_lm));
        let (notes, blur_deg) = (self.notes(), self.blur_deg());
        let intensity = self.spectral_intensity();
        Ok(OverAngle {
            total: centre.total.clone(),
            u_total_w_nm: u_total,
            intensity,
            notes,
            facts: ColourOverAngle {
                total: TotalColour {
                    colour,
                    efficacy,
                    radiant_flux,
                },
                average_lm79: moved.average(&missing),
                delta_u_prime_v_prime: moved.largest(&self, &missing).ok_or_else(none)?,
                directions: moved.directions(&self.set, self.lamp.distribution, missing.is_empty()),
                left_out: self.left_out,
                distance_mm: self.distance_mm,
                blur_deg,
                missing: missing.into_iter().map(Into::into).collect(),
            },
        })
    }

    /// Variance of each value of the total that the noise of the spectra gives it.
    fn variance_of_total(&self, lumens: &[f64]) -> Vec<f64> {
        let mut variance = vec![0.0; self.set.per_lumen[0].value().len()];
        for (direction, lumens) in self.set.directions.iter().zip(lumens) {
            let scale = (lumens / direction.illuminance_lx).powi(2);
            for (sum, part) in variance.iter_mut().zip(&direction.variance) {
                *sum += scale * part;
            }
        }
        variance
    }

    /// Luminous efficacy of the whole light.
    fn efficacy(moved: &Moved, variance: &[f64]) -> Quantity {
        let ler = |outcome: &Outcome| outcome.total.luminous_integral() / outcome.total.integral();
        let (value, power) = (ler(&moved.centre), moved.centre.total.integral());
        // The lumens are those of the lux meter: noise of the watts alone counts, within 360–830 nm.
        let within = moved.centre.total.wavelength_nm().iter().zip(variance);
        let within = within.filter(|(nm, _)| (360.0..=830.0).contains(*nm));
        let noise = value / power * within.map(|(_, variance)| variance).sum::<f64>().sqrt();
        let changed = moved.of_whole.iter();
        let changed = changed.map(|(name, other)| (*name, [moved::share(name) * (ler(other) - value)]));
        let parts = moved::largest_of_each(std::iter::once(("noise", [noise])).chain(changed));
        Quantity::new(value, "lm/W", parts.into_iter().map(|(name, [part])| (name, part)))
    }

    /// What is missing in the uncertainty of every direction.
    fn missing(&self) -> Vec<String> {
        let station = &self.run.header.station;
        let mut missing = self.known.colour.clone();
        missing.extend(self.known.stray_missing.iter().cloned());
        if self.blur_deg().is_none() {
            missing.push("the station states no lamp.diameter_mm: what the spectroradiometer mixes".to_owned());
        }
        if station.bench().u_gamma_deg.is_none() {
            missing.push("the station states no bench.u_gamma_deg: uncertainty of the angle".to_owned());
        }
        missing
    }

    /// What is missing in the colour of the whole light besides.
    fn missing_in_whole(&self, moved: &Moved) -> Vec<String> {
        let mut missing: Vec<String> = self.lamp.partial.iter().map(|partial| partial.words()).collect();
        if self.set.half_planes.assumed() != Symmetry::None {
            missing.push("a symmetry of the colour is assumed, not measured".to_owned());
        } else if self.set.half_planes.planes().count() < LEAST_PLANES {
            missing.push("spectra in fewer than four half-planes: how the colour changes around C".to_owned());
        }
        let beyond = moved.beyond;
        if beyond > MOST_BEYOND {
            missing.push(format!("no spectra where {:.0} % of the flux is", 100.0 * beyond));
        }
        missing
    }

    /// Half the angle under which the spectroradiometer sees the lamp.
    fn blur_deg(&self) -> Option<f64> {
        let diameter_mm = self.run.header.station.lamp()?.diameter_mm?;
        Some(seen_under_deg(diameter_mm, self.distance_mm))
    }

    /// Step of γ of the spectra: the smallest between two of a half-plane.
    fn step_deg(&self) -> f64 {
        let steps = self
            .planned
            .planes()
            .flat_map(|(_, nodes)| nodes.windows(2).map(|pair| pair[1].0 - pair[0].0));
        steps.fold(f64::INFINITY, f64::min).min(90.0)
    }

    fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = circle::note(self.set.half_planes.assumed())
            .map(|note| format!("colour over angle: {note}"))
            .into_iter()
            .collect();
        let step_deg = self.step_deg();
        let diameter_mm = self.run.header.station.lamp().and_then(|lamp| lamp.diameter_mm);
        let seen_deg = self.blur_deg().filter(|blur_deg| 2.0 * blur_deg > step_deg);
        if let (Some(blur_deg), Some(diameter_mm)) = (seen_deg, diameter_mm) {
            notes.push(format!(
                "the spectroradiometer at {:.0} mm sees the lamp under ±{blur_deg:.1}° and mixes the colours of \
                 directions that are {step_deg}° apart: from {:.0} mm on it would not",
                self.distance_mm,
                apart_from_mm(diameter_mm, step_deg)
            ));
        }
        if let Some(first) = self.left_out.first() {
            notes.push(format!(
                "spectra of {} of {} directions are not used, the first at C {}° γ {}°: {}",
                self.left_out.len(),
                self.left_out.len() + self.set.directions.len(),
                first.c_deg,
                first.gamma_deg,
                first.reason
            ));
        }
        notes
    }

    /// I_λ = I_v·s_λ/K(s) of each direction, W/(sr·nm); in a direction that is darker than the lux meter shows, by
    /// the spectrum's own illuminance.
    fn spectral_intensity(&self) -> Vec<Spectrum> {
        let metres = self.distance_mm * 1e-3;
        let at = self.set.directions.iter().zip(&self.set.per_lumen);
        let of = |(direction, per_lumen): (&Direction, &Spectrum)| {
            let read_cd = self
                .lamp
                .distribution
                .intensity_cd_at(direction.c_deg, direction.gamma_deg);
            let own_cd = direction.illuminance_lx * metres * metres;
            let intensity_cd = if read_cd > 0.0 { read_cd } else { own_cd };
            per_lumen.scaled(intensity_cd).unwrap_or_else(|_| per_lumen.clone())
        };
        at.map(of).collect()
    }
}
