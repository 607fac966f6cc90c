//! Orthonormal bases and projections: the linear algebra under every statistic of the diagnosis.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Rows whose products are summed at a time.
const SUMMED: usize = 8192;

/// `aᵀ·b` for wide matrices, by the blocked product (`tr_mul` takes one column at a time), which wants a transposed
/// copy of a few thousand rows at a time.
pub fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    if b.ncols() < 8 {
        return a.tr_mul(b);
    }
    let mut sum = DMatrix::zeros(a.ncols(), b.ncols());
    for start in (0..a.nrows()).step_by(SUMMED) {
        let rows = SUMMED.min(a.nrows() - start);
        sum.gemm(1.0, &a.rows(start, rows).transpose(), &b.rows(start, rows), 1.0);
    }
    sum
}

/// An orthonormal basis of a subspace of the readings' space, one column a direction, one row a reading.
#[derive(Debug, Clone)]
pub struct Basis {
    q: DMatrix<f64>,
}

impl Basis {
    /// The basis of nothing, for `rows` readings.
    pub fn empty(rows: usize) -> Self {
        Self {
            q: DMatrix::zeros(rows, 0),
        }
    }

    /// Spans `columns`; a column of which less than `tolerance` (relative to its own length) is new adds no direction.
    pub fn spanning(columns: &DMatrix<f64>, tolerance: f64) -> Self {
        let mut basis = Self::empty(columns.nrows());
        basis.extend(columns, tolerance);
        basis
    }

    /// Adds the directions of `columns` that are not yet inside.
    ///
    /// Each column is orthogonalised twice ("twice is enough", Giraud et al. 2005), so the basis stays orthonormal to
    /// rounding even for nearly dependent columns: all of them against what is known, then each against the new ones
    /// before it, and against all once more.
    pub fn extend(&mut self, columns: &DMatrix<f64>, tolerance: f64) {
        let (rows, had) = (self.q.nrows(), self.q.ncols());
        let mut beyond = columns.clone();
        self.project_out(&mut beyond);
        let known = std::mem::replace(&mut self.q, DMatrix::zeros(rows, 0));
        let mut q = known.resize_horizontally(had + columns.ncols(), 0.0);
        let mut rank = had;
        for (column, beyond) in columns.column_iter().zip(beyond.column_iter()) {
            let before = column.norm();
            if rank == rows || !before.is_normal() {
                continue;
            }
            let mut new: DVector<f64> = beyond.into_owned();
            for first in [had, 0] {
                let known = q.columns(first, rank - first);
                let part = known.tr_mul(&new);
                new.gemv(-1.0, &known, &part, 1.0);
            }
            let left = new.norm();
            if left > tolerance * before {
                q.set_column(rank, &(new / left));
                rank += 1;
            }
        }
        self.q = q.resize_horizontally(rank, 0.0);
    }

    /// Number of directions.
    pub fn rank(&self) -> usize {
        self.q.ncols()
    }

    /// The directions, readings × rank.
    pub fn directions(&self) -> &DMatrix<f64> {
        &self.q
    }

    /// Removes from every column of `matrix` what lies in this subspace.
    pub fn project_out(&self, matrix: &mut DMatrix<f64>) {
        if self.rank() > 0 {
            let part = product(&self.q, matrix);
            matrix.gemm(-1.0, &self.q, &part, 1.0);
        }
    }

    /// Removes from `vector` what lies in this subspace.
    pub fn project_out_vector(&self, vector: &mut DVector<f64>) {
        if self.rank() > 0 {
            let part = self.q.tr_mul(vector);
            vector.gemv(-1.0, &self.q, &part, 1.0);
        }
    }
}

/// Pseudo-inverse of a normal matrix JᵀJ, scaled to a unit diagonal first: parameters have very different sizes.
///
/// Directions below `tolerance` of the largest, and parameters that change nothing, get zero: the data say nothing of
/// them. So does everything where an entry is not finite.
pub fn inverse_of_normal(normal: &DMatrix<f64>, tolerance: f64) -> DMatrix<f64> {
    let n = normal.nrows();
    if n == 0 || normal.iter().any(|value| !value.is_finite()) {
        return DMatrix::zeros(n, n);
    }
    // 0 for a parameter without effect, else 1/length.
    let size = DVector::from_fn(n, |i, _| {
        let length = normal[(i, i)].max(0.0).sqrt();
        if length.is_normal() { 1.0 / length } else { 0.0 }
    });
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * size[i] * size[j]);
    let Some(eigen) = SymmetricEigen::try_new(scaled, f64::EPSILON, 1000 * n) else {
        return DMatrix::zeros(n, n);
    };
    let limit = tolerance * eigen.eigenvalues.amax();
    let inverse = eigen
        .eigenvalues
        .map(|value| if value > limit { 1.0 / value } else { 0.0 });
    let whole = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
    DMatrix::from_fn(n, n, |i, j| whole[(i, j)] * size[i] * size[j])
}

/// The damped step of normal equations (Levenberg–Marquardt), in units of each parameter's own length.
pub fn solve_damped(normal: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64) -> DVector<f64> {
    let n = normal.nrows();
    if n == 0 {
        return DVector::zeros(0);
    }
    // A parameter that changes nothing stays where it is.
    let size = DVector::from_fn(n, |i, _| {
        let length = normal[(i, i)].max(0.0).sqrt();
        if length.is_normal() { length } else { f64::INFINITY }
    });
    let mut scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / size[i] / size[j]);
    for i in 0..n {
        scaled[(i, i)] = 1.0 + damping + 1e-10;
    }
    let target = gradient.component_div(&size);
    let solved = match scaled.clone().cholesky() {
        Some(cholesky) => cholesky.solve(&target),
        None => inverse_of_normal(&scaled, 1e-9) * target,
    };
    solved.component_div(&size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stays_orthonormal_on_nearly_dependent_columns() {
        // Monomials on [0, 1]: condition number beyond 1e12.
        let columns = DMatrix::from_fn(60, 14, |i, k| (i as f64 / 59.0).powi(k as i32));
        let basis = Basis::spanning(&columns, 1e-13);
        let gram = basis.directions().tr_mul(basis.directions());
        let identity = DMatrix::identity(basis.rank(), basis.rank());
        assert!((gram - identity).amax() < 1e-12);
        let mut inside = columns.clone();
        basis.project_out(&mut inside);
        assert!(inside.amax() < 1e-10);
    }

    #[test]
    fn parameters_without_effect_have_no_inverse() {
        let normal = DMatrix::from_row_slice(
            4,
            4,
            &[
                4.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 9e8,
            ],
        );
        let inverse = inverse_of_normal(&normal, 1e-12);
        let pick = |m: &DMatrix<f64>| m.select_rows(&[0, 3]).select_columns(&[0, 3]);
        let product = pick(&normal) * pick(&inverse);
        assert!((product - DMatrix::identity(2, 2)).amax() < 1e-9);
        assert!(inverse.row(1).amax() == 0.0 && inverse.row(2).amax() == 0.0);
        assert_eq!(
            inverse_of_normal(&DMatrix::from_element(3, 3, f64::NAN), 1e-12),
            DMatrix::zeros(3, 3)
        );
    }

    #[test]
    fn a_repeated_column_adds_no_direction() {
        let columns = DMatrix::from_fn(20, 2, |i, _| i as f64);
        assert_eq!(Basis::spanning(&columns, 1e-9).rank(), 1);
    }

    #[test]
    fn the_blocked_product_is_the_product() {
        let value = |i: usize, k: usize| ((i * (2 * k + 1)) as f64 * 1e-3).sin();
        let a = DMatrix::from_fn(2 * SUMMED + 5, 7, value);
        let b = DMatrix::from_fn(2 * SUMMED + 5, 9, |i, k| value(i, k + 11));
        assert!((product(&a, &b) - a.tr_mul(&b)).amax() < 1e-10);
    }
}
