//! What the model's file states of its own uncertainty, on the rows of a diagnosis: a prior, and where the readings put
//! it.
//!
//! A term is no parameter of a fit: its change of the rows counts among the errors that rows share
//! ([`crate::reference`]), so that every comparison, and every simulated one, leaves room for it and for no more. Where
//! the readings put it follows afterwards, from what a fit leaves.

use nalgebra::{DMatrix, DVector};

use crate::reference::Errors;
use crate::whitener::Whitener;

/// One thing that the model knows with a standard uncertainty.
#[derive(Debug, Clone)]
pub struct Known {
    /// What, in words.
    pub what: String,
    /// Its standard uncertainty.
    pub u: f64,
    /// The unit of that; empty for a ratio.
    pub unit: &'static str,
    /// The file does not state it: it was taken as wide as usual.
    pub assumed: bool,
    /// What one standard uncertainty changes of every row, in its unit.
    pub column: DVector<f64>,
}

/// Where readings put what the model knows.
#[derive(Debug, Clone)]
pub struct Moved {
    /// Every term in its standard uncertainties, 0 as the model states it.
    pub sigma: DVector<f64>,
    /// Standard uncertainty that the readings leave of each, in the same unit: 1 where they say nothing of it.
    pub u_sigma: DVector<f64>,
    /// What that changes of every row.
    pub change: DVector<f64>,
}

impl Moved {
    /// From what a fit leaves, measured − expected in the unit of the rows. `whitener` leaves room for `known`.
    pub fn of(known: &[Known], whitener: &Whitener<'_>, left: &DVector<f64>) -> Self {
        let rows = left.len();
        if known.is_empty() {
            return Self {
                sigma: DVector::zeros(0),
                u_sigma: DVector::zeros(0),
                change: DVector::zeros(rows),
            };
        }
        // With C = D + B·Bᵀ the mean of the terms is Bᵀ·C⁻¹·r and their covariance I − Bᵀ·C⁻¹·B.
        let columns: Vec<DVector<f64>> = known.iter().map(|one| one.column.clone()).collect();
        let columns = DMatrix::from_columns(&columns);
        let mut whitened = columns.clone();
        whitener.apply(&mut whitened);
        let sigma = whitened.tr_mul(&whitener.vector(left));
        let u_sigma = DVector::from_iterator(
            known.len(),
            whitened
                .column_iter()
                .map(|column| (1.0 - column.norm_squared()).max(0.0).sqrt()),
        );
        Self {
            change: columns * &sigma,
            sigma,
            u_sigma,
        }
    }
}

/// What errors that rows share are expected to change of every row, from what a fit leaves, measured − expected in the
/// unit of the rows. `whitener` leaves room for them: with C = D + B·Bᵀ it is B·Bᵀ·C⁻¹·r.
pub fn expected_change(errors: &Errors, whitener: &Whitener<'_>, left: &DVector<f64>) -> DVector<f64> {
    /// Columns at a time.
    const BLOCK: usize = 16;
    let (rows, whitened_left) = (left.len(), whitener.vector(left));
    let mut change = DVector::zeros(rows);
    for block in errors.chunks(BLOCK) {
        let mut columns = DMatrix::zeros(rows, block.len());
        for (mut column, error) in columns.column_iter_mut().zip(block) {
            for &(row, value) in error {
                column[row] = value;
            }
        }
        let mut whitened = columns.clone();
        whitener.apply(&mut whitened);
        change += columns * whitened.tr_mul(&whitened_left);
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rounding::Rounding;
    use crate::whitening::Sequence;

    #[test]
    fn a_prior_and_ten_readings_share_the_answer_by_their_weights() {
        let rows = 10;
        let known = [Known {
            what: "the level of the light".into(),
            u: 0.004,
            unit: "",
            assumed: false,
            column: DVector::from_element(rows, 0.4),
        }];
        let errors: Errors = vec![known[0].column.iter().copied().enumerate().collect()];
        let sequence = Sequence::by_time(&vec![0; rows], &vec![f64::NAN; rows]);
        let rounding = Rounding::default();
        let u = 0.5;
        let whitener = Whitener::new(&sequence, &rounding, DVector::from_element(rows, 1.0 / u), 0.0, &errors);
        let moved = Moved::of(&known, &whitener, &DVector::from_element(rows, 0.6));
        // Weight of the prior 1, of the readings 10·(0.4/0.5)²; they alone would say 0.6/0.4 = 1.5.
        let information = 10.0 * (0.4_f64 / u).powi(2);
        let expected = 1.5 * information / (1.0 + information);
        assert!((moved.sigma[0] - expected).abs() < 1e-9, "{}", moved.sigma[0]);
        assert!((moved.u_sigma[0] - (1.0 + information).sqrt().recip()).abs() < 1e-9);
        assert!((moved.change[3] - 0.4 * expected).abs() < 1e-9);
    }
}
