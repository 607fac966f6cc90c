//! Means of readings that belong together and wander more than independent readings let them.

use super::finding::{Finding, Kind, Strongest};
use super::limits::{FEWEST_PARTS, MEANS, PIECES};
use super::series::Series;
use super::statistic::Test;
use crate::table::Coordinate;

/// Means of successive readings that wander more than independent readings let them.
pub(super) struct Means {
    rows: usize,
}

impl Means {
    pub(super) fn new(series: &Series<'_>) -> Self {
        Self { rows: series.len() }
    }
}

impl Test for Means {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (place, &length) in MEANS
            .iter()
            .enumerate()
            .filter(|(_, length)| FEWEST_PARTS * **length <= self.rows)
        {
            let blocks = values.chunks_exact(length);
            let count = blocks.len() as f64;
            let sum: f64 = blocks
                .map(|block| block.iter().sum::<f64>().powi(2) / length as f64)
                .sum();
            let z = (sum - count) / (2.0 * count).sqrt();
            best.raise(0.5 * z.max(0.0).powi(2), place);
        }
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let length = MEANS[strongest.place];
        let range = [series.index[0], series.index[series.len() - 1]];
        let note = format!("the means of {length} successive readings wander");
        Finding::new(Kind::Means, Coordinate::Index, range, strongest, note)
    }
}

/// The same for pieces of the visits of half-planes: a level of its own in each, whatever the smooth terms follow.
pub(super) struct Visits {
    /// From and to (exclusive) of every piece, for each number of pieces in a visit.
    pieces: Vec<(usize, Vec<(usize, usize)>)>,
}

/// Fewer readings are no piece.
const SHORTEST: usize = 3;

impl Visits {
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let visits = series.visits();
        let split = |parts: usize| -> Option<(usize, Vec<(usize, usize)>)> {
            let pieces: Vec<(usize, usize)> = visits
                .iter()
                .filter(|visit| visit.len() >= SHORTEST * parts)
                .flat_map(|visit| {
                    let at = move |k: usize| visit[0] + k * visit.len() / parts;
                    (0..parts).map(move |k| (at(k), at(k + 1)))
                })
                .collect();
            (pieces.len() >= FEWEST_PARTS).then_some((parts, pieces))
        };
        let pieces: Vec<_> = PIECES.into_iter().filter_map(split).collect();
        (!pieces.is_empty()).then_some(Self { pieces })
    }
}

impl Test for Visits {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (place, (_, pieces)) in self.pieces.iter().enumerate() {
            let count = pieces.len() as f64;
            let of = |&(from, to): &(usize, usize)| values[from..to].iter().sum::<f64>().powi(2) / (to - from) as f64;
            let z = (pieces.iter().map(of).sum::<f64>() - count) / (2.0 * count).sqrt();
            best.raise(0.5 * z.max(0.0).powi(2), place);
        }
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (parts, pieces) = &self.pieces[strongest.place];
        let note = match parts {
            1 => "each visit of a half-plane has a level of its own".to_owned(),
            _ => format!("each of {parts} parts of the visits of half-planes has a level of its own"),
        };
        let numbers = [series.index[0], series.index[series.len() - 1]];
        let of = |&(from, to): &(usize, usize)| {
            series.plain[from..to].iter().sum::<f64>().powi(2) / (to - from) as f64 - series.expected
        };
        let explained = pieces.iter().map(of).sum::<f64>().max(0.0);
        Finding::new(Kind::Visits, Coordinate::Index, numbers, strongest, note).explaining(explained)
    }
}
