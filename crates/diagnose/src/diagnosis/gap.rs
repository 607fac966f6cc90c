//! The gap before and after, on the readings that were fitted and on those kept back.

use nalgebra::{DMatrix, DVector};

use crate::assumed::{AssumedModel, direction_errors, known};
use crate::calibration::{PREDICTABLE_SIGMA, VISIBLE_SIGMA};
use crate::document::{GapEntry, HeldOutEntry};
use crate::fit::{Fit, derivatives, fit, nuisance_tangents};
use crate::forward::Hypothesis;
use crate::held_out;
use crate::known::Moved;
use crate::observe::Observed;
use crate::reference::{self, Errors};
use crate::rounding::Rounding;
use crate::search::Outcome;
use crate::shrinkage::{self, Held};
use crate::table::Row;
use crate::whitener::Whitener;

pub(super) fn gap(
    assumed: &AssumedModel,
    outcome: &Outcome,
    rows: &[Row],
    as_given: &DVector<f64>,
    before: &DVector<f64>,
    left: &DVector<f64>,
    kept_back: &[Observed],
) -> GapEntry {
    let n = rows.len() as f64;
    let parameters = shrinkage::parameters(&outcome.after, &outcome.held);
    let all = |values: &DVector<f64>| rms(values.iter().copied());
    let variance = reference::variance(outcome.direction_errors(), rows.len());
    let sigma = rows.iter().map(|row| outcome.noise.scale * row.u);
    let floor = floor(variance.iter().copied().zip(sigma)) * ((n - parameters).max(1.0) / n).sqrt();
    let (first, after) = (all(before), all(left));
    let named = !outcome.after.hypotheses.is_empty();
    let (held_out, held_out_note) = match (named, kept_back.is_empty()) {
        (false, _) => (
            None,
            "no effect was added, so there is nothing to check on readings kept back".to_owned(),
        ),
        (true, false) => given_back(assumed, outcome, kept_back),
        (true, true) => by_rule(assumed, outcome, rows),
    };
    GapEntry {
        metric: "rms((measured − predicted)/(s·u))".into(),
        as_given: all(as_given),
        before: first,
        after,
        floor,
        removed: (named && first > floor).then(|| removed(first, after, floor)),
        held_out,
        held_out_note,
    }
}

fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

fn removed(before: f64, after: f64, floor: f64) -> f64 {
    (before * before - after * after) / (before * before - floor * floor)
}

/// The rms that noise alone leaves, in σ of the readings: theirs, and what the noise of the model's own distribution
/// adds (variance, σ of each).
fn floor(rows: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (variance, sigma) in rows {
        sum += 1.0 + variance / (sigma * sigma);
        count += 1.0;
    }
    if count > 0.0 { f64::sqrt(sum / count) } else { 1.0 }
}

fn held_out_entry(
    before: f64,
    after: f64,
    floor: f64,
    readings: usize,
    visible: f64,
    note: String,
) -> (Option<HeldOutEntry>, String) {
    if visible < VISIBLE_SIGMA || before <= floor {
        let why = format!("{note}; the effect changes them by {visible:.1} σ in all: they cannot show it");
        return (None, why);
    }
    (
        Some(HeldOutEntry {
            before,
            after,
            floor,
            removed: removed(before, after, floor),
            readings,
        }),
        note,
    )
}

/// Readings that were given to be held out: predicted by the two models of the whole fit.
fn given_back(assumed: &AssumedModel, outcome: &Outcome, kept_back: &[Observed]) -> (Option<HeldOutEntry>, String) {
    let (Some(baseline), Some(after)) = (
        assumed.model(&outcome.baseline.nuisance, &[]),
        assumed.model(&outcome.after.nuisance, &outcome.after.hypotheses),
    ) else {
        return (None, "the held-out readings could not be predicted".to_owned());
    };
    let mut sums = (0.0, 0.0, 0.0, 0_usize);
    let mut squares = 0.0;
    for held in kept_back {
        for error in direction_errors(&after, &held.part) {
            let sigma = |row: usize| outcome.noise.scale * held.rows[row].u;
            squares += error
                .errors
                .iter()
                .map(|&(row, value)| (value / sigma(row)).powi(2))
                .sum::<f64>();
        }
        let (Some(first), Some(second)) = (held.part.predict(&baseline), held.part.predict(&after)) else {
            return (None, "the held-out readings could not be predicted".to_owned());
        };
        let first = moved(assumed, held, first, &outcome.moved_before);
        let second = moved(assumed, held, second, &outcome.moved_after);
        for ((row, a), b) in held.rows.iter().zip(first).zip(second) {
            let sigma = outcome.noise.scale * row.u;
            sums.0 += ((row.measured - a) / sigma).powi(2);
            sums.1 += ((row.measured - b) / sigma).powi(2);
            sums.2 += ((b - a) / sigma).powi(2);
            sums.3 += 1;
        }
    }
    let n = sums.3.max(1) as f64;
    let note = format!("{} readings that were given to be held out", sums.3);
    held_out_entry(
        (sums.0 / n).sqrt(),
        (sums.1 / n).sqrt(),
        (1.0 + squares / n).sqrt(),
        sums.3,
        sums.2.sqrt(),
        note,
    )
}

/// The prediction with what the model knows of itself where the fitted readings put it.
fn moved(assumed: &AssumedModel, held: &Observed, mut predicted: Vec<f64>, to: &Moved) -> Vec<f64> {
    let known = known(assumed.given(), std::slice::from_ref(&held.part));
    for (one, sigma) in known.iter().zip(to.sigma.iter()) {
        for (value, change) in predicted.iter_mut().zip(one.column.iter()) {
            *value += sigma * change;
        }
    }
    predicted
}

/// A second fit of the same effects without whole planes, maps and dark blocks, which it then predicts. Of the rules
/// the first whose rows the remaining ones can predict.
fn by_rule(assumed: &AssumedModel, outcome: &Outcome, rows: &[Row]) -> (Option<HeldOutEntry>, String) {
    let mut why = "too few half-planes or maps to keep any back".to_owned();
    for first in held_out::RULES {
        let Some(held) = held_out::by_rule(rows, first) else {
            continue;
        };
        match without(assumed, outcome, rows, held) {
            Ok(entry) => return entry,
            Err(note) => why = note,
        }
    }
    (None, why)
}

/// Sum over the rows kept back, of which `slopes` are the derivatives in σ, of the variance of their prediction by the
/// other rows, in σ²: of the parameters, and of what the model knows of itself as far as these rows leave it open. Both
/// go together: an effect that looks like a wrong level is hardly known, and what it does with that level is.
fn predicted_variance(
    outcome: &Outcome,
    whitener: &Whitener<'_>,
    plain: &Whitener<'_>,
    after: &Fit,
    slopes: &DMatrix<f64>,
    pick: &[usize],
) -> f64 {
    let covariance = after.covariance(outcome.noise.scale);
    if outcome.known.is_empty() {
        return (slopes * covariance).component_mul(slopes).sum();
    }
    let columns: Vec<DVector<f64>> = outcome.known.iter().map(|one| one.column.clone()).collect();
    let columns = DMatrix::from_columns(&columns);
    let (mut whitened, mut there) = (columns.clone(), columns);
    whitener.apply(&mut whitened);
    plain.apply(&mut there);
    let there = there.select_rows(pick);
    let open = DMatrix::identity(whitened.ncols(), whitened.ncols()) - whitened.tr_mul(&whitened);
    let slopes = slopes - &there * whitened.tr_mul(&after.jacobian);
    (&slopes * covariance).component_mul(&slopes).sum() + (&there * open).component_mul(&there).sum()
}

/// As [`by_rule`], for one choice of rows; an error says why they are no test.
fn without(
    assumed: &AssumedModel,
    outcome: &Outcome,
    rows: &[Row],
    held: held_out::HeldOut,
) -> Result<(Option<HeldOutEntry>, String), String> {
    let scale = DVector::from_iterator(
        rows.len(),
        rows.iter().zip(&held.rows).zip(&outcome.noise.weights).map(
            |((row, &held), weight)| {
                if held { 0.0 } else { weight.sqrt() / row.u }
            },
        ),
    );
    let (sequence, rounding) = (&outcome.sequence, &outcome.rounding);
    let whitener = Whitener::new(sequence, rounding, scale, outcome.noise.rho, &outcome.errors);
    let measured = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.measured));
    let start = &outcome.baseline.nuisance;
    let fits = nuisance_tangents(assumed, start).and_then(|tangents| {
        let held = Held {
            forward: assumed,
            weights: &outcome.held,
        };
        let refit = |members: &[Hypothesis]| fit(&held, &measured, &whitener, start, &tangents, members);
        Some((refit(&[])?, refit(&outcome.after.hypotheses)?))
    });
    let Some((baseline, after)) = fits else {
        return Err("the second fit did not succeed".to_owned());
    };
    let pick: Vec<usize> = (0..rows.len()).filter(|&i| held.rows[i]).collect();
    let sigma = |i: usize| outcome.noise.scale * rows[i].u;
    let alone = Rounding::default();
    let each = DVector::from_fn(rows.len(), |i, _| 1.0 / sigma(i));
    let plain = Whitener::new(sequence, &alone, each, 0.0, &Errors::new());
    let u_predicted = derivatives(assumed, &plain, &after).map_or(0.0, |slopes| {
        let slopes = slopes.select_rows(&pick);
        let variance = predicted_variance(outcome, &whitener, &plain, &after, &slopes, &pick);
        (variance / pick.len() as f64).sqrt()
    });
    if u_predicted > PREDICTABLE_SIGMA {
        return Err(format!(
            "{}: the others cannot predict them better than {u_predicted:.1} σ, so they are no test",
            held.note
        ));
    }
    // The readings that stay say where what the model knows of itself lies, for those kept back, too.
    let expected = |fitted: &Fit| {
        let left = &measured - &fitted.prediction;
        &fitted.prediction + Moved::of(&outcome.known, &whitener, &left).change
    };
    let (expected_before, expected_after) = (expected(&baseline), expected(&after));
    let of = |expected: &DVector<f64>| rms(pick.iter().map(|&i| (rows[i].measured - expected[i]) / sigma(i)));
    let visible = pick
        .iter()
        .map(|&i| ((expected_after[i] - expected_before[i]) / sigma(i)).powi(2))
        .sum::<f64>()
        .sqrt();
    let variance = reference::variance(outcome.direction_errors(), rows.len());
    let floor = floor(pick.iter().map(|&i| (variance[i], sigma(i))));
    Ok(held_out_entry(
        of(&expected_before),
        of(&expected_after),
        floor,
        pick.len(),
        visible,
        held.note,
    ))
}
