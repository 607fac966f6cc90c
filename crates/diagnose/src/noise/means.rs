//! Means of readings that belong together and wander more than independent readings let them: of successive readings,
//! of visits and their pieces, of one γ or level of the light (analysis of variance: Fisher 1925).

use std::sync::Arc;

use super::finding::{Finding, Kind, Strongest};
use super::limits::{FEWEST_PARTS, RARE};
use super::series::{ERRORS, Series};
use super::statistic::Test;
use crate::patterns::parts;
use crate::table::Coordinate;

/// One way to divide the readings.
struct Partition {
    note: String,
    parts: Vec<Vec<usize>>,
    /// For each way of erring, the squared length of the error in each part.
    squares: Vec<Vec<f64>>,
    /// Parts with rows of that error.
    counts: Vec<f64>,
}

/// Partitions of one kind. The error of a mean is in proportion to the noise, or in any of the ways of erring.
pub(super) struct Means {
    kind: Kind,
    ways: usize,
    errors: Arc<[Vec<f64>]>,
    partitions: Vec<Partition>,
}

impl Means {
    /// Of successive readings.
    pub(super) fn successive(series: &Series<'_>) -> Option<Self> {
        Self::new(series, Kind::Means, 1, parts::successive(series))
    }

    /// Of visits of half-planes and their pieces.
    pub(super) fn visits(series: &Series<'_>) -> Option<Self> {
        Self::new(series, Kind::Visits, 1, parts::pieces(series))
    }

    /// Of directions and light.
    pub(super) fn levels(series: &Series<'_>) -> Option<Self> {
        Self::new(series, Kind::Levels, ERRORS.len(), parts::levels(series))
    }

    /// None where all partitions have too few parts, or parts that are mostly of one row.
    fn new(series: &Series<'_>, kind: Kind, ways: usize, all: Vec<(String, Vec<Vec<usize>>)>) -> Option<Self> {
        let partition = |(note, parts): (String, Vec<Vec<usize>>)| {
            let members: usize = parts.iter().map(Vec::len).sum();
            let square = |error: &Vec<f64>| -> Vec<f64> {
                let of = |part: &Vec<usize>| part.iter().map(|&i| error[i] * error[i]).sum();
                parts.iter().map(of).collect()
            };
            let squares: Vec<Vec<f64>> = series.errors[..ways].iter().map(square).collect();
            let count = |squares: &Vec<f64>| squares.iter().filter(|square| **square > 0.0).count() as f64;
            (parts.len() >= FEWEST_PARTS && members >= 2 * parts.len()).then(|| Partition {
                note,
                counts: squares.iter().map(count).collect(),
                squares,
                parts,
            })
        };
        let partitions: Vec<Partition> = all.into_iter().filter_map(partition).collect();
        (!partitions.is_empty()).then(|| Self {
            kind,
            ways,
            errors: Arc::clone(&series.errors),
            partitions,
        })
    }

    /// Squared means of all parts together in σ², for one way of erring.
    fn means(&self, partition: &Partition, way: usize, values: &[f64]) -> f64 {
        let error = &self.errors[way];
        let of = |(part, square): (&Vec<usize>, &f64)| {
            let sum: f64 = part.iter().map(|&i| values[i] * error[i]).sum();
            if *square > 0.0 { sum * sum / square } else { 0.0 }
        };
        partition.parts.iter().zip(&partition.squares[way]).map(of).sum()
    }

    /// How far the sum of so many squared means is above its expectation, in its standard deviation.
    fn significance(&self, sum: f64, count: f64) -> f64 {
        if self.kind == Kind::Levels {
            // The cube root of a χ² is nearly normal (Wilson and Hilferty 1931).
            let spread = 2.0 / (9.0 * count);
            return ((sum / count).cbrt() - (1.0 - spread)) / spread.sqrt();
        }
        (sum - count) / (2.0 * count).sqrt()
    }
}

impl Test for Means {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (place, partition) in self.partitions.iter().enumerate() {
            for (way, &count) in partition.counts.iter().enumerate() {
                if count < FEWEST_PARTS as f64 {
                    continue;
                }
                let z = self.significance(self.means(partition, way, values), count);
                best.raise(0.5 * z.max(0.0).powi(2), place * self.ways + way);
            }
        }
        best
    }

    fn share(&self) -> f64 {
        if self.kind == Kind::Levels { RARE } else { 1.0 }
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (partition, way) = (
            &self.partitions[strongest.place / self.ways],
            strongest.place % self.ways,
        );
        let note = format!("{}{}", partition.note, ERRORS[way]);
        let finding = Finding::new(self.kind, Coordinate::Index, series.numbers(), strongest, note);
        if self.kind == Kind::Means {
            return finding;
        }
        let expected = partition.counts[way] * series.expected;
        finding.explaining((self.means(partition, way, &series.plain) - expected).max(0.0))
    }
}
