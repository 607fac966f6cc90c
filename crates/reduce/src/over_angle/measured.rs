//! The spectra of a run by direction, and which of them are left out.

use std::borrow::Cow;

use isolux_photometry::direction;
use isolux_record::plan::Block;
use isolux_record::run::Run;
use isolux_record::spectra::{SpectralCalibration, SpectrumRecord};
use isolux_spectrum::{Spectrum, cie};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::ReduceError;
use crate::grid::{folded, is_pole};
use crate::instrument::Chain;
use crate::one_nm::AtOneNm;
use crate::spectral::{ON_AXIS_DEG, is_lit};

/// A spectrum with less light than so many of its own standard uncertainties shows no colour.
const LEAST_OF_NOISE: f64 = 10.0;
/// An axis stands at a direction of the plan when it is read back nearer than this.
const NEAR_DEG: f64 = 0.5;

/// The mean of the spectra of one direction.
#[derive(Debug, Clone)]
pub struct Direction {
    /// C within 0° to 360°.
    pub c_deg: f64,
    /// γ within 0° to 180°.
    pub gamma_deg: f64,
    /// Spectral irradiance, W/m²/nm, at whole nanometres.
    pub spectrum: Spectrum,
    /// Variance of each value from noise.
    pub variance: Vec<f64>,
    /// Illuminance of the spectrum.
    pub illuminance_lx: f64,
}

/// A direction whose spectra are not used.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOut {
    /// Its C.
    pub c_deg: f64,
    /// Its γ.
    pub gamma_deg: f64,
    /// Why.
    pub reason: Cow<'static, str>,
}

/// The spectra of a run over angle.
#[derive(Debug, Clone)]
pub struct Measured {
    /// By C and γ, one at a pole.
    pub directions: Vec<Direction>,
    /// What is not used.
    pub left_out: Vec<LeftOut>,
    /// Distance of the spectroradiometer.
    pub distance_mm: f64,
}

impl Measured {
    /// The lit spectra at the distance with the most directions; none where all are on the axis.
    ///
    /// # Errors
    /// What makes counts no irradiance. A direction that is saturated or dark is left out.
    pub fn of(run: &Run, calibration: &SpectralCalibration, chain: Chain) -> Result<Option<Self>, ReduceError> {
        let records = run.spectra.iter().filter(|record| is_lit(run, record));
        let placed: Vec<Placed<'_>> = records.filter_map(|record| Placed::of(run, record)).collect();
        let at = |distance_mm: f64| {
            placed
                .iter()
                .filter(move |placed| placed.record.distance_mm == distance_mm)
        };
        let directions = |distance_mm: f64| {
            let mut all: Vec<[f64; 2]> = at(distance_mm).map(Placed::key).collect();
            all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            all.dedup();
            all
        };
        let mut distances: Vec<f64> = placed.iter().map(|placed| placed.record.distance_mm).collect();
        distances.sort_by(f64::total_cmp);
        distances.dedup();
        // The last of equals: farther away the lamp is smaller.
        let Some(distance_mm) = distances.into_iter().max_by_key(|mm| directions(*mm).len()) else {
            return Ok(None);
        };
        let keys = directions(distance_mm);
        if keys.iter().all(|[_, gamma_deg]| *gamma_deg < ON_AXIS_DEG) {
            return Ok(None);
        }
        let mut measured = Self {
            directions: Vec::new(),
            left_out: Vec::new(),
            distance_mm,
        };
        for key in keys {
            let of_key = at(distance_mm).filter(|placed| placed.key() == key);
            let records: Vec<&SpectrumRecord> = of_key.map(|placed| placed.record).collect();
            let [c_deg, gamma_deg] = key;
            let mean = AtOneNm::mean(&records, calibration, chain);
            let reason = match mean {
                Ok(mean) => match Direction::of(c_deg, gamma_deg, mean)? {
                    Ok(direction) => {
                        measured.directions.push(direction);
                        continue;
                    }
                    Err(reason) => reason,
                },
                Err(error @ (ReduceError::Saturated { .. } | ReduceError::Uncalibrated { .. })) => error.to_string(),
                Err(error) => return Err(error),
            };
            measured.left_out.push(LeftOut {
                c_deg,
                gamma_deg,
                reason: reason.into(),
            });
        }
        Ok(Some(measured))
    }
}

/// A spectrum at a direction of its block.
struct Placed<'a> {
    record: &'a SpectrumRecord,
    c_deg: f64,
    gamma_deg: f64,
}

impl<'a> Placed<'a> {
    /// None where the axes stood at no direction of the block.
    fn of(run: &Run, record: &'a SpectrumRecord) -> Option<Self> {
        let block = run
            .header
            .plan
            .blocks()
            .iter()
            .find(|block| block.name == record.block)?;
        let (c_deg, gamma_deg) = nearest(block, record)?;
        let (c_deg, gamma_deg) = folded(c_deg, gamma_deg);
        Some(Self {
            record,
            c_deg: if is_pole(gamma_deg) {
                0.0
            } else {
                c_deg.rem_euclid(360.0)
            },
            gamma_deg,
        })
    }

    fn key(&self) -> [f64; 2] {
        [self.c_deg, self.gamma_deg]
    }
}

/// The direction of a block at which a spectrum was taken.
fn nearest(block: &Block, record: &SpectrumRecord) -> Option<(f64, f64)> {
    let towards = |c_deg: f64, gamma_deg: f64| {
        let (c_deg, gamma_deg) = folded(c_deg, gamma_deg);
        direction(c_deg, gamma_deg)
    };
    let read = towards(record.c_deg, record.gamma_deg);
    let planned = block
        .c_deg
        .iter()
        .flat_map(|c| block.gamma_deg.iter().map(move |gamma| (*c, *gamma)));
    let away = |&(c_deg, gamma_deg): &(f64, f64)| (towards(c_deg, gamma_deg) - read).length().to_degrees();
    let nearest = planned.min_by(|a, b| away(a).total_cmp(&away(b)))?;
    (away(&nearest) < NEAR_DEG).then_some(nearest)
}

impl Direction {
    /// The mean of its spectra, or why it shows no colour.
    fn of(c_deg: f64, gamma_deg: f64, mean: AtOneNm) -> Result<Result<Self, String>, ReduceError> {
        let luminous: f64 = mean
            .wavelength_nm
            .iter()
            .zip(&mean.expected)
            .map(|(nm, variance)| (cie::K_M_LM_PER_W * v_lambda(*nm)).powi(2) * variance)
            .sum();
        let (u_lx, variance) = (luminous.sqrt(), mean.expected);
        let spectrum = Spectrum::new(mean.wavelength_nm, mean.value)?;
        let illuminance_lx = spectrum.luminous_integral();
        if illuminance_lx.is_nan() || illuminance_lx <= LEAST_OF_NOISE * u_lx || spectrum.integral() <= 0.0 {
            return Ok(Err(format!(
                "too dark: {illuminance_lx:.3} lx with a noise of {u_lx:.3} lx; nearer, with longer integration or \
                 more repeats it would count"
            )));
        }
        Ok(Ok(Self {
            c_deg,
            gamma_deg,
            spectrum,
            variance,
            illuminance_lx,
        }))
    }
}

/// V(λ) at a whole nanometre; 0 outside its table.
fn v_lambda(nm: f64) -> f64 {
    let place = nm - cie::FIRST_NM as f64;
    if place < 0.0 {
        return 0.0;
    }
    cie::V_LAMBDA.get(place as usize).copied().unwrap_or(0.0)
}
