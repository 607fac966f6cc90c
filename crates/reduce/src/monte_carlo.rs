//! Propagation of distributions (JCGM 101:2008, 7): the whole reduction of records that differ from the one that was
//! read by errors of its inputs, beside the budget, which propagates uncertainties by slopes.
//!
//! | input | distribution | JCGM 101 |
//! |---|---|---|
//! | noise of a reading, of a pixel, of its dark | normal, one each | 6.4.7 |
//! | digit of a reading | even within ± half; one for all equal displays that noise does not dither | 6.4.2 |
//! | calibration of the lux meter, of the spectroradiometer; distances; γ; wavelengths | normal, one for all | 6.4.7 |
//! | tilt and bow of the spectroradiometer's calibration | normal, one each for all | 6.4.7 |
//! | its bandpass, scattered light and linearity | normal, one each for all | 6.4.7 |
//! | responsivity of the lux meter's head | normal, one for each of two waves over wavelength | 6.4.7 |
//! | its linearity, temperature coefficient and temperature | normal, one each for all | 6.4.7 |
//!
//! What no record shows (interpolation, limited distance, bounds of light that was not measured) is not drawn: of a
//! quantity that has such parts, the others are compared.

use isolux_record::Run;
use isolux_record::spectra::SpectralCorrections;
use isolux_record::station::LuxMeter;
use serde::Serialize;

use crate::background::noise_of_one;
use crate::instrument::root;
use crate::meter::waves;
use crate::normal::Normal;
use crate::{Options, Quantity, ReduceError, Reduction, Wanted, reduce, reduce_to};

/// Parts of a budget whose inputs are drawn.
const DRAWN: [&str; 16] = [
    "noise",
    "digit",
    "dark_noise",
    "dark_digit",
    "distance",
    "calibration",
    "angle",
    "calibration_shape",
    "calibration_bow",
    "wavelength",
    "bandpass",
    "scatter",
    "spectral_linearity",
    "spectral_linearity_bend",
    "efficacy",
    "smoothing",
];
/// Share of the draws outside the interval, at each end.
const TAIL: f64 = 0.025;

/// A quantity by its budget and by draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Propagated {
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value by the record as it was read.
    pub value: f64,
    /// Standard uncertainty of those parts of its budget that are drawn.
    pub u_budget: f64,
    /// Parts of its budget that are not, and what is missing in it.
    pub not_drawn: Vec<String>,
    /// Mean of the draws.
    pub mean: f64,
    /// Their standard deviation.
    pub u: f64,
    /// Interval of 95 %, with equal shares of the draws below and above (JCGM 101, 7.7).
    pub interval: [f64; 2],
    /// Draws that have this quantity.
    pub draws: usize,
}

/// A record whose inputs are drawn again and again.
#[derive(Debug)]
pub struct MonteCarlo<'a> {
    run: &'a Run,
    options: &'a Options,
    centre: Vec<(String, Quantity)>,
    /// Parts of the lux meter's own response that were corrected: what is not corrected is not drawn.
    of_meter: Vec<&'static str>,
}

impl<'a> MonteCarlo<'a> {
    /// Of a run at rest, which gives results.
    ///
    /// # Errors
    /// What the reduction of the record fails with; a scan in motion.
    pub fn new(run: &'a Run, options: &'a Options) -> Result<Self, ReduceError> {
        if !run.sweeps.is_empty() {
            return Err(ReduceError::NotDrawn);
        }
        let reduction = reduce(run, options, None)?;
        Ok(Self {
            run,
            options,
            of_meter: reduction.luxmeter.corrected(),
            centre: quantities(&reduction),
        })
    }

    /// The quantities of the draw of this number, in the order of the centre, none where that record gives none. The
    /// same number gives the same draw.
    ///
    /// # Errors
    /// What the reduction of the drawn record fails with.
    pub fn draw(&self, number: u64) -> Result<Vec<Option<f64>>, ReduceError> {
        let drawn = reduce_to(Wanted::Values, &drawn(self.run, number), self.options, None)?;
        let found = quantities(&drawn);
        let of = |name: &str| {
            found
                .iter()
                .find(|(there, _)| there == name)
                .map(|(_, found)| found.value)
        };
        Ok(self.centre.iter().map(|(name, _)| of(name)).collect())
    }

    /// What draws, each as [`draw`](Self::draw) gives it, say beside the budget.
    pub fn propagated(&self, draws: &[Vec<Option<f64>>]) -> Vec<Propagated> {
        let of = |(place, (name, quantity)): (usize, &(String, Quantity))| {
            let mut values: Vec<f64> = draws.iter().filter_map(|draw| draw[place]).collect();
            values.sort_by(f64::total_cmp);
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            let at = |share: f64| values[((count * share) as usize).min(values.len() - 1)];
            let (known, others): (Vec<_>, Vec<_>) = quantity
                .parts
                .iter()
                .partition(|(part, _)| DRAWN.contains(&part.as_ref()) || self.of_meter.contains(&part.as_ref()));
            (values.len() > 1).then(|| Propagated {
                name: name.clone(),
                unit: quantity.unit.to_string(),
                value: quantity.value,
                u_budget: known.iter().map(|(_, part)| *part * *part).sum::<f64>().sqrt(),
                not_drawn: others
                    .iter()
                    .filter(|(_, part)| **part != 0.0)
                    .map(|(part, _)| part.to_string())
                    .chain(quantity.missing.iter().cloned())
                    .collect(),
                mean,
                u: (squares / (count - 1.0)).sqrt(),
                interval: [at(TAIL), at(1.0 - TAIL)],
                draws: values.len(),
            })
        };
        self.centre.iter().enumerate().filter_map(of).collect()
    }
}

/// The headline quantities of a reduction that have parts.
fn quantities(reduction: &Reduction) -> Vec<(String, Quantity)> {
    let mut all: Vec<(String, Quantity)> = Vec::new();
    let mut add = |name: &str, quantity: Option<&Quantity>| {
        all.extend(quantity.map(|quantity| (name.to_owned(), quantity.clone())));
    };
    add("flux", Some(&reduction.flux));
    add("I max", Some(&reduction.i_max));
    for angles in &reduction.angles {
        add(&format!("beam angle {}", angles.name()), angles.beam.as_ref());
        add(&format!("field angle {}", angles.name()), angles.field.as_ref());
    }
    add("mean illuminance of the sensor", Some(&reduction.sensor_illuminance));
    add("mean irradiance of the sensor", reduction.sensor_irradiance.as_ref());
    if let Some(spectral) = &reduction.spectral {
        add("irradiance on the axis", Some(&spectral.irradiance));
        add("efficacy of radiation", Some(&spectral.ler));
        let colour = &spectral.colour;
        for (name, quantity) in [
            ("CCT", &colour.cct),
            ("Duv", &colour.duv),
            ("x", &colour.x),
            ("y", &colour.y),
            ("Ra", &colour.ra),
            ("Rf", &colour.rf),
            ("Rg", &colour.rg),
        ] {
            add(name, quantity.as_ref());
        }
    }
    all
}

/// The record with the inputs of this draw.
fn drawn(run: &Run, number: u64) -> Run {
    let mut run = run.clone();
    let mut normal = Normal::new(number.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD4);
    let station = run.header.station.clone();
    let (bench, meter) = (station.bench(), station.luxmeter());
    // The inverse square law is the same for a distance that is wrong and for light that is.
    let of_distance =
        |share: f64, u_mm: Option<f64>, distance_mm: f64| (1.0 + u_mm.unwrap_or(0.0) / distance_mm * share).powi(2);
    let (gain, distance) = (1.0 + meter.u_rel * normal.next(), normal.next());
    let gamma_deg = bench.u_gamma_deg.unwrap_or(0.0) * normal.next();
    let gain = Gain::of(meter, gain, number);
    for row in &mut run.readings.rows {
        let Some(shown_lx) = row.illuminance_lx else { continue };
        let digit_lx = row.digit_lx.unwrap_or(0.0);
        let noise_lx = noise_of_one(row.u_lx.unwrap_or(0.0), digit_lx);
        let quiet = digit_lx > 0.0 && noise_lx <= 0.5 * digit_lx;
        let rounding = if quiet {
            Normal::new(number ^ ((shown_lx / digit_lx).round() as i64 as u64).wrapping_mul(0xA24B_AED4_963E_E407))
                .unit()
        } else {
            normal.unit()
        };
        let lux = shown_lx + noise_lx * normal.next() + digit_lx * (rounding - 0.5);
        row.illuminance_lx =
            Some(gain.at(row.ambient_c) * of_distance(distance, bench.u_distance_mm, row.distance_mm) * lux);
        row.gamma_deg += gamma_deg;
    }
    if let Some(curves) = &mut run.header.luxmeter {
        let curve = &mut curves.responsivity;
        for wave in waves(&curve.wavelength_nm, &curve.u_rel) {
            let amount = normal.next();
            for (value, rel) in curve.value.iter_mut().zip(wave) {
                *value *= 1.0 + amount * rel;
            }
        }
    }
    let Some(spectro) = station.spectroradiometer() else {
        return run;
    };
    let (level, distance) = (1.0 + spectro.u_rel.unwrap_or(0.0) * normal.next(), normal.next());
    let shape_rel = spectro.u_shape_rel.unwrap_or(0.0);
    let (tilt, bow) = (shape_rel * normal.next(), shape_rel * normal.next());
    let shift_nm = spectro.u_wavelength_nm.unwrap_or(0.0) * normal.next();
    if let Some(spectral) = &mut run.header.spectral {
        draw_corrections(&mut spectral.corrections, &mut normal);
    }
    for spectrum in &mut run.spectra {
        let level = level * of_distance(distance, spectro.u_distance_mm, spectrum.distance_mm);
        for pixel in &mut spectrum.pixels {
            let t = (pixel.wavelength_nm - 550.0) / 300.0;
            pixel.factor_w_m2_nm *= level * (1.0 + tilt * t) * (1.0 + 0.5 * bow * (1.0 - 8.0 * t * t));
            pixel.wavelength_nm += shift_nm;
            pixel.counts += pixel.u_counts * normal.next();
            pixel.dark_counts += pixel.u_dark_counts * normal.next();
        }
    }
    run
}

/// What all readings share, by the temperature.
struct Gain {
    level: f64,
    /// Relative for a kelvin, and at the temperature of the calibration.
    per_k: f64,
    reference_c: f64,
}

impl Gain {
    fn of(meter: &LuxMeter, level: f64, number: u64) -> Self {
        // Numbers of their own: without these keys the draws are those of the other inputs.
        let mut normal = Normal::new(number.wrapping_mul(0xD6E8_FEB8_6659_FD93) ^ 0x6C);
        let linearity = meter.linearity.as_ref().map_or(0.0, |stated| stated.u_rel) * normal.next();
        let mut gain = Self {
            level: level * (1.0 + linearity),
            per_k: 0.0,
            reference_c: 0.0,
        };
        if let Some(stated) = &meter.temperature {
            gain.per_k = stated.u_coefficient_per_k * normal.next();
            gain.reference_c = stated.reference_c;
            gain.level *= 1.0 + stated.coefficient_per_k * stated.u_temperature_k * normal.next();
        }
        gain
    }

    fn at(&self, ambient_c: Option<f64>) -> f64 {
        self.level * (1.0 + self.per_k * ambient_c.map_or(0.0, |ambient_c| ambient_c - self.reference_c))
    }
}

/// What the laboratory has found of the spectroradiometer, drawn; its wavelengths are drawn by `u_wavelength_nm`.
fn draw_corrections(corrections: &mut SpectralCorrections, normal: &mut Normal) {
    if let Some(scale) = &mut corrections.wavelengths {
        scale.fwhm_nm = (scale.fwhm_nm + scale.u_fwhm_nm * normal.next()).max(0.0);
    }
    if let Some(scatter) = &mut corrections.scatter {
        scatter.move_by(normal.next());
    }
    if let Some(linearity) = &mut corrections.linearity {
        for column in root(&linearity.covariance) {
            let share = normal.next();
            let coefficients = linearity.coefficient.iter_mut().zip(column);
            coefficients.for_each(|(c, change)| *c += share * change);
        }
    }
}

#[cfg(test)]
mod tests {
    use isolux_record::spectra::{Linearity, Made, Scatter, WavelengthScale};

    use super::*;

    #[test]
    fn corrections_of_the_instrument_are_drawn_with_their_uncertainties() {
        let made = || Made {
            instrument: String::new(),
            day: String::new(),
            with: String::new(),
            record_sha256: String::new(),
        };
        let of = SpectralCorrections {
            wavelengths: Some(WavelengthScale {
                format: String::new(),
                offset_nm: vec![0.1],
                covariance_nm2: vec![vec![1e-4]],
                range_nm: [400.0, 900.0],
                fwhm_nm: 2.5,
                u_fwhm_nm: 0.05,
                made: made(),
                line: Vec::new(),
            }),
            scatter: Some(Scatter {
                format: String::new(),
                edges_nm: Vec::new(),
                share_rel: vec![vec![0.004]],
                u_share_rel: vec![vec![0.0008]],
                made: made(),
            }),
            linearity: Some(Linearity {
                format: String::new(),
                coefficient: vec![-0.02, 0.01],
                covariance: vec![vec![4e-6, -3e-6], vec![-3e-6, 9e-6]],
                range_rel: [0.01, 0.7],
                made: made(),
            }),
        };
        let mut normal = Normal::new(5);
        let (draws, mut squares) = (4000, [0.0; 5]);
        for _ in 0..draws {
            let mut drawn = of.clone();
            draw_corrections(&mut drawn, &mut normal);
            let width = drawn.wavelengths.unwrap().fwhm_nm - 2.5;
            let share = drawn.scatter.unwrap().share_rel[0][0] - 0.004;
            let c = drawn.linearity.unwrap().coefficient;
            let [a, b] = [c[0] + 0.02, c[1] - 0.01];
            let terms = [width * width, share * share, a * a, b * b, a * b];
            squares.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        for (sum, expected) in squares
            .into_iter()
            .zip([0.05 * 0.05, 0.0008 * 0.0008, 4e-6, 9e-6, -3e-6])
        {
            assert!(
                (sum / f64::from(draws) / expected - 1.0).abs() < 0.1,
                "{sum} {expected}"
            );
        }
    }
}
