//! Quantization: which steps of an analogue-to-digital converter are worth trying, by the data.
//!
//! What rounding does to a signal repeats along it with the step as period. The wrong period looks like nothing, so
//! that a grid of sizes would need thousands; a periodogram of what is left over the expected signal tells the few that
//! could be.

use std::collections::BTreeMap;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::forward::{Forward, Hypothesis, Searchable};
use crate::known::Known;
use crate::reference::Errors;

/// Sizes that are tried of those that were looked at.
const TRIED: usize = 6;
/// The finest steps that are looked for: so many in the largest signal (a converter of 12 bits).
const FINEST: f64 = 4096.0;
/// Significance in σ below which no step can be found among all others.
const LEAST_SIGMA: f64 = 6.0;
/// Frequencies in the time in which the largest signal turns once.
const OVERSAMPLED: f64 = 4.0;
/// Cells of signal in the finest step.
const CELLS: f64 = 8.0;

/// A model whose effects with a period along the signal have the sizes that the data suggest.
pub struct Stepped<'a> {
    forward: &'a dyn Forward,
    effects: Vec<Searchable>,
}

impl<'a> Stepped<'a> {
    /// `expected` is the light that is there, `left` the readings less that, `u` their standard uncertainties.
    pub fn of(forward: &'a dyn Forward, expected: &DVector<f64>, left: &DVector<f64>, u: &DVector<f64>) -> Self {
        let mut effects = forward.effects().to_vec();
        if let Some(full_scale) = forward.full_scale() {
            let signals: Vec<Signal> = full_scale
                .iter()
                .enumerate()
                .filter(|(row, full_scale)| **full_scale > 0.0 && expected[*row] > 0.0)
                .map(|(row, full_scale)| Signal {
                    expected: expected[row] / full_scale,
                    left: left[row] / full_scale,
                    weight: (full_scale / u[row]).powi(2),
                })
                .collect();
            for effect in effects.iter_mut().filter(|effect| effect.period_of_signal) {
                let (sizes, looked_at) = sizes(&signals, effect.plausible[0]);
                if !sizes.is_empty() {
                    effect.shapes = vec![Vec::new(); sizes.len()];
                    effect.step_share = sizes.iter().map(|size| size / effect.step[0]).collect();
                    effect.chosen_from = looked_at;
                }
            }
        }
        Self { forward, effects }
    }
}

impl Forward for Stepped<'_> {
    fn nuisances(&self) -> usize {
        self.forward.nuisances()
    }

    fn nuisance_weights(&self) -> Vec<f64> {
        self.forward.nuisance_weights()
    }

    fn shape_terms(&self) -> Vec<Option<usize>> {
        self.forward.shape_terms()
    }

    fn common_errors(&self) -> Errors {
        self.forward.common_errors()
    }

    fn known(&self) -> Vec<Known> {
        self.forward.known()
    }

    fn effects(&self) -> &[Searchable] {
        &self.effects
    }

    fn full_scale(&self) -> Option<DVector<f64>> {
        self.forward.full_scale()
    }

    fn read_out(&self, effect: usize, amplitude: f64, prediction: &DVector<f64>) -> Option<DVector<f64>> {
        self.forward.read_out(effect, amplitude, prediction)
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        self.forward.predict(nuisance, hypotheses)
    }
}

/// A signal in full scales, what a model leaves of it, and 1/u².
#[derive(Debug, Clone, Copy)]
struct Signal {
    expected: f64,
    left: f64,
    weight: f64,
}

/// The sizes up to `largest` that explain most, in full scales, and how many were looked at.
fn sizes(signals: &[Signal], largest: f64) -> (Vec<f64>, usize) {
    let top = signals.iter().map(|one| one.expected).fold(0.0, f64::max);
    let weight: f64 = signals.iter().map(|one| one.weight).sum();
    // Rounding scatters by a step over √12.
    let seen = LEAST_SIGMA * (12.0 / weight).sqrt();
    let least = seen.max(top / FINEST);
    if least >= largest {
        return (Vec::new(), 0);
    }
    let spacing = 1.0 / (OVERSAMPLED * top);
    let count = ((least.recip() - largest.recip()) / spacing).ceil() as usize;
    let frequency = |k: usize| largest.recip() + k as f64 * spacing;
    let cells = cells(signals, least / CELLS);
    let gains = periodogram(&cells, weight, frequency, count);
    let is_peak = |k: usize| {
        let beside = [k.checked_sub(1).and_then(|k| gains.get(k)), gains.get(k + 1)];
        beside.into_iter().flatten().all(|other| *other <= gains[k])
    };
    let mut peaks: Vec<usize> = (0..count).filter(|&k| is_peak(k)).collect();
    peaks.sort_by(|a, b| gains[*b].total_cmp(&gains[*a]));
    peaks.truncate(4 * TRIED);
    let mut found: Vec<(f64, f64)> = peaks
        .par_iter()
        .map(|&k| refined(signals, frequency(k), spacing))
        .collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.truncate(TRIED);
    (
        found.into_iter().map(|(frequency, _)| frequency.recip()).collect(),
        count,
    )
}

/// Signals that differ by less than a step's phase tells, taken together: weight · left, and the expected signal.
fn cells(signals: &[Signal], width: f64) -> Vec<(f64, f64)> {
    let mut cells: BTreeMap<u64, (f64, f64, f64)> = BTreeMap::new();
    for one in signals {
        let cell = cells.entry((one.expected / width) as u64).or_default();
        cell.0 += one.weight * one.left;
        cell.1 += one.weight;
        cell.2 += one.weight * one.expected;
    }
    cells
        .into_values()
        .map(|(left, weight, expected)| (left, expected / weight))
        .collect()
}

/// What the first harmonic of a rounding explains at each frequency, in σ².
fn periodogram(cells: &[(f64, f64)], weight: f64, frequency: impl Fn(usize) -> f64 + Sync, count: usize) -> Vec<f64> {
    /// Frequencies that are reached from one by turning on.
    const TOGETHER: usize = 128;
    let starts: Vec<usize> = (0..count).step_by(TOGETHER).collect();
    let some = |&start: &usize| -> Vec<f64> {
        let number = TOGETHER.min(count - start);
        let (first, next) = (frequency(start), frequency(start + 1));
        let mut sums = vec![0.0; number];
        for &(left, expected) in cells {
            let (mut sine, mut cosine) = (std::f64::consts::TAU * first * expected).sin_cos();
            let (by_sine, by_cosine) = (std::f64::consts::TAU * (next - first) * expected).sin_cos();
            for sum in &mut sums {
                *sum += left * sine;
                (sine, cosine) = (sine * by_cosine + cosine * by_sine, cosine * by_cosine - sine * by_sine);
            }
        }
        let gain = |(k, sum): (usize, f64)| {
            // Rounding less the signal begins with −step/π · sin.
            let amplitude = (std::f64::consts::PI * frequency(start + k)).recip();
            -2.0 * amplitude * sum - 0.5 * amplitude * amplitude * weight
        };
        sums.into_iter().enumerate().map(gain).collect()
    };
    starts.par_iter().flat_map_iter(some).collect()
}

/// The frequency near one whose rounding explains most, and how much, in σ².
fn refined(signals: &[Signal], frequency: f64, spacing: f64) -> (f64, f64) {
    /// Places to both sides.
    const BESIDE: i32 = 8;
    let explained = |frequency: f64| -> f64 {
        let of = |one: &Signal| {
            let pattern = (one.expected * frequency).round() / frequency - one.expected;
            one.weight * pattern * (2.0 * one.left - pattern)
        };
        signals.iter().map(of).sum()
    };
    let mut best = (frequency, explained(frequency));
    for width in [spacing, spacing / f64::from(BESIDE)] {
        let middle = best.0;
        for k in -BESIDE..=BESIDE {
            let tried = middle + width * f64::from(k) / f64::from(BESIDE);
            let value = explained(tried);
            if value > best.1 {
                best = (tried, value);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::*;

    fn signals(step: f64, u: f64, seed: u64) -> Vec<Signal> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..5000)
            .map(|i| {
                let expected = 0.1 + 0.8 * f64::from(i) / 5000.0;
                let noise: f64 = rng.sample(StandardNormal);
                let rounded = if step > 0.0 {
                    (expected / step).round() * step
                } else {
                    expected
                };
                Signal {
                    expected,
                    left: rounded - expected + u * noise,
                    weight: u.powi(-2),
                }
            })
            .collect()
    }

    #[test]
    fn a_step_of_half_the_noise_is_found_to_a_part_of_its_phase() {
        for (seed, step) in [(1, 6e-4), (2, 1.7e-3), (3, 0.019)] {
            let (sizes, looked_at) = sizes(&signals(step, 1.2e-3, seed), 0.02);
            // Over the whole signal the phase is right to a fifth of a turn.
            assert!((0.9 / sizes[0] - 0.9 / step).abs() < 0.2, "{step}: {sizes:?}");
            assert!(looked_at > 3000 && sizes.len() <= TRIED, "{looked_at}");
        }
    }

    #[test]
    fn steps_that_nothing_could_show_are_not_looked_for() {
        assert_eq!(sizes(&signals(0.0, 0.5, 4), 0.02), (Vec::new(), 0));
    }
}
