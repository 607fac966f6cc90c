//! The noise of a record, from the record itself.

use crate::transform;
use crate::window::{self, BLACKMAN_HARRIS};

/// Longest part of a record that the noise is read from.
const LONGEST: usize = 1 << 18;
/// Median over mean of the squares of complex Gaussian noise, ln 2.
const MEDIAN: f64 = std::f64::consts::LN_2;

/// Values that a record must have at least for their smallest step to be the recorder's: light of two levels has one.
const LEAST_VALUES: usize = 16;

/// Standard deviation of one sample, in units of the samples. Two estimates are both too large where their assumption
/// fails, and the smaller one counts: between the components in the upper half of the band there is noise alone (sharp
/// edges fold into it); light changes smoothly from sample to sample (fast light does not).
pub(crate) fn of(samples: &[f64]) -> f64 {
    of_spectrum(samples).min(of_differences(samples))
}

fn of_spectrum(samples: &[f64]) -> f64 {
    let samples = &samples[..samples.len().min(LONGEST)];
    let amplitudes = transform::amplitudes(samples, BLACKMAN_HARRIS);
    let mut upper: Vec<f64> = amplitudes[amplitudes.len() / 2..].iter().map(|a| a * a).collect();
    upper.sort_by(f64::total_cmp);
    let mean_square = upper.get(upper.len() / 2).copied().unwrap_or(0.0) / MEDIAN;
    // A bin's amplitude has the mean square 4 σ² · noise bins / N.
    (mean_square * samples.len() as f64 / (4.0 * window::noise_bins(BLACKMAN_HARRIS))).sqrt()
}

/// Fourth differences, of which white noise has the variance 70 σ².
pub(crate) fn of_differences(samples: &[f64]) -> f64 {
    let mut fourth: Vec<f64> = samples
        .windows(5)
        .take(LONGEST)
        .map(|x| (x[0] - 4.0 * x[1] + 6.0 * x[2] - 4.0 * x[3] + x[4]).abs())
        .collect();
    fourth.sort_by(f64::total_cmp);
    // The median of |normal| is 0.6745 σ.
    fourth.get(fourth.len() / 2).copied().unwrap_or(0.0) / (0.674_49 * 70.0_f64.sqrt())
}

/// Smallest step between samples that differ: the resolution of the record, in units of the samples; 0 where all are
/// alike, or where there are too few values.
pub(crate) fn resolution(samples: &[f64]) -> f64 {
    let mut values: Vec<f64> = samples.iter().copied().take(LONGEST).collect();
    values.sort_by(f64::total_cmp);
    let span = values
        .last()
        .zip(values.first())
        .map_or(0.0, |(last, first)| last - first);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    // What the subtraction of a dark level leaves in the last bits is no step.
    let steps: Vec<f64> = steps.filter(|step| *step > 1e-9 * span).collect();
    if steps.len() + 1 < LEAST_VALUES {
        return 0.0;
    }
    steps.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, Normal};

    use super::*;

    #[test]
    fn noise_is_found_under_light_of_many_harmonics() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let normal = Normal::new(0.0, 0.01).unwrap();
        let samples: Vec<f64> = (0..20_000)
            .map(|k| {
                // Edges of 0.5 ms: sharper ones fold into the band, and no record can tell that from noise.
                let phase = (f64::from(k) * 100.37 / 20e3).fract();
                let lit = (phase / 0.05).min((0.5 - phase) / 0.05).clamp(0.0, 1.0);
                1.0 + lit + normal.sample(&mut random)
            })
            .collect();
        let found = of(&samples);
        assert!((found / 0.01 - 1.0).abs() < 0.05, "{found}");
        let guess = of_differences(&samples);
        assert!((0.009..0.012).contains(&guess), "{guess}");
    }

    #[test]
    fn the_step_of_a_recorder_is_its_resolution() {
        let samples: Vec<f64> = (0..500)
            .map(|k| ((0.1 * f64::from(k)).sin() * 50.0).round() * 0.02 + 0.7)
            .collect();
        assert!((resolution(&samples) - 0.02).abs() < 1e-9);
        assert_eq!(resolution(&[3.0; 100]), 0.0);
        let two: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        assert_eq!(resolution(&two), 0.0);
    }
}
