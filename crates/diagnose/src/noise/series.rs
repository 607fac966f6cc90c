//! The residuals in the order in which they were taken, as the tests of the noise see them.

use std::sync::Arc;

use nalgebra::DVector;

use super::limits::{CLIP, PAUSE, ROUNDED};
use super::residuals::Residuals;
use crate::table::{Light, ObservationKind, Row, visits};

/// The ways in which a reading errs, as a note says them: in proportion to the noise, to the light, by as much
/// wherever it is, and by the angle at which it is taken.
pub(super) const ERRORS: [&str; 4] = ["", " (relative to the light)", " (added)", " (of the angle γ)"];
/// Their places in [`Series::errors`].
pub(super) const RELATIVE: usize = 1;
pub(super) const ADDED: usize = 2;

/// Residuals of one kind of rows, in the order in which they were taken.
pub(crate) struct Series<'a> {
    pub(crate) source: ObservationKind,
    pub(crate) rows: Vec<&'a Row>,
    /// Their numbers among all rows.
    pub(super) place: Vec<usize>,
    /// What the model expects.
    pub(crate) level: Vec<f64>,
    /// Seconds along the record, one run after the other, a pause no longer than all the rest; not finite where a row
    /// has no time.
    pub(super) time: Vec<f64>,
    /// The readings' own numbers, one run after the other.
    pub(crate) index: Vec<f64>,
    /// Whether a row was taken directly after the one before it, no pause between.
    pub(crate) follows: Vec<bool>,
    /// √(1 − leverage).
    pub(super) share: Vec<f64>,
    /// Residual in the unit of the search.
    pub(super) plain: Vec<f64>,
    /// The same with outliers held, of unit variance.
    pub(super) held: Vec<f64>,
    /// Mean square of `plain` where all is noise.
    pub(super) expected: f64,
    /// What each of [`ERRORS`] of one size does to each reading, in its stated uncertainty.
    pub(super) errors: Arc<[Vec<f64>]>,
}

impl<'a> Series<'a> {
    /// The rows of `source`; rows that are mostly rounding are left out.
    pub(super) fn new(residuals: &Residuals<'a>, source: ObservationKind) -> Self {
        let all = residuals.rows;
        let usable = |i: &usize| {
            let row = &all[*i];
            row.source == source && row.digit / 12_f64.sqrt() <= ROUNDED * row.u
        };
        let place: Vec<usize> = residuals.sequence.order().iter().copied().filter(usable).collect();
        let rows: Vec<&Row> = place.iter().map(|&i| &all[i]).collect();
        let share: Vec<f64> = place
            .iter()
            .map(|&i| {
                (1.0 - residuals.refitted.directions().row(i).norm_squared())
                    .max(1e-3)
                    .sqrt()
            })
            .collect();
        let residual = |place: &[usize], share: &[f64]| -> Vec<f64> {
            let own = |(&i, share): (&usize, &f64)| residuals.whitened[i] / share;
            place.iter().zip(share).map(own).collect()
        };
        let whole = residual(&place, &share);
        let (time, index, follows) = along(&rows, &place);
        let mut held = hold(&whole);
        let size = (held.iter().map(|value| value * value).sum::<f64>() / held.len().max(1) as f64).sqrt();
        if size > 0.0 {
            for value in &mut held {
                *value /= size;
            }
        }
        let mut series = Self {
            source,
            level: place.iter().map(|&i| residuals.level[i]).collect(),
            time,
            index,
            follows,
            plain: whole.iter().map(|value| value / residuals.unit).collect(),
            held,
            expected: (residuals.scale / residuals.unit).powi(2),
            share,
            rows,
            place,
            errors: Arc::new([]),
        };
        let of = |k: usize, row: &Row| [1.0, series.level[k] / row.u, 1.0 / row.u, series.steepness(k) / row.u];
        let all: Vec<[f64; 4]> = (0..series.len()).map(|k| of(k, series.rows[k])).collect();
        series.errors = (0..ERRORS.len())
            .map(|error| all.iter().map(|of| of[error]).collect())
            .collect();
        series
    }

    /// Change of the expected light with γ in the readings before and after, for a degree; 0 where γ stays.
    fn steepness(&self, k: usize) -> f64 {
        let near = |other: usize| self.rows.get(other).is_some_and(|row| row.same_visit(self.rows[k]));
        let from = if k > 0 && near(k - 1) { k - 1 } else { k };
        let to = if near(k + 1) { k + 1 } else { k };
        let degrees = self.rows[to].gamma_deg - self.rows[from].gamma_deg;
        if degrees == 0.0 || !degrees.is_finite() || self.rows[k].light != Light::Lit {
            return 0.0;
        }
        (self.level[to] - self.level[from]) / degrees
    }

    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The numbers of the first and the last reading.
    pub(crate) fn numbers(&self) -> [f64; 2] {
        [self.index[0], self.index[self.len() - 1]]
    }

    /// The values of these rows in a vector of all rows; 0 elsewhere.
    pub(super) fn spread(&self, values: &[f64], rows: usize) -> DVector<f64> {
        let mut all = DVector::zeros(rows);
        for (&i, value) in self.place.iter().zip(values) {
            all[i] = *value;
        }
        all
    }

    /// Rows that were taken one after the other in one block, half-plane and light.
    pub(crate) fn visits(&self) -> Vec<Vec<usize>> {
        visits(self.rows.iter().copied().enumerate())
    }

    /// Standard deviation of the residuals of some rows, in the unit of the search.
    pub(super) fn scatter(&self, members: impl Iterator<Item = usize>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for i in members {
            sum += self.plain[i].powi(2);
            count += 1.0;
        }
        if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
    }
}

/// Standard deviation of values whatever a few of them are.
pub(super) fn robust(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let rms = (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt();
    // Half of the sizes of a normal law lie below 0.6745; more than half may be equal to rounding.
    let middle = sizes.get(sizes.len() / 2).map_or(0.0, |size| size / 0.6745);
    middle.max(rms / 3.0)
}

/// Values held within [`CLIP`] robust standard deviations.
pub(super) fn hold(values: &[f64]) -> Vec<f64> {
    let limit = CLIP * robust(values);
    values.iter().map(|value| value.clamp(-limit, limit)).collect()
}

/// Time and number along the record, and who follows whom at once.
///
/// A pause of the record is no part of what was read: it counts for no more than the time in which readings followed
/// each other, or a week between two sessions would leave one cell of time for each of them.
fn along(rows: &[&Row], place: &[usize]) -> (Vec<f64>, Vec<f64>, Vec<bool>) {
    let numbered = rows.iter().all(|row| row.index.is_finite());
    let number = |k: usize| if numbered { rows[k].index } else { place[k] as f64 };
    // NaN from one run to the next.
    let gap = |k: usize| {
        if rows[k].file == rows[k - 1].file {
            rows[k].time_s - rows[k - 1].time_s
        } else {
            f64::NAN
        }
    };
    let mut gaps: Vec<f64> = (1..rows.len()).map(gap).filter(|gap| *gap > 0.0).collect();
    gaps.sort_by(f64::total_cmp);
    let pause = PAUSE * gaps.get(gaps.len() / 2).copied().unwrap_or(0.0);
    let in_succession: f64 = gaps.iter().filter(|gap| **gap <= pause).sum();
    let (mut time, mut index) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
    let mut follows = vec![false; rows.len()];
    let mut number_start = 0.0;
    for k in 0..rows.len() {
        if k == 0 {
            time.push(rows[0].time_s);
        } else if rows[k].file != rows[k - 1].file {
            // The next run begins one step after the one before.
            number_start = number(k) - index[k - 1] - 1.0;
            time.push(time[k - 1] + 1.0);
        } else {
            let paused = gap(k) > pause;
            follows[k] = !paused && (number(k) - number(k - 1) - 1.0).abs() < 0.5;
            time.push(time[k - 1] + if paused { gap(k).min(in_succession) } else { gap(k) });
        }
        index.push(number(k) - number_start);
    }
    (time, index, follows)
}
