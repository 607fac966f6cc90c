//! One period in every visit of a half-plane, with a phase of its own in each: what a motor, a wheel or a belt does that
//! starts anew (averaged periodograms: Bartlett 1948).

use std::sync::Arc;

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::{FEWEST_PARTS, RARE};
use super::series::{ERRORS, Series};
use super::statistic::Test;
use crate::table::Coordinate;

/// Visits of fewer readings show no period.
const SHORTEST: usize = 12;
/// Visits at most: of longer records they are a sample.
const MOST: usize = 100;
/// Readings of a visit at most: its begin.
const LONGEST: usize = 256;

/// Powers of all visits together, at every frequency.
pub(super) struct Phases {
    errors: Arc<[Vec<f64>]>,
    /// From and to (exclusive) of every visit.
    visits: Vec<(usize, usize)>,
    /// In turns a reading.
    frequencies: Vec<f64>,
    /// Cosine and sine of every frequency at every reading of the longest visit.
    waves: Vec<Vec<(f64, f64)>>,
}

impl Phases {
    /// None where fewer than [`FEWEST_PARTS`] visits are long enough.
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let visits: Vec<(usize, usize)> = series
            .visits()
            .iter()
            .filter(|visit| visit.len() >= SHORTEST)
            .map(|visit| (visit[0], visit[0] + visit.len().min(LONGEST)))
            .collect();
        let visits: Vec<_> = visits
            .iter()
            .copied()
            .step_by(visits.len().div_ceil(MOST).max(1))
            .collect();
        let longest = visits.iter().map(|(from, to)| to - from).max()?;
        // From one period in a visit to nearly two readings a period; steps of half of what a visit resolves.
        let count = longest.min(128);
        let frequencies: Vec<f64> = (2..count).map(|k| 0.5 * k as f64 / count as f64).collect();
        let wave = |frequency: &f64| {
            let at = |k: usize| (std::f64::consts::TAU * frequency * k as f64).sin_cos();
            (0..longest).map(at).map(|(sine, cosine)| (cosine, sine)).collect()
        };
        (visits.len() >= FEWEST_PARTS).then(|| Self {
            errors: Arc::clone(&series.errors),
            visits,
            waves: frequencies.iter().map(wave).collect(),
            frequencies,
        })
    }

    /// Sum of the powers of all visits in σ², two expected of each, and how many visits have that error.
    fn power(&self, error: usize, frequency: usize, values: &[f64]) -> (f64, f64) {
        let (mut sum, mut count) = (0.0, 0.0);
        for &(from, to) in &self.visits {
            let (mut square, mut cosine, mut sine) = (0.0, 0.0, 0.0);
            let rows = self.errors[error][from..to].iter().zip(&values[from..to]);
            for ((error, value), wave) in rows.zip(&self.waves[frequency]) {
                square += error * error;
                cosine += error * value * wave.0;
                sine += error * value * wave.1;
            }
            if square > 0.0 {
                sum += 2.0 * (cosine * cosine + sine * sine) / square;
                count += 1.0;
            }
        }
        (sum, count)
    }
}

impl Test for Phases {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for error in 0..ERRORS.len() {
            for frequency in 0..self.frequencies.len() {
                let (sum, count) = self.power(error, frequency, values);
                if count < 4.0 {
                    continue;
                }
                // The cube root of a χ² is nearly normal (Wilson and Hilferty 1931).
                let spread = 1.0 / (9.0 * count);
                let z = ((0.5 * sum / count).cbrt() - (1.0 - spread)) / spread.sqrt();
                best.raise(0.5 * z.max(0.0).powi(2), frequency * ERRORS.len() + error);
            }
        }
        best
    }

    fn share(&self) -> f64 {
        RARE
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (frequency, error) = (strongest.place / ERRORS.len(), strongest.place % ERRORS.len());
        let period = self.frequencies[frequency].recip();
        let (sum, count) = self.power(error, frequency, &series.plain);
        let note = format!(
            "an error with a period of {} readings begins anew in every visit of a half-plane{}",
            digits(period),
            ERRORS[error]
        );
        Finding::new(Kind::Phases, Coordinate::Index, series.numbers(), strongest, note)
            .with_period(period)
            .explaining((sum - 2.0 * count * series.expected).max(0.0))
    }
}
