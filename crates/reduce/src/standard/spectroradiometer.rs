//! Spectral irradiance of one linear count per second, from a lamp with a certificate.

use isolux_record::{Run, Standard};
use isolux_spectrum::{Spectrum, Tristimulus};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::conditions::{Calibrated, Conditions};
use super::covariance::{Component, unknown_correlation};
use super::error::CalibrationError;
use super::interpolation::{Interpolation, tilt};
use super::procedure::{Procedure, Rates};
use super::{STRAY_HALF_WIDTH, TEMPERATURE_OVER_CURRENT};
use crate::instrument::{self, Chain};

/// Pixels whose noise is more than this share of their light are left out.
const MOST_NOISE_REL: f64 = 0.02;
/// As many pixels at least.
const LEAST_PIXELS: usize = 50;
/// Colour quantities change by this share of a value in a numerical derivative.
const STEP: f64 = 1e-4;

/// The factors of a spectroradiometer with their covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpectralFactors {
    /// Under what they were found.
    pub conditions: Conditions,
    /// True wavelengths of the pixels: corrected where the station names its wavelength scale.
    pub wavelength_nm: Vec<f64>,
    /// Those that the instrument states, by which a table of factors knows the pixels.
    pub stated_nm: Vec<f64>,
    /// Corrections of the instrument by which the standard's spectra were corrected, by the hash of their records.
    pub corrected_by: String,
    /// Spectral irradiance of one linear count per second, W/(m² nm).
    pub factor_w_m2_nm: Vec<f64>,
    /// Spectral irradiance of the standard that they were found with, W/(m² nm).
    pub irradiance_w_m2_nm: Vec<f64>,
    /// Relative uncertainties by cause.
    pub components: Vec<Component>,
    /// Integration time of the brightest spectra.
    pub integration_s: f64,
    /// Largest relative difference of rates at other integration times.
    pub nonlinearity_rel: f64,
    /// Light behind the baffle over all light.
    pub stray_rel: f64,
    /// Light of the last reading over that of the first, less 1.
    pub change_rel: f64,
    /// Temperature of the Wien radiator that the standard is like.
    pub temperature_k: f64,
    /// Against the factors that the station had.
    pub drift: Drift,
    /// Relative standard uncertainty of the illuminance of the standard, measured with them.
    pub u_rel: f64,
    /// Relative standard uncertainty of their ratio at 700 nm and 400 nm, or at the ends of the range within.
    pub u_shape_rel: f64,
    /// Colour of the standard, measured with them.
    pub colour: Option<Colour>,
}

/// New factors against those that the station had while the standard was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// New over former, less 1, at each wavelength; none where there was no factor.
    pub relative: Vec<Option<f64>>,
    /// Illuminance of the standard by the new ones over that by the former, less 1; none without former ones over all
    /// of V(λ).
    pub illuminance_rel: Option<f64>,
    /// Relative standard uncertainty that the station states of the former ones.
    pub u_former_rel: Option<f64>,
}

/// Chromaticity (CIE 1931) and correlated colour temperature with standard uncertainties (k = 1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Colour {
    /// x and its uncertainty.
    pub x: [f64; 2],
    /// y and its uncertainty.
    pub y: [f64; 2],
    /// Correlated colour temperature and its uncertainty, K.
    pub cct_k: Option<[f64; 2]>,
}

/// The factors that a run with a standard lamp gives.
///
/// # Errors
/// [`CalibrationError`]: what the certificate does not cover, and readings that are saturated, not linear or unsteady.
pub fn spectroradiometer(run: &Run, standard: &Standard) -> Result<SpectralFactors, CalibrationError> {
    let (certified, rows) = standard
        .spectral()
        .ok_or(CalibrationError::NotCertified("spectral irradiance"))?;
    let station = run.header.station.spectroradiometer();
    let station = station.ok_or(CalibrationError::NoSpectroradiometer)?;
    let (conditions, stated) = Conditions::of(Calibrated::Spectroradiometer, run, standard, station.distance_mm)?;
    let procedure = Procedure::of(run)?;
    let (light, stray) = procedure.light_and_stray()?;
    let change_rel = procedure.change_rel()?;
    let limit_rel = run.header.plan.limits().reference_rel();
    if change_rel.abs() > limit_rel {
        return Err(CalibrationError::Unsteady { change_rel, limit_rel });
    }
    let nonlinearity_rel = procedure.nonlinearity_rel(&light, change_rel)?;
    let pixels = &procedure.brightest[0].pixels;
    // Everything that is looked up over wavelength is at the true one.
    let true_nm = |place: usize| procedure.true_nm(pixels[place].wavelength_nm);
    let within = rows[0].wavelength_nm..=rows[rows.len() - 1].wavelength_nm;
    let usable = |place: usize| {
        let net = light.per_s[place] - stray.per_s[place];
        let noise = light.u_per_s[place].hypot(stray.u_per_s[place]);
        within.contains(&true_nm(place)) && net > 0.0 && noise < MOST_NOISE_REL * net
    };
    let range = around_the_peak(&light, usable);
    if range.len() < LEAST_PIXELS {
        return Err(CalibrationError::Dark(range.len()));
    }
    let wavelength_nm: Vec<f64> = range.clone().map(true_nm).collect();
    let (first_nm, last_nm) = (wavelength_nm[0], wavelength_nm[wavelength_nm.len() - 1]);
    let curve = Interpolation::of(rows, first_nm, last_nm)?;
    let closer = (conditions.certified_distance_mm / conditions.distance_mm).powi(2);
    let irradiance_w_m2_nm: Vec<f64> = wavelength_nm.iter().map(|nm| closer * curve.at_nm(*nm)).collect();
    let net: Vec<f64> = range
        .clone()
        .map(|place| light.per_s[place] - stray.per_s[place])
        .collect();
    let factor_w_m2_nm: Vec<f64> = irradiance_w_m2_nm.iter().zip(&net).map(|(e, net)| e / net).collect();

    let temperature_k = curve.temperature_k();
    let tilted = |u_rel: f64| -> Vec<f64> {
        wavelength_nm
            .iter()
            .map(|nm| u_rel * tilt(*nm, temperature_k))
            .collect()
    };
    let even = |u_rel: f64| vec![u_rel; wavelength_nm.len()];
    let per_pixel = |of: &dyn Fn(usize, f64) -> f64| -> Vec<f64> {
        range.clone().zip(&net).map(|(place, net)| of(place, *net)).collect()
    };
    let scale = even(certified.u_scale_rel);
    let of_scale = tilted(certified.u_temperature_rel);
    let rest: Vec<f64> = (wavelength_nm.iter().zip(&of_scale))
        .map(|(nm, tilt)| {
            let whole = u_certified(rows, *nm);
            (whole * whole - certified.u_scale_rel.powi(2) - tilt * tilt)
                .max(0.0)
                .sqrt()
        })
        .collect();
    let mut certificate = Component::shared("certificate", scale);
    certificate.correlated_rel.push(of_scale);
    certificate
        .correlated_rel
        .extend(unknown_correlation(&wavelength_nm, &rest));
    let unknown = |name: &str, u_rel: f64| Component {
        name: name.to_owned(),
        correlated_rel: unknown_correlation(&wavelength_nm, &even(u_rel)),
        independent_rel: Vec::new(),
    };
    let slope = |nm: f64| (curve.at_nm(nm + 0.5) - curve.at_nm(nm - 0.5)) / curve.at_nm(nm);
    let third = 3.0f64.sqrt();
    let mut components = vec![
        certificate,
        Component::shared("current", tilted(TEMPERATURE_OVER_CURRENT * conditions.u_current_rel)),
        Component::shared("distance", even(2.0 * stated.u_distance_mm / conditions.distance_mm)),
        Component::shared("alignment", even(stated.alignment_rel)),
        unknown("interpolation", curve.residual_rel),
        Component::shared(
            "wavelength",
            wavelength_nm
                .iter()
                .map(|nm| stated.u_wavelength_nm * slope(*nm))
                .collect(),
        ),
        unknown("linearity", nonlinearity_rel / third),
        Component::shared(
            "stray",
            per_pixel(&|place, net| STRAY_HALF_WIDTH / third * stray.per_s[place] / net),
        ),
        Component::shared("drift", even(change_rel.abs() / 12.0f64.sqrt())),
        Component::independent(
            "noise",
            per_pixel(&|place, net| light.u_per_s[place].hypot(stray.u_per_s[place]) / net),
        ),
    ];
    // What is uncertain of the corrections of the instrument, in the light of this standard.
    for (part, moved) in instrument::moved(procedure.calibration, Chain::ALL) {
        let (light, stray) = procedure.with(&moved).light_and_stray()?;
        let rel = per_pixel(&|place, net| net / (light.per_s[place] - stray.per_s[place]) - 1.0);
        let name = match part {
            "spectral_linearity" => "polynomial",
            "spectral_linearity_bend" => "polynomial_bend",
            other => other,
        };
        components.push(Component::shared(name, rel));
    }
    let former: Vec<f64> = range.clone().map(|place| pixels[place].factor_w_m2_nm).collect();
    let total = |rates: &Rates| range.clone().map(|place| rates.per_s[place]).sum::<f64>();
    let mut factors = SpectralFactors {
        drift: drift(&wavelength_nm, &factor_w_m2_nm, &former, &net, station.u_rel),
        conditions,
        corrected_by: procedure.corrected_by(),
        stated_nm: range.clone().map(|place| pixels[place].wavelength_nm).collect(),
        wavelength_nm,
        factor_w_m2_nm,
        irradiance_w_m2_nm,
        components,
        integration_s: procedure.brightest[0].integration_s,
        nonlinearity_rel,
        stray_rel: total(&stray) / total(&light),
        change_rel,
        temperature_k,
        u_rel: 0.0,
        u_shape_rel: 0.0,
        colour: None,
    };
    factors.u_rel = factors.illuminance_u_rel();
    factors.u_shape_rel = factors.shape_u_rel();
    factors.colour = factors.tristimulus().colour();
    Ok(factors)
}

/// The pixels around the brightest one that are usable without a gap.
fn around_the_peak(light: &Rates, usable: impl Fn(usize) -> bool) -> std::ops::Range<usize> {
    let places = 0..light.per_s.len();
    let Some(peak) = places.max_by(|a, b| light.per_s[*a].total_cmp(&light.per_s[*b])) else {
        return 0..0;
    };
    if !usable(peak) {
        return 0..0;
    }
    let first = (0..peak)
        .rev()
        .take_while(|place| usable(*place))
        .last()
        .unwrap_or(peak);
    let last = (peak..light.per_s.len())
        .take_while(|place| usable(*place))
        .last()
        .unwrap_or(peak);
    first..last + 1
}

/// `u_rel` of the certificate between its rows, linear.
fn u_certified(rows: &[isolux_record::standard::CertifiedRow], wavelength_nm: f64) -> f64 {
    let above = rows
        .partition_point(|row| row.wavelength_nm < wavelength_nm)
        .clamp(1, rows.len() - 1);
    let (low, high) = (rows[above - 1], rows[above]);
    let share = (wavelength_nm - low.wavelength_nm) / (high.wavelength_nm - low.wavelength_nm);
    low.u_rel + share * (high.u_rel - low.u_rel)
}

fn drift(wavelength_nm: &[f64], factors: &[f64], former: &[f64], net: &[f64], u_former_rel: Option<f64>) -> Drift {
    let relative = |(new, former): (&f64, &f64)| (*former > 0.0).then(|| new / former - 1.0);
    let light = |factors: &[f64]| {
        let value = factors.iter().zip(net).map(|(factor, net)| factor * net).collect();
        let spectrum = Spectrum::new(wavelength_nm.to_vec(), value).ok()?;
        Some(spectrum.luminous_integral())
    };
    // Where V(λ) is below a thousandth nothing is missed.
    let whole = wavelength_nm
        .iter()
        .zip(former)
        .all(|(nm, former)| *former > 0.0 || !(400.0..720.0).contains(nm));
    Drift {
        relative: factors.iter().zip(former).map(relative).collect(),
        illuminance_rel: whole.then(|| Some(light(factors)? / light(former)? - 1.0)).flatten(),
        u_former_rel,
    }
}

/// Tristimulus values and their covariance.
pub(super) struct TristimulusCovariance {
    value: [f64; 3],
    covariance: [[f64; 3]; 3],
}

impl TristimulusCovariance {
    fn colour(&self) -> Option<Colour> {
        let of = |value: [f64; 3]| Tristimulus {
            x: value[0],
            y: value[1],
            z: value[2],
        };
        let chromaticity = |value: [f64; 3]| of(value).chromaticity();
        let u = |quantity: &dyn Fn([f64; 3]) -> Option<f64>| -> Option<[f64; 2]> {
            let here = quantity(self.value)?;
            let mut slope = [0.0; 3];
            for (axis, slope) in slope.iter_mut().enumerate() {
                let mut moved = self.value;
                let step = STEP * self.value[axis];
                moved[axis] += step;
                *slope = (quantity(moved)? - here) / step;
            }
            let variance: f64 = (0..3)
                .flat_map(|i| (0..3).map(move |j| (i, j)))
                .map(|(i, j)| slope[i] * slope[j] * self.covariance[i][j])
                .sum();
            Some([here, variance.max(0.0).sqrt()])
        };
        let cct = |value| {
            let colour = isolux_spectrum::cct::nearest_planckian(chromaticity(value)?)?;
            Some(colour.meaningful()?.cct_k)
        };
        Some(Colour {
            x: u(&|value| Some(chromaticity(value)?.x))?,
            y: u(&|value| Some(chromaticity(value)?.y))?,
            cct_k: u(&cct),
        })
    }
}

impl SpectralFactors {
    /// Relative standard uncertainty of the factor at a wavelength, all causes.
    pub fn u_rel_at(&self, place: usize) -> f64 {
        self.covariance_rel(place, place).sqrt()
    }

    /// Relative covariance of the factors at two wavelengths, all causes.
    pub fn covariance_rel(&self, one: usize, other: usize) -> f64 {
        self.components.iter().map(|part| part.covariance_rel(one, other)).sum()
    }

    /// Tristimulus values of the standard measured with these factors.
    pub(super) fn tristimulus(&self) -> TristimulusCovariance {
        let of = |value: Vec<f64>| {
            let spectrum = Spectrum::new(self.wavelength_nm.clone(), value).ok();
            spectrum.map_or([0.0; 3], |spectrum| {
                let xyz = spectrum.tristimulus();
                [xyz.x, xyz.y, xyz.z]
            })
        };
        let with = |rel: &[f64]| {
            of(self
                .irradiance_w_m2_nm
                .iter()
                .zip(rel)
                .map(|(e, rel)| e * rel)
                .collect())
        };
        let mut covariance = [[0.0; 3]; 3];
        let mut add = |change: [f64; 3]| {
            for (row, one) in covariance.iter_mut().zip(change) {
                for (sum, other) in row.iter_mut().zip(change) {
                    *sum += one * other;
                }
            }
        };
        for part in &self.components {
            part.correlated_rel.iter().for_each(|rel| add(with(rel)));
            for (place, u) in part.independent_rel.iter().enumerate() {
                // One value, with linear interpolation to zero at both neighbours.
                let near = place.saturating_sub(1)..(place + 2).min(self.wavelength_nm.len());
                let value = |at: usize| {
                    if at == place {
                        u * self.irradiance_w_m2_nm[at]
                    } else {
                        0.0
                    }
                };
                let alone = Spectrum::new(self.wavelength_nm[near.clone()].to_vec(), near.map(value).collect());
                add(alone.map_or([0.0; 3], |alone| {
                    let xyz = alone.tristimulus();
                    [xyz.x, xyz.y, xyz.z]
                }));
            }
        }
        TristimulusCovariance {
            value: of(self.irradiance_w_m2_nm.clone()),
            covariance,
        }
    }

    /// Relative standard uncertainty of the illuminance of the standard, measured with these factors.
    pub fn illuminance_u_rel(&self) -> f64 {
        let xyz = self.tristimulus();
        xyz.covariance[1][1].sqrt() / xyz.value[1]
    }

    /// Relative standard uncertainty of their ratio at 700 nm and 400 nm, or at the ends of the range within.
    pub fn shape_u_rel(&self) -> f64 {
        let nearest = |nm: f64| {
            let places = 0..self.wavelength_nm.len();
            let off = |place: &usize| (self.wavelength_nm[*place] - nm).abs();
            places.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_default()
        };
        let (blue, red) = (nearest(400.0), nearest(700.0));
        let variance =
            self.covariance_rel(blue, blue) + self.covariance_rel(red, red) - 2.0 * self.covariance_rel(blue, red);
        variance.max(0.0).sqrt()
    }
}
