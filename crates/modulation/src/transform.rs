//! Fourier transforms of real samples.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::window::{self, Cosines};

/// The discrete Fourier transform of samples, all bins.
pub(crate) fn forward(samples: impl Iterator<Item = f64>) -> Vec<Complex<f64>> {
    let mut bins: Vec<_> = samples.map(|value| Complex::new(value, 0.0)).collect();
    FftPlanner::new().plan_fft_forward(bins.len()).process(&mut bins);
    bins
}

/// The samples of all bins.
pub(crate) fn inverse(mut bins: Vec<Complex<f64>>) -> Vec<f64> {
    let scale = 1.0 / bins.len() as f64;
    FftPlanner::new().plan_fft_inverse(bins.len()).process(&mut bins);
    bins.into_iter().map(|bin| scale * bin.re).collect()
}

/// Amplitudes of the components of `samples` less their mean, bins 0 to N/2, in units of the samples.
pub(crate) fn amplitudes(samples: &[f64], cosines: Cosines) -> Vec<f64> {
    let count = samples.len();
    let mean = samples.iter().sum::<f64>() / count as f64;
    let weights = window::window(cosines, count);
    let scale = 2.0 / weights.iter().sum::<f64>();
    let bins = forward(
        samples
            .iter()
            .zip(&weights)
            .map(|(value, weight)| weight * (value - mean)),
    );
    bins[..=count / 2].iter().map(|bin| scale * bin.norm()).collect()
}

/// Number of a bin and its opposite one: the signed frequency of a bin in cycles a record.
pub(crate) fn cycles(bin: usize, count: usize) -> f64 {
    if bin <= count / 2 {
        bin as f64
    } else {
        bin as f64 - count as f64
    }
}
