//! The short-term flicker severity of light.
//!
//! The chain of IEC TR 61547-1:2020: relative light, 0.05 Hz high-pass, sixth-order Butterworth low-pass at 35 Hz, the
//! weighting filter of lamp, eye and brain, square, 0.3 s smoothing, and the percentiles of IEC 61000-4-15.

use isolux_reduce::Quantity;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::filter::{Section, butterworth, high_pass, smoothing};
use crate::roots::{factors, roots};

/// Least sample rate in Hz.
pub(crate) const LEAST_RATE_HZ: f64 = 2000.0;
/// Least length of a record in s.
pub(crate) const LEAST_S: f64 = 180.0;
/// Beginning that is dropped while the filters settle, s.
const SETTLING_S: f64 = 20.0;
/// Corner of the low-pass in Hz.
const LOW_PASS_HZ: f64 = 35.0;
/// Factor on the smoothed square: 1 is the level that half of all people just perceive.
const SCALE: f64 = 1.101_603_155e6;
/// Weighting of lamp, eye and brain, from the constant term on: numerator and denominator in s.
const NUMERATOR: [f64; 5] = [0.0, 29_839.0, 2715.6, 44.758, 0.041_661];
const DENOMINATOR: [f64; 5] = [3_505_380.0, 534_820.0, 11_781.0, 196.32, 1.0];
/// Percentages of the time, and the weight of their mean level.
const PERCENTILES: [(&[f64], f64); 5] = [
    (&[0.1], 0.0314),
    (&[0.7, 1.0, 1.5], 0.0525),
    (&[2.2, 3.0, 4.0], 0.0657),
    (&[6.0, 8.0, 10.0, 13.0, 17.0], 0.28),
    (&[30.0, 50.0, 80.0], 0.08),
];
/// Records with noise of their own level that say what noise does, and their seed.
const DRAWS: u64 = 8;
const SEED: u64 = 0x0050_5354;

/// PstLM with its uncertainty; `noise_rel` is the noise of one sample relative to the mean.
pub(crate) fn measured(samples: &[f64], rate_hz: f64, noise_rel: f64) -> Quantity {
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let relative = || samples.iter().map(|value| value / mean - 1.0);
    let levels = sensation(relative(), rate_hz);
    let value = severity(levels.clone());
    // Of the two halves of the record: what another record of its length would give.
    let (first, second) = levels.split_at(levels.len() / 2);
    let halves = (severity(first.to_vec()) - severity(second.to_vec())).abs() / 2.0;
    // The bilinear transform moves frequencies f to tan(πf/fs)·fs/π; at the corner the chain falls with the fifth
    // power.
    let warped = 5.0 * (std::f64::consts::PI * LOW_PASS_HZ / rate_hz).powi(2) / 3.0;
    Quantity::new(
        value,
        "",
        [
            ("noise", of_noise(samples, mean, rate_hz, noise_rel)),
            ("sampling", value * warped / 3.0_f64.sqrt()),
            ("length of the record", halves),
        ],
    )
}

/// What the noise that is in the record does to it: as much as the same noise once more does. Means of samples to 2
/// kHz, where the filters pass nothing.
fn of_noise(samples: &[f64], mean: f64, rate_hz: f64, noise_rel: f64) -> f64 {
    if noise_rel == 0.0 {
        return 0.0;
    }
    let group = (rate_hz / LEAST_RATE_HZ).floor().max(1.0) as usize;
    let rate_hz = rate_hz / group as f64;
    let slow: Vec<f64> = samples
        .chunks_exact(group)
        .map(|chunk| chunk.iter().sum::<f64>() / group as f64 / mean - 1.0)
        .collect();
    let sigma = noise_rel / (group as f64).sqrt();
    let plain = severity(sensation(slow.iter().copied(), rate_hz));
    let squares: f64 = (0..DRAWS)
        .map(|draw| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(draw);
            let noisy = slow.iter().map(|value| {
                let normal: f64 = StandardNormal.sample(&mut random);
                value + sigma * normal
            });
            (severity(sensation(noisy, rate_hz)) - plain).powi(2)
        })
        .sum();
    (squares / DRAWS as f64).sqrt()
}

/// Instantaneous flicker sensation after the settling time.
fn sensation(relative: impl Iterator<Item = f64>, rate_hz: f64) -> Vec<f64> {
    let mut chain = vec![high_pass(0.05, rate_hz)];
    chain.extend(butterworth(6, LOW_PASS_HZ, rate_hz));
    chain.extend(weighting(rate_hz));
    let mut smooth = smoothing(0.3, rate_hz);
    let levels = relative.map(|light| {
        let weighted = chain.iter_mut().fold(light, |value, section| section.next(value));
        SCALE * smooth.next(weighted * weighted)
    });
    levels.skip((SETTLING_S * rate_hz).round() as usize).collect()
}

/// The weighting filter as second orders.
fn weighting(rate_hz: f64) -> Vec<Section> {
    let above = factors(&roots(&NUMERATOR));
    let below = factors(&roots(&DENOMINATOR));
    let lead = NUMERATOR[4] / DENOMINATOR[4];
    above
        .into_iter()
        .zip(below)
        .enumerate()
        .map(|(k, (above, below))| {
            let scale = if k == 0 { lead } else { 1.0 };
            Section::bilinear(above.map(|c| scale * c), below, rate_hz)
        })
        .collect()
}

/// Pst of the levels (IEC 61000-4-15, 5.7.2); 0 of none.
fn severity(mut levels: Vec<f64>) -> f64 {
    levels.sort_unstable_by(f64::total_cmp);
    let exceeded = |percent: f64| {
        let place = (1.0 - 0.01 * percent) * levels.len().saturating_sub(1) as f64;
        levels.get(place.round() as usize).copied().unwrap_or(0.0)
    };
    let sum: f64 = PERCENTILES
        .iter()
        .map(|(percents, weight)| {
            weight * percents.iter().map(|percent| exceeded(*percent)).sum::<f64>() / percents.len() as f64
        })
        .sum();
    sum.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::num_complex::Complex;

    /// Amplitudes whose mean sensation gives 1 where it is constant: at each of the percentiles. What of the double
    /// frequency the smoothing leaves comes on top.
    #[test]
    fn the_mean_sensation_of_just_perceptible_sines_is_that_of_one() {
        let weights: f64 = PERCENTILES.iter().map(|(_, weight)| weight).sum();
        for (amplitude, f_hz) in [(0.0746, 0.5), (0.00448, 8.8), (0.00683, 20.0), (0.0127, 33.3)] {
            let rate_hz = 5000.0;
            let light = (0..200 * 5000).map(|k| amplitude * (std::f64::consts::TAU * f_hz * k as f64 / rate_hz).sin());
            let levels = sensation(light, rate_hz);
            let mean = levels.iter().sum::<f64>() / levels.len() as f64;
            let of_mean = (weights * mean).sqrt();
            assert!((of_mean - 1.0).abs() < 4e-3, "{f_hz} Hz: {of_mean}");
        }
    }

    #[test]
    fn the_weighting_filter_is_its_transfer_function_at_high_rates_too() {
        for rate_hz in [2e3, 2e4, 1e5] {
            for f_hz in [0.5, 8.8, 25.0_f64] {
                let mut sections = weighting(rate_hz);
                let omega = std::f64::consts::TAU * f_hz;
                let s = Complex::new(0.0, omega);
                let polynomial = |c: &[f64; 5]| c.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * s + c);
                let expected = (polynomial(&NUMERATOR) / polynomial(&DENOMINATOR)).norm();
                // Correlated over the last whole periods of six seconds.
                let count = (6.0 * rate_hz) as usize;
                let from = count - (2.0 * rate_hz) as usize;
                let mut sum = Complex::new(0.0, 0.0);
                for k in 0..count {
                    let phase = omega * k as f64 / rate_hz;
                    let out = sections
                        .iter_mut()
                        .fold(phase.sin(), |value, section| section.next(value));
                    if k >= from {
                        sum += Complex::from_polar(out, -phase);
                    }
                }
                let gain = 2.0 * sum.norm() / (count - from) as f64;
                assert!(
                    (gain / expected - 1.0).abs() < 4e-3,
                    "{rate_hz}, {f_hz}: {gain}, {expected}"
                );
            }
        }
    }
}
