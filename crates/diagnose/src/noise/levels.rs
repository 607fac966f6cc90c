//! Readings of one γ or level of the light whose mean is off, however often they were visited (analysis of
//! variance: Fisher 1925): a wheel that is not round, codes that are missing.
//!
//! The error of a mean is added, relative to the light, one of the angle γ, or in proportion to the noise.

use std::collections::HashMap;
use std::sync::Arc;

use super::finding::{Finding, Kind, Strongest};
use super::limits::{ALIKE, FEWEST_PARTS, RARE};
use super::series::{ERRORS, Series};
use super::statistic::Test;
use crate::table::{Coordinate, Light};

/// A row that is in no group.
const NOWHERE: u32 = u32::MAX;

/// One way to divide the readings.
struct Partition {
    note: String,
    /// The group of each row.
    groups: Vec<u32>,
    /// For each way of erring, the squared length of the error in each group.
    squares: Vec<Vec<f64>>,
    /// Groups with rows of that error.
    counts: Vec<f64>,
}

/// Partitions by direction and light.
pub(super) struct Levels {
    errors: Arc<[Vec<f64>]>,
    partitions: Vec<Partition>,
}

impl Levels {
    /// Adds the partition whose row `i` is in the group of its key; nothing where the groups are too few or mostly of
    /// one row.
    fn add<K: std::hash::Hash + Eq>(&mut self, note: &str, rows: usize, key: impl Fn(usize) -> Option<K>) {
        let mut known: HashMap<K, u32> = HashMap::new();
        let groups: Vec<u32> = (0..rows)
            .map(|i| {
                let next = known.len() as u32;
                key(i).map_or(NOWHERE, |key| *known.entry(key).or_insert(next))
            })
            .collect();
        let members = groups.iter().filter(|group| **group != NOWHERE).count();
        if known.len() < FEWEST_PARTS || members < 2 * known.len() {
            return;
        }
        let squares: Vec<Vec<f64>> = self
            .errors
            .iter()
            .map(|error| {
                let mut squares = vec![0.0; known.len()];
                for (&group, error) in groups.iter().zip(error).filter(|(group, _)| **group != NOWHERE) {
                    squares[group as usize] += error * error;
                }
                squares
            })
            .collect();
        let count = |squares: &Vec<f64>| squares.iter().filter(|square| **square > 0.0).count() as f64;
        self.partitions.push(Partition {
            note: note.to_owned(),
            groups,
            counts: squares.iter().map(count).collect(),
            squares,
        });
    }

    /// None where there are too few groups of each.
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let mut all = Self {
            errors: Arc::clone(&series.errors),
            partitions: Vec::new(),
        };
        let tenths = |angle_deg: f64| (10.0 * angle_deg).round() as i64;
        let illuminated = |i: usize| {
            let row = series.rows[i];
            (row.light == Light::Lit && row.c_deg.is_finite() && row.gamma_deg.is_finite()).then_some(row)
        };
        let n = series.len();
        all.add("each γ has a level of its own", n, |i| {
            illuminated(i).map(|row| tenths(row.gamma_deg))
        });
        all.add("each γ has a level of its own in each direction of travel", n, |i| {
            illuminated(i).map(|row| (tenths(row.gamma_deg), row.travel as i64))
        });
        let mut rising: Vec<usize> = (0..n).filter(|&i| illuminated(i).is_some()).collect();
        rising.sort_by(|&a, &b| series.level[a].total_cmp(&series.level[b]));
        let mut rank = vec![None; n];
        for (k, &i) in rising.iter().enumerate() {
            rank[i] = Some(k / ALIKE);
        }
        all.add("each level of the light has an error of its own", n, |i| rank[i]);
        (!all.partitions.is_empty()).then_some(all)
    }

    /// Squared mean of each group in σ², for one way of erring.
    fn means(&self, partition: &Partition, error: usize, values: &[f64]) -> f64 {
        let mut sums = vec![0.0; partition.squares[error].len()];
        for ((&group, value), error) in partition.groups.iter().zip(values).zip(&self.errors[error]) {
            if group != NOWHERE {
                sums[group as usize] += value * error;
            }
        }
        let of = |(sum, square): (&f64, &f64)| if *square > 0.0 { sum * sum / square } else { 0.0 };
        sums.iter().zip(&partition.squares[error]).map(of).sum()
    }
}

impl Test for Levels {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (place, partition) in self.partitions.iter().enumerate() {
            for (error, &count) in partition.counts.iter().enumerate() {
                if count < FEWEST_PARTS as f64 {
                    continue;
                }
                // The cube root of a χ² is nearly normal (Wilson and Hilferty 1931).
                let spread = 2.0 / (9.0 * count);
                let root = (self.means(partition, error, values) / count).cbrt();
                let z = (root - (1.0 - spread)) / spread.sqrt();
                best.raise(0.5 * z.max(0.0).powi(2), place * ERRORS.len() + error);
            }
        }
        best
    }

    fn share(&self) -> f64 {
        RARE
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (place, error) = (strongest.place / ERRORS.len(), strongest.place % ERRORS.len());
        let partition = &self.partitions[place];
        let note = format!("{}{}", partition.note, ERRORS[error]);
        let numbers = [series.index[0], series.index[series.len() - 1]];
        let expected = partition.counts[error] * series.expected;
        let explained = (self.means(partition, error, &series.plain) - expected).max(0.0);
        Finding::new(Kind::Levels, Coordinate::Index, numbers, strongest, note).explaining(explained)
    }
}
