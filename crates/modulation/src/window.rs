//! Windows of a Fourier transform, as sums of cosines.

use std::f64::consts::TAU;

/// Weights of the cosines of a window: w(k) = Σ aₙ cos(2πnk/N).
pub(crate) type Cosines = &'static [f64];

/// Hann.
pub(crate) const HANN: Cosines = &[0.5, -0.5];
/// Harris 1978, four terms, side lobes at −92 dB.
pub(crate) const BLACKMAN_HARRIS: Cosines = &[0.358_75, -0.488_29, 0.141_28, -0.011_68];
/// HFT90D of Heinzel, Rüdiger and Schilling, "Spectrum and spectral density estimation by the DFT" (2002), appendix
/// D.5: amplitudes at any frequency to 0.045 %, side lobes at −90 dB, zero from the fifth bin on.
pub(crate) const FLAT_TOP: Cosines = &[1.0, -1.942_604, 1.340_318, -0.440_811, 0.043_097];
/// Bins on each side that belong to one component under [`FLAT_TOP`].
pub(crate) const FLAT_TOP_BINS: usize = 5;
/// Largest relative error of an amplitude under [`FLAT_TOP`].
pub(crate) const FLAT_TOP_ERROR: f64 = 4.5e-4;

/// The window for `samples` samples.
pub(crate) fn window(cosines: Cosines, samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| {
            let turn = TAU * k as f64 / samples as f64;
            let terms = cosines.iter().enumerate().map(|(n, a)| a * (n as f64 * turn).cos());
            terms.sum()
        })
        .collect()
}

/// Σw²·N/(Σw)²: bins of noise that a bin collects.
pub(crate) fn noise_bins(cosines: Cosines) -> f64 {
    let first = cosines.first().copied().unwrap_or(1.0);
    1.0 + 0.5 * cosines.iter().skip(1).map(|a| (a / first).powi(2)).sum::<f64>()
}
