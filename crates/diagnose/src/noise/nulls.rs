//! Simulated records: the residuals in another order, correlated and refitted as the observed ones were.

use nalgebra::DMatrix;
use rand::seq::SliceRandom as _;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use super::finding::Strongest;
use super::limits::{FEWEST_NULLS, NULL_VALUES, NULLS, TOGETHER};
use super::residuals::Residuals;
use super::series::Series;
use super::statistic::Test;
use crate::whitening::MOST_CORRELATED;

/// The simulated records are others than those of the scan.
const APART: u64 = 0x6e6f_6973;
/// Records that are drawn and refitted together, and the values in them: long records go alone, or they would take
/// hundreds of megabytes.
const BATCH: usize = 40;
const BATCH_VALUES: usize = 200_000;

/// What every test makes of the simulated records.
pub(super) struct Nulls {
    /// Of each test alone.
    tails: Vec<Tail>,
    /// ln of the share of the false alarms that each test gets.
    ln_shares: Vec<f64>,
    /// Of the strongest of all, and of the strongest few together.
    together: Vec<(usize, Tail)>,
    /// Of the stronger of these.
    strongest: Tail,
}

impl Nulls {
    /// Up to `most` simulated records; record `k` depends on `seed` and `k` alone.
    pub(super) fn new(
        residuals: &Residuals<'_>,
        series: &Series<'_>,
        tests: &[Box<dyn Test>],
        most: usize,
        seed: u64,
    ) -> Self {
        let count = (NULL_VALUES / series.len().max(1))
            .clamp(FEWEST_NULLS, NULLS)
            .min(most.max(FEWEST_NULLS));
        let batch = (BATCH_VALUES / residuals.rows.len().max(1)).clamp(1, BATCH);
        let batches: Vec<usize> = (0..count).step_by(batch).collect();
        let of = |&first: &usize| -> Vec<Vec<f64>> {
            let numbers = first..(first + batch).min(count);
            simulated(residuals, series, numbers, seed)
                .iter()
                .map(|values| tests.iter().map(|test| test.strongest(values).half_square).collect())
                .collect()
        };
        let all: Vec<Vec<f64>> = batches.par_iter().flat_map_iter(of).collect();
        let tails: Vec<Tail> = (0..tests.len())
            .map(|test| Tail::new(all.iter().map(|record| record[test]).collect()))
            .collect();
        let ln_shares: Vec<f64> = tests.iter().map(|test| test.share().ln()).collect();
        let scores: Vec<Vec<f64>> = all
            .iter()
            .map(|record| scores(record.iter().copied(), &tails, &ln_shares))
            .collect();
        let together: Vec<(usize, Tail)> = TOGETHER
            .into_iter()
            .map(|few| (few, Tail::new(scores.iter().map(|scores| sum(scores, few)).collect())))
            .collect();
        let strongest = Tail::new(scores.iter().map(|scores| strongest_of(scores, &together)).collect());
        Self {
            tails,
            ln_shares,
            together,
            strongest,
        }
    }

    /// The probability of one test alone.
    pub(super) fn alone(&self, test: usize, half_square: f64) -> f64 {
        (-self.tails[test].score(half_square)).exp()
    }

    /// The probability of the strongest of all tests, or of the strongest few together where that is less: what one
    /// test finds clearly and what several find in part.
    pub(super) fn combined(&self, observed: &[Strongest]) -> f64 {
        let half_squares = observed.iter().map(|strongest| strongest.half_square);
        let scores = scores(half_squares, &self.tails, &self.ln_shares);
        (-self.strongest.score(strongest_of(&scores, &self.together))).exp()
    }
}

/// −ln of the probability of each test alone over its share, highest first: a weighted Bonferroni (Holm 1979).
fn scores(half_squares: impl Iterator<Item = f64>, tails: &[Tail], ln_shares: &[f64]) -> Vec<f64> {
    let of = |((half_square, tail), ln_share): ((f64, &Tail), &f64)| (tail.score(half_square) + ln_share).max(0.0);
    let mut scores: Vec<f64> = half_squares.zip(tails).zip(ln_shares).map(of).collect();
    scores.sort_by(|a, b| b.total_cmp(a));
    scores
}

fn sum(scores: &[f64], few: usize) -> f64 {
    scores.iter().take(few).sum()
}

/// −ln of the least probability of so many tests together.
fn strongest_of(scores: &[f64], together: &[(usize, Tail)]) -> f64 {
    let of = |(few, tail): &(usize, Tail)| tail.score(sum(scores, *few));
    together.iter().map(of).fold(0.0, f64::max)
}

/// The upper tail of simulated statistics: what was simulated, and an exponential law beyond the highest twentieth.
struct Tail {
    rising: Vec<f64>,
    from: f64,
    mean: f64,
}

impl Tail {
    fn new(mut values: Vec<f64>) -> Self {
        /// Simulations that the tail of a maximum of half squares, e⁻ˣ, is worth.
        const EXPECTED: f64 = 10.0;
        values.sort_by(f64::total_cmp);
        let start = values.len() * 19 / 20;
        let from = values.get(start).copied().unwrap_or(0.0);
        let beyond = values.get(start..).unwrap_or(&[]);
        let sum: f64 = beyond.iter().map(|value| value - from).sum();
        Self {
            mean: (sum + EXPECTED) / (beyond.len() as f64 + EXPECTED),
            rising: values,
            from,
        }
    }

    /// −ln of the probability of so much or more.
    fn score(&self, value: f64) -> f64 {
        let n = self.rising.len();
        if value > self.from {
            return -(0.05_f64.ln()) + (value - self.from) / self.mean;
        }
        let above = n - self.rising.partition_point(|known| *known < value);
        -((above + 1) as f64 / (n + 1) as f64).min(1.0).ln()
    }
}

/// Simulated records of unit variance, one vector each.
fn simulated(
    residuals: &Residuals<'_>,
    series: &Series<'_>,
    numbers: std::ops::Range<usize>,
    seed: u64,
) -> Vec<Vec<f64>> {
    let rows = residuals.rows.len();
    let u_rho = residuals.u_rho;
    let whiten = residuals.sequence.whitening(residuals.rho);
    let mut drawn = DMatrix::zeros(rows, numbers.len());
    for (k, mut column) in numbers.zip(drawn.column_iter_mut()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ APART);
        rng.set_stream(k as u64 + 1);
        let mut values = series.held.clone();
        values.shuffle(&mut rng);
        let values: Vec<f64> = values
            .iter()
            .zip(&series.share)
            .map(|(value, share)| value * share)
            .collect();
        let mut all = series.spread(&values, rows);
        if u_rho > 0.0 {
            let off: f64 = rng.sample(StandardNormal);
            residuals.sequence.colour(
                (residuals.rho + u_rho * off).clamp(0.0, MOST_CORRELATED),
                all.as_mut_slice(),
            );
            whiten(all.as_mut_slice());
        }
        column.copy_from(&all);
    }
    residuals.refitted.project_out(&mut drawn);
    drawn
        .column_iter()
        .map(|column| {
            let mut values: Vec<f64> = series
                .place
                .iter()
                .zip(&series.share)
                .map(|(&i, share)| column[i] / share)
                .collect();
            let size = (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
            if size > 0.0 {
                for value in &mut values {
                    *value /= size;
                }
            }
            values
        })
        .collect()
}
