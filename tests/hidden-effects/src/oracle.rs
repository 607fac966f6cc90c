//! What no fit can avoid: the error, on readings that nobody fitted, of one that knows the form of what is hidden and
//! how large the model's own errors are drawn, but none of their values.

use nalgebra::{DMatrix, DVector};

use crate::plan::Step;
use crate::recipe::{self, Extra};
use crate::truth::{self, Setting};

/// Terms in which the operator's distribution is wrong, the level being the first, and the standard deviation of each
/// (`case::assumed`).
pub(crate) const BELIEVED_TERMS: usize = 7;

/// Standard deviation of term `k` of ln I.
pub(crate) fn believed_error(k: usize) -> f64 {
    0.01 / (1.0 + 0.5 * k as f64)
}

/// Standard deviation of the cos 2C term: the room's ellipticity is 0.01 to 0.03.
const ELLIPTICITY: f64 = 0.02;

/// Expected squared deviation, in σ², on the held-out steps, of the best linear estimate from the others (Gauss–Markov
/// with what is known before the data as further observations).
///
/// `sigma` is the noise of each reading, `plain` what is read with nothing hidden, `with` what is read with these
/// settings.
pub(crate) fn held_out_square(
    steps: &[Step],
    sigma: &[f64],
    plain: &[f64],
    settings: &[Setting],
    with: impl Fn(&[Setting]) -> Vec<f64>,
) -> f64 {
    let shape = truth::reading_nuisance(steps, plain);
    let mut columns: Vec<DVector<f64>> = Vec::new();
    let mut precision: Vec<f64> = Vec::new();
    for k in 0..BELIEVED_TERMS {
        columns.push(shape.column(k).into_owned());
        precision.push(believed_error(k).powi(-2));
    }
    columns.push(shape.column(shape.ncols() - 1).into_owned());
    precision.push(ELLIPTICITY.powi(-2));
    for (number, setting) in settings.iter().enumerate() {
        let Some(recipe) = recipe::find(recipe::GONIO, setting.name) else {
            continue;
        };
        for (key, &(name, value)) in setting.values.iter().enumerate() {
            // The size is free; what else is drawn is known to lie where it is drawn.
            let spread = match recipe.extra.iter().find(|(extra, _)| *extra == name) {
                None => f64::INFINITY,
                Some((_, Extra::Between(low, high))) => (high - low) / 12_f64.sqrt(),
                Some((_, Extra::Decades(low, high))) => value * (high / low).ln() / 12_f64.sqrt(),
                Some((_, Extra::OneOf(_))) => continue,
            };
            let step = if spread.is_finite() {
                0.1 * spread
            } else {
                0.05 * value.abs()
            };
            let moved = |by: f64| {
                let mut moved = settings.to_vec();
                moved[number].values[key].1 += by;
                with(&moved)
            };
            let (above, below) = (moved(step), moved(-step));
            columns.push(DVector::from_fn(steps.len(), |i, _| {
                (above[i] - below[i]) / (2.0 * step)
            }));
            precision.push(spread.powi(-2));
        }
    }
    let mut all = DMatrix::from_columns(&columns);
    for (i, sigma) in sigma.iter().enumerate() {
        all.row_mut(i).unscale_mut(*sigma);
    }
    let of = |held_out: bool| -> DMatrix<f64> {
        let rows: Vec<usize> = (0..steps.len()).filter(|&i| steps[i].held_out == held_out).collect();
        all.select_rows(&rows)
    };
    let (seen, held) = (of(false), of(true));
    // Parameters in units of their own certainty: sizes differ by many decades.
    let mut normal = seen.tr_mul(&seen) + DMatrix::from_diagonal(&DVector::from_vec(precision));
    let size = normal
        .diagonal()
        .map(|square| square.max(f64::MIN_POSITIVE).sqrt().recip());
    normal = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] * size[i] * size[j]
    });
    let squares = held.tr_mul(&held);
    let squares = DMatrix::from_fn(squares.nrows(), squares.ncols(), |i, j| {
        squares[(i, j)] * size[i] * size[j]
    });
    // Parameters that change nothing stay unknown and matter nowhere.
    normal
        .pseudo_inverse(1e-10)
        .map_or(0.0, |covariance| covariance.component_mul(&squares).sum())
}
