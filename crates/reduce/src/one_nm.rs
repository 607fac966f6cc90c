//! Counts of a spectroradiometer's pixels → irradiance at whole nanometres, with the noise of both.

use isolux_record::spectra::{SpectralCalibration, SpectrumRecord};

use crate::bandpass;
use crate::error::ReduceError;
use crate::instrument::{Chain, Linear, bandpass_nm};
use crate::spectral_noise::with_expected_noise;

/// Spectral irradiance at whole nanometres.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AtOneNm {
    /// The nanometres, as far as the calibrated pixels go.
    pub wavelength_nm: Vec<f64>,
    /// W/m²/nm.
    pub value: Vec<f64>,
    /// Variance of each value from the scatter of its own pixels.
    pub variance: Vec<f64>,
    /// The same from the noise that all pixels show together, with what neighbours share, so that sums over many values
    /// have the noise that they have.
    pub expected: Vec<f64>,
}

impl AtOneNm {
    /// The mean of spectra of one place, all read with the same pixels.
    ///
    /// # Errors
    /// [`ReduceError`] for saturation where the instrument is calibrated, or no calibrated pixel.
    pub fn mean(
        records: &[&SpectrumRecord],
        calibration: &SpectralCalibration,
        chain: Chain,
    ) -> Result<Self, ReduceError> {
        let mut mean = Self::default();
        let n = records.len() as f64;
        for record in records {
            let light = Linear::of(record, calibration, chain)?;
            let quiet = Linear::of(&with_expected_noise(record), calibration, chain)?;
            let calibrated: Vec<usize> = (0..record.pixels.len())
                .filter(|&pixel| record.pixels[pixel].factor_w_m2_nm > 0.0)
                .collect();
            if calibrated.len() < 2 {
                return Err(ReduceError::Uncalibrated { index: record.index });
            }
            let saturated: Vec<usize> = calibrated
                .iter()
                .copied()
                .filter(|&pixel| light.per_s[pixel].is_none())
                .collect();
            if let Some(&pixel) = saturated.first() {
                let (pixels, wavelength_nm) = (saturated.len(), record.pixels[pixel].wavelength_nm);
                return Err(ReduceError::Saturated {
                    index: record.index,
                    pixels,
                    wavelength_nm,
                });
            }
            let at: Vec<f64> = calibrated.iter().map(|&pixel| light.wavelength_nm[pixel]).collect();
            let of: Vec<f64> = calibrated.iter().filter_map(|&pixel| light.per_s[pixel]).collect();
            let u = |of: &Linear| -> Vec<f64> { calibrated.iter().map(|&pixel| of.u_per_s[pixel]).collect() };
            let (u, u_expected) = (u(&light), u(&quiet));
            let (grid, bins) = bins(&at);
            if grid.len() < 2 {
                return Err(ReduceError::Uncalibrated { index: record.index });
            }
            let factors: Vec<f64> = calibrated
                .iter()
                .map(|&pixel| record.pixels[pixel].factor_w_m2_nm)
                .collect();
            let bins = of_counts(bins, &factors, &at, bandpass_nm(calibration, chain));
            if mean.wavelength_nm.is_empty() {
                let none = vec![0.0; grid.len()];
                mean = Self {
                    wavelength_nm: grid,
                    value: none.clone(),
                    variance: none.clone(),
                    expected: none,
                };
            }
            // The weight of each pixel in all values together.
            let mut all_of = vec![0.0; of.len()];
            for &(pixel, weight) in bins.iter().flatten() {
                all_of[pixel] += weight;
            }
            for (place, weights) in bins.iter().enumerate().take(mean.value.len()) {
                mean.value[place] += weights.iter().map(|&(pixel, weight)| weight * of[pixel]).sum::<f64>() / n;
                mean.variance[place] += weights
                    .iter()
                    .map(|&(pixel, weight)| (weight * u[pixel]).powi(2))
                    .sum::<f64>()
                    / (n * n);
                mean.expected[place] += weights
                    .iter()
                    .map(|&(pixel, weight)| weight * all_of[pixel] * u_expected[pixel].powi(2))
                    .sum::<f64>()
                    / (n * n);
            }
        }
        Ok(mean)
    }
}

/// The weights of pixels' irradiances as weights of their counts a second: the bandpass is taken out of the counts, and
/// what is left has the factor of its pixel.
fn of_counts(
    bins: Vec<Vec<(usize, f64)>>,
    factors: &[f64],
    at_nm: &[f64],
    bandpass_nm: Option<f64>,
) -> Vec<Vec<(usize, f64)>> {
    let without = bandpass_nm.map(|fwhm_nm| bandpass::weights(at_nm, fwhm_nm));
    let of = |weights: Vec<(usize, f64)>| {
        let Some(without) = &without else {
            return weights
                .into_iter()
                .map(|(pixel, weight)| (pixel, weight * factors[pixel]))
                .collect();
        };
        let mut all: Vec<(usize, f64)> = Vec::new();
        for (pixel, weight) in weights {
            for &(from, share) in &without[pixel] {
                let part = weight * factors[pixel] * share;
                match all.iter_mut().find(|(known, _)| *known == from) {
                    Some((_, sum)) => *sum += part,
                    None => all.push((from, part)),
                }
            }
        }
        all
    };
    bins.into_iter().map(of).collect()
}

/// For every whole nanometre whose ± ½ nm the pixels cover: weights of the pixels in the mean of their linear
/// interpolant over that nanometre. Sampling it instead would throw away most of the pixels and keep their noise.
fn bins(at_nm: &[f64]) -> (Vec<f64>, Vec<Vec<(usize, f64)>>) {
    let (first, last) = (at_nm[0], at_nm[at_nm.len() - 1]);
    let (from, to) = ((first + 0.5).ceil().max(200.0), (last - 0.5).floor().min(2500.0));
    let mut grid = Vec::new();
    let mut all = Vec::new();
    let mut nm = from;
    while nm <= to {
        let (low, high) = (nm - 0.5, nm + 0.5);
        let begin = at_nm.partition_point(|at| *at <= low).saturating_sub(1);
        let mut weights: Vec<(usize, f64)> = Vec::new();
        let mut add = |pixel: usize, weight: f64| match weights.iter_mut().find(|(known, _)| *known == pixel) {
            Some((_, sum)) => *sum += weight,
            None => weights.push((pixel, weight)),
        };
        for pixel in begin..at_nm.len() - 1 {
            let (left, right) = (at_nm[pixel], at_nm[pixel + 1]);
            if left >= high {
                break;
            }
            let (a, b) = (left.max(low), right.min(high));
            if b <= a {
                continue;
            }
            // ∫ over [a, b] of the line through both pixels, as weights of the two.
            let share = (0.5 * (a + b) - left) / (right - left);
            add(pixel, (b - a) * (1.0 - share));
            add(pixel + 1, (b - a) * share);
        }
        grid.push(nm);
        all.push(weights);
        nm += 1.0;
    }
    (grid, all)
}

#[cfg(test)]
mod tests {
    use super::bins;

    #[test]
    fn a_line_is_kept_and_noise_averaged() {
        let at: Vec<f64> = (0..1500).map(|pixel| 350.2 + 0.31 * f64::from(pixel)).collect();
        let (grid, weights) = bins(&at);
        assert_eq!(grid[0], 351.0);
        for (nm, weights) in grid.iter().zip(&weights) {
            let mean: f64 = weights
                .iter()
                .map(|&(pixel, weight)| weight * (3.0 * at[pixel] + 1.0))
                .sum();
            assert!((mean - (3.0 * nm + 1.0)).abs() < 1e-9);
            assert!((weights.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }
}
