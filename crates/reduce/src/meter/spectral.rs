//! Spectral mismatch of the lux meter: F* = (∫S·V / ∫S·s)·(∫S_A·s / ∫S_A·V) of the lamp's own spectra S and the head's
//! responsivity s (e-ILV 17-25-115, ISO/CIE 19476).
//!
//! Light mixes lumen by lumen between the directions of the spectra, and so does 1/F*.

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_photometry::HalfPlanes;
use isolux_record::Run;
use isolux_spectrum::Spectrum;
use isolux_spectrum::meter::f1_prime;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::head::{Fails, Head, Light, Lights, parts_rel};
use super::heads::{self, Spread};
use crate::bench::Bench;
use crate::correction::Correction;
use crate::error::ReduceError;
use crate::instrument::Chain;
use crate::known::Known;
use crate::spectral::on_axis_to;
use crate::{Options, Wanted};

/// Indices of the heads for which a budget without any says what they may cost: a good head and an ordinary one.
const ORDINARY: [f64; 2] = [0.03, 0.06];
/// The effect of a model that takes the mismatch out.
const EFFECT: &str = "spectral_mismatch";

/// The spectral mismatch of a run's lux meter as `budget.json` has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpectralMismatch {
    /// Whether readings were multiplied by it.
    pub corrected: bool,
    /// F* on the axis.
    pub f_star_on_axis: f64,
    /// Smallest and largest F* of the directions with a spectrum.
    pub f_star: [f64; 2],
    /// How many these are.
    pub directions: usize,
    /// f1′ of the head's responsivity.
    pub f1_prime_rel: Option<f64>,
    /// Relative standard uncertainties of F* by cause: `responsivity`, and of the lamp's spectra `calibration_shape`,
    /// `calibration_bow`, `wavelength` and `noise`.
    pub parts_rel: BTreeMap<Cow<'static, str>, f64>,
}

/// What the head's match to V(λ) does to the readings.
#[derive(Debug, Clone, Default)]
pub struct SpectralMatch {
    /// By what readings are multiplied; none: by nothing.
    field: Option<Field>,
    /// Relative standard uncertainty that all readings share.
    pub u_rel: f64,
    /// What no part says.
    pub missing: Vec<String>,
    /// What a person should know.
    pub note: Option<String>,
    /// F* where it is known.
    pub facts: Option<SpectralMismatch>,
}

/// 1/F* over the directions.
#[derive(Debug, Clone)]
struct Field {
    /// None: the same everywhere.
    half_planes: Option<HalfPlanes>,
    reciprocal: Vec<f64>,
    directions_deg: Vec<(f64, f64)>,
}

impl Field {
    fn f_star(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let Some(half_planes) = &self.half_planes else {
            return 1.0 / self.reciprocal[0];
        };
        let mut reciprocal = 0.0;
        half_planes.each_weight(c_deg, gamma_deg, |index, weight| {
            reciprocal += weight * self.reciprocal[index];
        });
        1.0 / reciprocal
    }
}

impl SpectralMatch {
    /// Of the readings of `run`; by a model that takes the mismatch out nothing is left of it.
    ///
    /// # Errors
    /// What makes counts no irradiance, where the station states the head's responsivity.
    pub fn of(run: &Run, options: &Options, bench: Option<&Bench>) -> Result<Self, ReduceError> {
        if bench.is_some_and(|bench| bench.takes_out(EFFECT)) {
            return Ok(Self::default());
        }
        let Some(curves) = &run.header.luxmeter else {
            let light = on_axis_to(Wanted::Values, run, options)
                .ok()
                .flatten()
                .map(|axis| axis.spectrum);
            return Ok(Self::without_curve(run.header.station.luxmeter().f1_prime_rel, light));
        };
        let of_light = Head::of(curves).and_then(|head| match Lights::of(run, options)? {
            Some(lights) => Self::by_curve(run, options, &head, &lights),
            None => Ok(Self::without_spectrum(&head)),
        });
        match of_light {
            Err(Fails::Mismatch(why)) => Ok(Self {
                missing: vec![format!("no spectral mismatch factor F* of the lux meter: {why}")],
                ..Self::default()
            }),
            Err(Fails::Reduce(error)) => Err(error),
            Ok(found) => Ok(found),
        }
    }

    /// By what a reading of the lamp's light towards (C, γ) is multiplied; γ may be signed.
    pub fn factor(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let Some(field) = &self.field else { return 1.0 };
        let (c_deg, gamma_deg) = crate::samples::unsigned(c_deg, gamma_deg);
        field.f_star(c_deg, gamma_deg.min(180.0))
    }

    /// The table of the effect that makes readings of the lamp's light again, as a model file has it: 1/F* by a
    /// straight line over γ, the nearest to all directions. None where nothing was corrected.
    pub fn effect(&self) -> Option<String> {
        let field = self.field.as_ref()?;
        let factor = 1.0 / field.f_star(0.0, 0.0);
        let (mut above, mut below) = (0.0, 0.0);
        for ((_, gamma_deg), reciprocal) in field.directions_deg.iter().zip(&field.reciprocal) {
            above += gamma_deg * (reciprocal / factor - 1.0);
            below += gamma_deg * gamma_deg;
        }
        let slope = if below > 0.0 { above / below } else { 0.0 };
        Some(format!(
            "name = \"{EFFECT}\"\nfactor = {factor:.6}\nslope_per_deg = {slope:.8}\n"
        ))
    }

    /// A head of which at most its index is known.
    fn without_curve(f1_prime_rel: Option<f64>, light: Option<Spectrum>) -> Self {
        let what = if light.is_some() { "this light" } else { "white LEDs" };
        let lights = light.map_or_else(heads::typical_lights, |light| vec![light]);
        let range = |spread: Spread| {
            format!(
                "{:+.1} % to {:+.1} %",
                100.0 / (1.0 + spread.off[1]) - 100.0,
                100.0 / (1.0 + spread.off[0]) - 100.0
            )
        };
        let begin = "the lux meter's spectral mismatch is not corrected: the station states no luxmeter.responsivity";
        let no_bound = "f1′ alone is no bound";
        match f1_prime_rel {
            Some(0.0) => Self::default(),
            Some(index) => {
                let spread = heads::spread(&lights, index);
                let note = format!(
                    "{begin}; heads of f1′ {:.1} % read {what} wrong by {}, and {HOLDS} {:.1} % (k = 1) for it; \
                     {no_bound}",
                    100.0 * index,
                    range(spread),
                    100.0 * spread.rms
                );
                Self {
                    u_rel: spread.rms,
                    note: Some(note),
                    ..Self::default()
                }
            }
            None => {
                let [good, ordinary] = ORDINARY.map(|index| range(heads::spread(&lights, index)));
                let [first, second] = ORDINARY.map(|index| 100.0 * index);
                let note = format!(
                    "{begin} and no luxmeter.f1_prime_rel; heads of f1′ {first} % read {what} wrong by {good}, of \
                     {second} % by {ordinary}, and {HOLDS} nothing of it beyond luxmeter.u_rel; {no_bound}"
                );
                Self {
                    note: Some(note),
                    ..Self::default()
                }
            }
        }
    }

    /// A head that is known, of a run without the spectrum of its lamp.
    fn without_spectrum(head: &Head) -> Self {
        let off = heads::typical_lights()
            .into_iter()
            .filter_map(|light| head.f_star(&light).ok());
        let largest = off.map(|f_star| (f_star - 1.0).abs()).fold(0.0, f64::max);
        let u_rel = largest / 3.0_f64.sqrt();
        Self {
            u_rel,
            note: Some(format!(
                "the lux meter's spectral mismatch is not corrected: the run has no spectrum of the lamp; its head \
                 reads white LEDs wrong by up to {:.1} %, and {HOLDS} {:.1} % (k = 1) for it",
                100.0 * largest,
                100.0 * u_rel
            )),
            ..Self::default()
        }
    }

    fn by_curve(run: &Run, options: &Options, head: &Head, lights: &Lights) -> Result<Self, Fails> {
        let of_each = |light: &Light| head.f_star(&light.spectrum);
        let f_star = lights.of.iter().map(of_each).collect::<Result<Vec<f64>, _>>()?;
        let known = Known::of(run, Chain::without(&options.without), lights.distance_mm);
        let parts_rel = parts_rel(head, lights, &f_star, &known)?;
        let field = Field {
            half_planes: lights.half_planes.clone(),
            reciprocal: f_star.iter().map(|f_star| 1.0 / f_star).collect(),
            directions_deg: lights.of.iter().map(|light| light.deg).collect(),
        };
        let low = f_star.iter().copied().fold(f64::INFINITY, f64::min);
        let high = f_star.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let corrected = !options.without.contains(&Correction::SpectralMismatch);
        let squares: f64 = parts_rel.values().map(|part| part * part).sum();
        let left_out = (low - 1.0).abs().max((high - 1.0).abs());
        let on_axis = field.f_star(0.0, 0.0);
        let note = corrected.then(|| {
            let where_from = if lights.half_planes.is_some() {
                format!("{low:.4} to {high:.4} over {} directions with a spectrum", f_star.len())
            } else {
                "the same for every direction, whose colour was not read".to_owned()
            };
            format!(
                "readings are corrected by the spectral mismatch factor F* of the lux meter's head: {on_axis:.4} on \
                 the axis, {where_from}"
            )
        });
        let mut missing = Vec::new();
        if corrected {
            missing.extend(known.colour.iter().cloned());
            missing.extend(head.states_no_u().then(|| NO_U.to_owned()));
        }
        Ok(Self {
            u_rel: if corrected {
                squares.sqrt()
            } else {
                left_out.hypot(squares.sqrt())
            },
            missing,
            note,
            facts: Some(SpectralMismatch {
                corrected,
                f_star_on_axis: on_axis,
                f_star: [low, high],
                directions: f_star.len(),
                f1_prime_rel: f1_prime(&head.responsivity),
                parts_rel,
            }),
            field: corrected.then_some(field),
        })
    }
}

/// How a note says what there is of it in the budget.
const HOLDS: &str = "the uncertainty holds";

/// What a budget lacks whose head has no uncertainty.
const NO_U: &str = "the file of luxmeter.responsivity has no column u_rel: uncertainty of the head's curve";

#[cfg(test)]
mod tests {
    use super::super::head::tests::{curves, white};
    use super::*;

    #[test]
    fn between_two_directions_light_mixes_lumen_by_lumen() {
        let Ok(head) = Head::of(&curves()) else {
            panic!("a head")
        };
        let of = |phosphor: f64| head.f_star(&white(phosphor)).unwrap();
        let directions_deg = vec![(0.0, 0.0), (0.0, 60.0)];
        let field = Field {
            half_planes: Some(HalfPlanes::new(&directions_deg).unwrap()),
            reciprocal: vec![1.0 / of(0.5), 1.0 / of(2.0)],
            directions_deg,
        };
        let (one, other) = (white(0.5), white(2.0));
        let mixed = one
            .value()
            .iter()
            .zip(other.value())
            .map(|(one, other)| 0.75 * one + 0.25 * other);
        let mixed = Spectrum::new(one.wavelength_nm().to_vec(), mixed.collect()).unwrap();
        let found = field.f_star(0.0, 15.0);
        assert!((found - head.f_star(&mixed).unwrap()).abs() < 1e-12, "{found}");
        assert_eq!(field.f_star(0.0, 90.0), 1.0 / field.reciprocal[1]);
        let matched = SpectralMatch {
            field: Some(field),
            ..SpectralMatch::default()
        };
        assert_eq!(matched.factor(180.0, -60.0), matched.factor(0.0, 60.0));
        let effect = matched.effect().unwrap();
        let slope: f64 = effect.rsplit_once("= ").unwrap().1.trim().parse().unwrap();
        let expected = (of(0.5) / of(2.0) - 1.0) / 60.0;
        assert!((slope - expected).abs() < 1e-7, "{effect} {expected}");
    }
}
