//! The stroboscopic effect visibility measure.
//!
//! SVM = (Σ (Cₘ/T(fₘ))^3.7)^(1/3.7) over the components up to 2 kHz, Cₘ their amplitudes relative to the mean (IEC TR
//! 63158:2018; CIE TN 006:2016).

use isolux_reduce::Quantity;

use crate::harmonics::{Amplitudes, components};
use crate::window::FLAT_TOP_ERROR;

/// Exponent of the sum.
const EXPONENT: f64 = 3.7;
/// Highest frequency in Hz.
pub(crate) const HIGHEST_HZ: f64 = 2000.0;
/// Least sample rate in Hz: twice the highest frequency.
pub(crate) const LEAST_RATE_HZ: f64 = 4000.0;
/// Least length of a record in s.
pub(crate) const LEAST_S: f64 = 1.0;

/// Amplitude relative to the mean at which the stroboscopic effect of a sine of `frequency_hz` is just visible:
/// 1/(1 + e^(−0.00518 (f − 306.6))) + 20 e^(−f/10).
pub fn threshold(frequency_hz: f64) -> f64 {
    1.0 / (1.0 + (-0.005_18 * (frequency_hz - 306.6)).exp()) + 20.0 * (-frequency_hz / 10.0).exp()
}

/// SVM of components (frequency in Hz, amplitude relative to the mean).
pub(crate) fn svm(components: &[(f64, f64)]) -> f64 {
    let sum: f64 = components
        .iter()
        .filter(|(frequency_hz, _)| *frequency_hz <= HIGHEST_HZ)
        .map(|(frequency_hz, amplitude)| (amplitude / threshold(*frequency_hz)).powf(EXPONENT))
        .sum();
    sum.powf(1.0 / EXPONENT)
}

/// ∂SVM/∂Cₘ of each component.
fn sensitivities(components: &[(f64, f64)], svm: f64) -> Vec<f64> {
    let each = components.iter().map(|(frequency_hz, amplitude)| {
        let threshold = threshold(*frequency_hz);
        if svm > 0.0 {
            (amplitude / threshold / svm).powf(EXPONENT - 1.0) / threshold
        } else {
            0.0
        }
    });
    each.collect()
}

/// The mean over the pieces with its uncertainty, and the amplitude just below half the sample rate relative to the
/// mean, which stands for what is folded into the band.
pub(crate) fn measured(amplitudes: &Amplitudes) -> (Quantity, f64) {
    let of_pieces: Vec<f64> = amplitudes
        .pieces
        .iter()
        .map(|piece| svm(&components(piece, amplitudes.step_hz, HIGHEST_HZ)))
        .collect();
    let count = of_pieces.len().max(1) as f64;
    let value = of_pieces.iter().sum::<f64>() / count;
    let mean = amplitudes.mean();
    let found = components(&mean, amplitudes.step_hz, HIGHEST_HZ);
    let sensitivities = sensitivities(&found, svm(&found));
    let squares: f64 = sensitivities.iter().map(|s| s * s).sum();
    let noise = amplitudes.noise * squares.sqrt() / count.sqrt();
    // Components of noise alone sum up to what no light gives.
    let alone: Vec<(f64, f64)> = found.iter().map(|(f, _)| (*f, amplitudes.noise)).collect();
    let floor = svm(&alone);
    let bias = value
        - (value.powf(EXPONENT) - floor.powf(EXPONENT))
            .max(0.0)
            .powf(1.0 / EXPONENT);
    let variation = if count > 1.0 {
        let square: f64 = of_pieces.iter().map(|piece| (piece - value).powi(2)).sum();
        let seen = (square / (count - 1.0) / count).sqrt();
        (seen * seen - noise * noise).max(0.0).sqrt()
    } else {
        0.0
    };
    // Steps have components above half the sample rate that are about as large as those just below it.
    let last = mean.len().saturating_sub(1);
    let folded = mean[last - last / 10..].iter().copied().fold(0.0, f64::max);
    let folded = if folded > 5.0 * amplitudes.noise { folded } else { 0.0 };
    let largest = sensitivities.iter().copied().fold(0.0, f64::max);
    let sampling = (value * FLAT_TOP_ERROR).hypot(largest * folded) / 3.0_f64.sqrt();
    let quantity = Quantity::new(
        value,
        "",
        [
            ("noise", noise.hypot(bias)),
            ("sampling", sampling),
            ("variation of the light", variation),
        ],
    );
    (quantity, folded)
}
