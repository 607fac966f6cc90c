//! The components of a second of light.

use crate::transform;
use crate::window::{self, FLAT_TOP, FLAT_TOP_BINS};

/// Mean amplitudes of pieces of a record under a flat-top window.
pub(crate) struct Amplitudes {
    /// Of each piece, bins 0 to N/2, relative to the mean of the record.
    pub pieces: Vec<Vec<f64>>,
    /// Distance of the bins in Hz.
    pub step_hz: f64,
    /// Standard uncertainty of an amplitude of one piece from noise, relative to the mean.
    pub noise: f64,
}

impl Amplitudes {
    /// Of pieces of `length_s`, or of the whole record where it is shorter. `noise_rel` is that of one sample.
    pub(crate) fn of(samples: &[f64], rate_hz: f64, length_s: f64, noise_rel: f64) -> Self {
        let length = ((length_s * rate_hz).round() as usize).clamp(1, samples.len());
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let pieces = samples.chunks_exact(length).map(|piece| {
            let mut amplitudes = transform::amplitudes(piece, FLAT_TOP);
            for amplitude in &mut amplitudes {
                *amplitude /= mean;
            }
            amplitudes
        });
        Self {
            pieces: pieces.collect(),
            step_hz: rate_hz / length as f64,
            // In the direction of the component: half of the power of a bin's noise.
            noise: noise_rel * (2.0 * window::noise_bins(FLAT_TOP) / length as f64).sqrt(),
        }
    }

    /// Root mean square over the pieces.
    pub(crate) fn mean(&self) -> Vec<f64> {
        let count = self.pieces.len().max(1) as f64;
        let bins = self.pieces.first().map_or(0, Vec::len);
        (0..bins)
            .map(|bin| (self.pieces.iter().map(|piece| piece[bin].powi(2)).sum::<f64>() / count).sqrt())
            .collect()
    }
}

/// (frequency in Hz, amplitude) of each component up to `to_hz`, the strongest first: a component takes the bins of the
/// window's lobe with it.
pub(crate) fn components(amplitudes: &[f64], step_hz: f64, to_hz: f64) -> Vec<(f64, f64)> {
    let last = ((to_hz / step_hz + 1e-9).floor() as usize).min(amplitudes.len().saturating_sub(1));
    let mut order: Vec<usize> = (1..=last).collect();
    order.sort_by(|a, b| amplitudes[*b].total_cmp(&amplitudes[*a]).then(a.cmp(b)));
    let mut taken = vec![false; amplitudes.len()];
    let mut found = Vec::new();
    for bin in order {
        if taken[bin] || amplitudes[bin] <= 0.0 {
            continue;
        }
        let from = bin.saturating_sub(FLAT_TOP_BINS);
        let to = (bin + FLAT_TOP_BINS).min(amplitudes.len() - 1);
        taken[from..=to].fill(true);
        found.push((bin as f64 * step_hz, amplitudes[bin]));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::FLAT_TOP_ERROR;

    #[test]
    fn a_sine_between_bins_keeps_its_amplitude_and_is_one_component() {
        for off in 0..20 {
            let f_hz = 100.0 + 0.05 * f64::from(off);
            let samples: Vec<f64> = (0..8000)
                .map(|k| 2.0 + 0.8 * (std::f64::consts::TAU * f_hz * f64::from(k) / 8000.0).sin())
                .collect();
            let of = Amplitudes::of(&samples, 8000.0, 1.0, 0.0);
            let found = components(&of.pieces[0], of.step_hz, 2000.0);
            let mean = samples.iter().sum::<f64>() / 8000.0;
            assert!(
                (found[0].1 * mean / 0.8 - 1.0).abs() < FLAT_TOP_ERROR + 1e-5,
                "{f_hz} Hz: {}",
                found[0].1
            );
            assert!((found[0].0 - f_hz).abs() <= 1.5, "{:?}", found[0]);
            // What is left of the mean lies below the window's lobe.
            let other = found[1..].iter().find(|(f_hz, _)| *f_hz > 5.0);
            assert!(
                other.is_some_and(|other| other.1 < 1e-3 * found[0].1),
                "{f_hz} Hz: {other:?}"
            );
        }
    }
}
