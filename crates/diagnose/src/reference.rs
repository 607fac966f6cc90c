//! Noise of the distribution that the model was made from: all readings of one direction share it, however often they
//! are repeated.
//!
//! The covariance of whitened rows is I + Σ b·bᵀ, one b a direction of the distribution. Each term in turn is whitened
//! in closed form, what comes after it being whitened with it; the vectors stay short, because a direction touches the
//! readings near it alone. Where errors touch many rows (a level, a near sensor lit by all directions) they are taken
//! together, by the few sums of them that matter.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::basis::product;
use crate::calibration::NEGLIGIBLE_DIRECTION;
use crate::whitening::without;

/// Entries below this share of a vector's largest are left out of it.
const SMALL: f64 = 1e-3;

/// Rows and what one standard uncertainty of a direction changes of them, in the unit of the rows, one list a
/// direction.
pub type Errors = Vec<Vec<(usize, f64)>>;

/// Entries of an error that changes more than this share of the rows: it goes with others like it.
const WIDE: f64 = 0.02;

/// The terms: the short ones each whitened with those before it, the wide ones together after them.
#[derive(Debug, Clone, Default)]
pub struct Reference {
    terms: Vec<Vec<(usize, f64)>>,
    wide: Option<Wide>,
}

/// Errors that change many rows. Whitened rows have the covariance I + B·Bᵀ; with the orthonormal directions U of B and
/// its singular values s the symmetric inverse root is I − U·diag(1 − (1 + s²)^−½)·Uᵀ.
#[derive(Debug, Clone)]
struct Wide {
    directions: DMatrix<f64>,
    taken: DVector<f64>,
}

impl Wide {
    /// Of the columns of `errors`, in units of independent rows; none where none of them matters.
    fn new(errors: &DMatrix<f64>) -> Option<Self> {
        let (directions, square) = principal(errors)?;
        Some(Self {
            directions,
            taken: square.map(|square| 1.0 - (1.0 + square).sqrt().recip()),
        })
    }

    fn whiten(&self, matrix: &mut DMatrix<f64>) {
        let mut part = product(&self.directions, matrix);
        for mut column in part.column_iter_mut() {
            column.component_mul_assign(&self.taken);
        }
        matrix.gemm(-1.0, &self.directions, &part, 1.0);
    }
}

/// Orthonormal directions of columns and their squared singular values, those that change everything by less than
/// [`NEGLIGIBLE_DIRECTION`] left out. From the products of the columns or of the rows, whichever are fewer.
fn principal(columns: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let of_rows = columns.nrows() < columns.ncols();
    let gram = if of_rows {
        columns * columns.transpose()
    } else {
        product(columns, columns)
    };
    let size = gram.nrows();
    if size == 0 || gram.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::try_new(gram, f64::EPSILON, 1000 * size)?;
    let least = NEGLIGIBLE_DIRECTION * NEGLIGIBLE_DIRECTION;
    let kept: Vec<usize> = (0..size).filter(|&k| eigen.eigenvalues[k] > least).collect();
    if kept.is_empty() {
        return None;
    }
    let square = DVector::from_iterator(kept.len(), kept.iter().map(|&k| eigen.eigenvalues[k]));
    let vectors = eigen.eigenvectors.select_columns(&kept);
    if of_rows {
        return Some((vectors, square));
    }
    let mut directions = columns * vectors;
    for (mut column, square) in directions.column_iter_mut().zip(square.iter()) {
        column /= square.sqrt();
    }
    Some((directions, square))
}

/// Whether an error changes many of the rows.
fn is_wide(error: &[(usize, f64)], rows: usize) -> bool {
    error.len() as f64 > WIDE * rows as f64
}

fn dense(errors: &[&Vec<(usize, f64)>], rows: usize, row_scale: &DVector<f64>) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(rows, errors.len());
    for (mut column, error) in dense.column_iter_mut().zip(errors) {
        for &(i, value) in *error {
            column[i] = value * row_scale[i];
        }
    }
    dense
}

/// The same errors with as few wide ones as make the same covariance: hundreds of directions of a distribution light a
/// near sensor, and few of their sums matter. `row_scale` is 1/u of the rows.
pub fn joined(errors: Errors, row_scale: &DVector<f64>) -> Errors {
    let rows = row_scale.len();
    let (wide, mut short): (Errors, Errors) = errors.into_iter().partition(|error| is_wide(error, rows));
    if wide.len() < 2 {
        short.extend(wide);
        return short;
    }
    let columns = dense(&wide.iter().collect::<Vec<_>>(), rows, row_scale);
    if let Some((directions, square)) = principal(&columns) {
        for (column, square) in directions.column_iter().zip(square.iter()) {
            let size = square.sqrt();
            let value = |i: usize| column[i] * size / row_scale[i];
            short.push((0..rows).map(|i| (i, value(i))).collect());
        }
    }
    short
}

impl Reference {
    /// Prepares errors for rows that `whiten` makes independent of everything else.
    pub fn new(errors: &Errors, rows: usize, row_scale: &DVector<f64>, whiten: impl Fn(&mut DMatrix<f64>)) -> Self {
        /// Columns that are whitened together, so that many directions and many rows do not meet in memory.
        const BLOCK: usize = 64;
        let weighs = |error: &&Vec<(usize, f64)>| {
            let square: f64 = error.iter().map(|&(i, value)| (value * row_scale[i]).powi(2)).sum();
            square > NEGLIGIBLE_DIRECTION * NEGLIGIBLE_DIRECTION
        };
        let (wide, errors): (Vec<_>, Vec<_>) = errors.iter().filter(weighs).partition(|error| is_wide(error, rows));
        let mut prepared = Self::default();
        let mut at_row: Vec<Vec<usize>> = vec![Vec::new(); if errors.is_empty() { 0 } else { rows }];
        for block in errors.chunks(BLOCK) {
            let mut dense = dense(block, rows, row_scale);
            whiten(&mut dense);
            for mut column in dense.column_iter_mut() {
                let values = column.as_mut_slice();
                let mut reach = Reach::new(rows, prepared.terms.len());
                for (i, value) in values.iter().enumerate() {
                    if *value != 0.0 {
                        reach.row(i, 0, &at_row[i]);
                    }
                }
                while let Some(term) = reach.next() {
                    without(&prepared.terms[term], values);
                    for &(i, _) in &prepared.terms[term] {
                        reach.row(i, term + 1, &at_row[i]);
                    }
                }
                let limit = SMALL * values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                let term: Vec<(usize, f64)> = values
                    .iter()
                    .enumerate()
                    .filter(|(_, value)| value.abs() > limit)
                    .map(|(i, value)| (i, *value))
                    .collect();
                for &(i, _) in &term {
                    at_row[i].push(prepared.terms.len());
                }
                prepared.terms.push(term);
            }
        }
        let mut wide = dense(&wide, rows, row_scale);
        if wide.ncols() > 0 {
            whiten(&mut wide);
            prepared.whiten(&mut wide);
            prepared.wide = Wide::new(&wide);
        }
        prepared
    }

    /// Makes rows that are independent but for the reference independent of each other, column by column.
    pub fn whiten(&self, matrix: &mut DMatrix<f64>) {
        use rayon::prelude::*;
        let rows = matrix.nrows();
        if rows == 0 {
            return;
        }
        if !self.terms.is_empty() {
            matrix.as_mut_slice().par_chunks_mut(rows).for_each(|column| {
                for term in &self.terms {
                    without(term, column);
                }
            });
        }
        if let Some(wide) = &self.wide {
            wide.whiten(matrix);
        }
    }
}

/// The terms that a column meets, in order. The list of each row is looked through once, when the row is first reached:
/// where readings that are rounded alike tie the rows together, a column meets nearly all terms, and each of them
/// nearly all rows.
struct Reach {
    rows: Vec<bool>,
    terms: Vec<bool>,
    waiting: BinaryHeap<Reverse<usize>>,
}

impl Reach {
    fn new(rows: usize, terms: usize) -> Self {
        Self {
            rows: vec![false; rows],
            terms: vec![false; terms],
            waiting: BinaryHeap::new(),
        }
    }

    /// Reaches a row from whose terms those from `first` on are still to come.
    fn row(&mut self, row: usize, first: usize, terms: &[usize]) {
        if std::mem::replace(&mut self.rows[row], true) {
            return;
        }
        for &term in terms.iter().filter(|term| **term >= first) {
            if !std::mem::replace(&mut self.terms[term], true) {
                self.waiting.push(Reverse(term));
            }
        }
    }

    /// The next term.
    fn next(&mut self) -> Option<usize> {
        self.waiting.pop().map(|Reverse(term)| term)
    }
}

/// The variance that the reference adds to each row.
pub fn variance(errors: &[Vec<(usize, f64)>], rows: usize) -> DVector<f64> {
    let mut variance = DVector::zeros(rows);
    for &(i, value) in errors.iter().flatten() {
        variance[i] += value * value;
    }
    variance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whitening_is_the_inverse_root_of_the_covariance() {
        // Rows between directions share two of them, as readings between the directions of a grid do.
        let (rows, directions) = (40, 12);
        let mut errors: Errors = vec![Vec::new(); directions];
        for i in 0..rows {
            let place = i as f64 * (directions - 1) as f64 / rows as f64;
            let (k, v) = (place as usize, place.fract());
            errors[k].push((i, 0.8 * (1.0 - v)));
            errors[k + 1].push((i, 0.8 * v));
        }
        let u = DVector::from_fn(rows, |i, _| 0.5 + 0.02 * i as f64);
        let mut covariance = DMatrix::from_diagonal(&u.map(|u| u * u));
        for error in &errors {
            let mut b = DVector::zeros(rows);
            for &(i, value) in error {
                b[i] = value;
            }
            covariance += &b * b.transpose();
        }
        let row_scale = u.map(|u| 1.0 / u);
        let reference = Reference::new(&errors, rows, &row_scale, |_| {});
        let mut whitener = DMatrix::from_diagonal(&row_scale);
        reference.whiten(&mut whitener);
        let unit = &whitener * covariance * whitener.transpose();
        assert!((unit - DMatrix::identity(rows, rows)).amax() < 5e-3);
    }

    #[test]
    fn errors_that_touch_many_rows_are_whitened_by_their_few_sums() {
        let rows = 60;
        // Fewer directions than rows, and more.
        for directions in [20, 150] {
            // They light all rows, nearly alike; and one short error.
            let mut errors: Errors = (0..directions)
                .map(|k| {
                    let value = |i: usize| 0.3 * (1.0 + 0.4 / directions as f64 * (k * i) as f64 / rows as f64);
                    (0..rows).map(|i| (i, value(i))).collect()
                })
                .collect();
            errors.push(vec![(3, 0.5), (4, -0.2)]);
            let u = DVector::from_fn(rows, |i, _| 0.5 + 0.02 * i as f64);
            let mut covariance = DMatrix::from_diagonal(&u.map(|u| u * u));
            for error in &errors {
                let mut b = DVector::zeros(rows);
                for &(i, value) in error {
                    b[i] = value;
                }
                covariance += &b * b.transpose();
            }
            let row_scale = u.map(|u| 1.0 / u);
            let few = joined(errors.clone(), &row_scale);
            assert!(few.len() <= 4, "{}", few.len());
            for errors in [errors, few] {
                let reference = Reference::new(&errors, rows, &row_scale, |_| {});
                let mut whitener = DMatrix::from_diagonal(&row_scale);
                reference.whiten(&mut whitener);
                let unit = &whitener * &covariance * whitener.transpose();
                assert!((unit - DMatrix::identity(rows, rows)).amax() < 5e-3);
            }
        }
    }

    #[test]
    fn a_hundred_looks_at_one_direction_know_it_no_better_than_the_reference() {
        let errors = vec![(0..100).map(|i| (i, 0.3)).collect::<Vec<_>>()];
        let row_scale = DVector::from_element(100, 1.0 / 0.1);
        let reference = Reference::new(&errors, 100, &row_scale, |_| {});
        let mut column = DMatrix::from_element(100, 1, 1.0 / 0.1);
        reference.whiten(&mut column);
        let u_level = 1.0 / column.norm();
        assert!((u_level - 0.3_f64.hypot(0.01)).abs() < 1e-9, "{u_level}");
    }
}
