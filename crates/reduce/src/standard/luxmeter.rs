//! The factor of a lux meter, from a lamp with a certificate of its illuminance: k = E_cert / E_read under illuminant
//! A.

use isolux_record::{Quality, Reading, ReadingKind, Role, Run, Standard};
use isolux_spectrum::{Spectrum, illuminant};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::conditions::{Calibrated, Conditions, of_kind};
use super::error::CalibrationError;
use super::{STRAY_HALF_WIDTH, TEMPERATURE_OVER_CURRENT};
use crate::Options;
use crate::meter::Response;
use crate::spectral::ON_AXIS_DEG;

/// The factor of a lux meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LuxFactor {
    /// Under what it was found.
    pub conditions: Conditions,
    /// True illuminance over shown illuminance: `luxmeter.calibration_factor` of a station.
    pub calibration_factor: f64,
    /// Its relative standard uncertainty: `luxmeter.u_rel`.
    pub u_rel: f64,
    /// Its parts by cause, relative standard uncertainties.
    pub parts_rel: Vec<(String, f64)>,
    /// Illuminance of the standard at the distance of the readings, lx.
    pub certified_lx: f64,
    /// What the meter showed of it, stray light taken off, lx.
    pub shown_lx: f64,
    /// Light behind the baffle over all light.
    pub stray_rel: f64,
    /// Light of the last readings over that of the first, less 1.
    pub change_rel: f64,
    /// The factor that the station had.
    pub former_factor: f64,
    /// Its relative standard uncertainty as the station states it.
    pub u_former_rel: f64,
    /// New over former, less 1.
    pub drift_rel: f64,
}

/// The factor that a run with a standard lamp gives.
///
/// # Errors
/// [`CalibrationError`]: what the certificate does not cover, and readings without a number or unsteady ones.
pub fn luxmeter(run: &Run, standard: &Standard) -> Result<LuxFactor, CalibrationError> {
    let certified = standard
        .illuminance()
        .ok_or(CalibrationError::NotCertified("illuminance"))?;
    // What the station states of linearity, temperature and fatigue is no part of the factor.
    let response = Response::of(run, &Options::default(), None);
    let run = &*response.applied(run);
    let station = &run.header.station;
    let blocks = blocks(run)?;
    let first = blocks[0].first().ok_or(CalibrationError::NoPart(LIT))?;
    let distance_mm = first.distance_mm;
    let (conditions, stated) = Conditions::of(Calibrated::Luxmeter, run, standard, distance_mm)?;
    let lit: Vec<&Reading> = blocks.into_iter().flatten().collect();
    let baffled: Vec<&Reading> = of_kind(run, ReadingKind::Baffled).collect();
    if baffled.is_empty() {
        return Err(CalibrationError::NoPart("reading behind the baffle"));
    }
    let (light, stray) = (Mean::of(&lit)?, Mean::of(&baffled)?);
    let half = lit.len() / 2;
    let change_rel = Mean::of(&lit[half..])?.lx / Mean::of(&lit[..half])?.lx - 1.0;
    let limit_rel = run.header.plan.limits().reference_rel();
    if change_rel.abs() > limit_rel {
        return Err(CalibrationError::Unsteady { change_rel, limit_rel });
    }
    let former_factor = station.luxmeter().calibration_factor;
    let shown_lx = (light.lx - stray.lx) / former_factor;
    let certified_lx = certified.illuminance_lx * (certified.distance_mm / distance_mm).powi(2);
    let third = 3.0f64.sqrt();
    let net = light.lx - stray.lx;
    let parts = [
        ("certificate", certified.u_rel),
        (
            "current",
            TEMPERATURE_OVER_CURRENT * conditions.u_current_rel * luminous_tilt(certified.colour_temperature_k),
        ),
        ("distance", 2.0 * stated.u_distance_mm / distance_mm),
        ("alignment", stated.alignment_rel),
        ("noise", light.u_lx.hypot(stray.u_lx) / net),
        ("digit", light.digit_lx / 12.0f64.sqrt() / net),
        ("stray", STRAY_HALF_WIDTH / third * stray.lx.abs() / net),
        ("drift", change_rel.abs() / 12.0f64.sqrt()),
    ];
    let of_meter = [
        ("linearity", response.linearity.u_rel),
        ("temperature", response.temperature.u_rel),
        ("fatigue", response.fatigue.u_rel),
    ];
    let of_meter = of_meter.into_iter().filter(|(_, u)| *u > 0.0);
    let parts: Vec<(&str, f64)> = parts.into_iter().chain(of_meter).collect();
    let calibration_factor = certified_lx / shown_lx;
    Ok(LuxFactor {
        conditions,
        calibration_factor,
        u_rel: parts.iter().map(|(_, u)| u * u).sum::<f64>().sqrt(),
        parts_rel: parts.iter().map(|(name, u)| ((*name).to_owned(), *u)).collect(),
        certified_lx,
        shown_lx,
        stray_rel: stray.lx / light.lx,
        change_rel,
        former_factor,
        u_former_rel: station.luxmeter().u_rel,
        drift_rel: calibration_factor / former_factor - 1.0,
    })
}

const LIT: &str = "reading of the lit lamp before and after the baffle";

/// The lit readings on the axis, block by block; at least two blocks.
fn blocks(run: &Run) -> Result<Vec<Vec<&Reading>>, CalibrationError> {
    let mut blocks: Vec<Vec<&Reading>> = Vec::new();
    let points = of_kind(run, ReadingKind::Lit).filter(|row| row.role == Role::Point);
    for row in points.filter(|row| row.gamma_deg.abs() < ON_AXIS_DEG) {
        match blocks.last_mut() {
            Some(block) if block[0].block == row.block => block.push(row),
            _ => blocks.push(vec![row]),
        }
    }
    if blocks.len() < 2 {
        return Err(CalibrationError::NoPart(LIT));
    }
    Ok(blocks)
}

/// The mean of readings.
struct Mean {
    lx: f64,
    /// From their scatter.
    u_lx: f64,
    digit_lx: f64,
}

impl Mean {
    fn of(rows: &[&Reading]) -> Result<Self, CalibrationError> {
        let value = |row: &&Reading| match (row.quality, row.illuminance_lx) {
            (Quality::Ok, Some(lx)) => Ok(lx),
            (quality, _) => Err(CalibrationError::NoNumber {
                row: row.index,
                quality: quality.to_string(),
            }),
        };
        let values = rows.iter().map(value).collect::<Result<Vec<f64>, _>>()?;
        let n = values.len() as f64;
        let lx = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - lx).powi(2)).sum();
        Ok(Self {
            lx,
            u_lx: (squares / (n - 1.0).max(1.0) / n).sqrt(),
            digit_lx: rows.iter().filter_map(|row| row.digit_lx).fold(0.0, f64::max),
        })
    }
}

/// Relative change of the illuminance of a Planckian radiator for a relative change of its temperature.
fn luminous_tilt(temperature_k: f64) -> f64 {
    let light = |temperature_k: f64| {
        // That spectrum is 1 at 560 nm: the light there is in the tilt of Planck's law.
        let spectrum = Spectrum::from_1_nm(&illuminant::planck(temperature_k));
        spectrum.map_or(f64::NAN, |spectrum| spectrum.luminous_integral().ln())
    };
    let step = 1e-3;
    let [low, high] = [1.0 - step, 1.0 + step].map(|by| light(by * temperature_k));
    super::interpolation::tilt(560.0, temperature_k) + (high - low) / (2.0 * step)
}
