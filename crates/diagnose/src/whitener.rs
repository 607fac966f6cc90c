//! Everything that makes rows independent and of unit variance: their uncertainties, what was rounded alike, serial
//! correlation, and what they share through the model's distribution.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::reference::{Errors, Reference};
use crate::rounding::Rounding;
use crate::whitening::Sequence;

/// From a difference of predictions to unit residuals.
#[derive(Debug, Clone)]
pub struct Whitener<'a> {
    /// The order of the rows in time.
    pub sequence: &'a Sequence,
    /// √weight / u of each row.
    pub row_scale: DVector<f64>,
    /// Rows that were rounded alike.
    pub rounding: &'a Rounding,
    /// Serial correlation.
    pub rho: f64,
    /// What rows share because the model's distribution was measured, prepared for all of the above.
    pub reference: Arc<Reference>,
}

impl<'a> Whitener<'a> {
    /// For rows of this order, scale and rounding, with serial correlation `rho` and common `errors`.
    pub fn new(
        sequence: &'a Sequence,
        rounding: &'a Rounding,
        row_scale: DVector<f64>,
        rho: f64,
        errors: &Errors,
    ) -> Self {
        let reference = Reference::new(errors, row_scale.len(), &row_scale, |matrix| {
            rounding.whiten(&row_scale, matrix);
            sequence.whiten(rho, matrix);
        });
        Self {
            sequence,
            row_scale,
            rounding,
            rho,
            reference: Arc::new(reference),
        }
    }

    /// Whitens columns in place.
    pub fn apply(&self, matrix: &mut DMatrix<f64>) {
        for mut column in matrix.column_iter_mut() {
            column.component_mul_assign(&self.row_scale);
        }
        self.rounding.whiten(&self.row_scale, matrix);
        self.sequence.whiten(self.rho, matrix);
        self.reference.whiten(matrix);
    }

    /// A whitened copy of one vector.
    pub fn vector(&self, vector: &DVector<f64>) -> DVector<f64> {
        let mut matrix = DMatrix::from_column_slice(vector.len(), 1, vector.as_slice());
        self.apply(&mut matrix);
        matrix.column(0).into_owned()
    }
}
