//! Refitted terms that are held near the model as it came, as strongly as the data's own evidence asks (empirical
//! Bayes: Morris 1983).
//!
//! An analyst who refits nine terms of a shape that was known to a tenth of a per cent predicts new readings worse than
//! the model did. How far the terms lie from zero, compared with their uncertainties, gives how much weight they get.

use nalgebra::{DMatrix, DVector};

use crate::basis::inverse_of_normal;
use crate::fit::Fit;
use crate::forward::{Forward, Hypothesis, Searchable};
use crate::reference::Errors;

/// Standard deviations that are tried for the level and for the first term of the shape: from a hundred-thousandth to a
/// half, three a decade.
const SIZES: i32 = 15;
/// Powers with which the standard deviations of further terms may fall: (1 + k)⁻ᵖ.
const FALLS: [i32; 4] = [0, 1, 2, 3];

/// A model whose refitted terms are held.
pub struct Held<'a> {
    /// The model.
    pub forward: &'a dyn Forward,
    /// 1/σ² of each refitted term.
    pub weights: &'a [f64],
}

impl Forward for Held<'_> {
    fn nuisances(&self) -> usize {
        self.forward.nuisances()
    }

    fn nuisance_weights(&self) -> Vec<f64> {
        self.weights.to_vec()
    }

    fn shape_terms(&self) -> Vec<Option<usize>> {
        self.forward.shape_terms()
    }

    fn common_errors(&self) -> Errors {
        self.forward.common_errors()
    }

    fn effects(&self) -> &[Searchable] {
        self.forward.effects()
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        self.forward.predict(nuisance, hypotheses)
    }
}

/// 1/σ² of each refitted term, in units of rows that were scaled to their stated uncertainties, for a fit with noise of
/// `scale` of these.
///
/// The level has a size of its own; the shape's terms have one that falls with their number. Of the sizes on a grid
/// those are taken with which the fitted terms are the most probable. What is no term of the shape stays as free as it
/// was.
pub fn weights(forward: &dyn Forward, fitted: &Fit, scale: f64) -> Vec<f64> {
    let mut weights = forward.nuisance_weights();
    let terms = forward.shape_terms();
    let (places, orders): (Vec<usize>, Vec<usize>) = terms
        .iter()
        .enumerate()
        .filter_map(|(place, order)| order.map(|order| (place, order)))
        .unzip();
    if places.len() < 3 {
        return weights;
    }
    let covariance = fitted.covariance(scale).select_rows(&places).select_columns(&places);
    let found = DVector::from_iterator(places.len(), places.iter().map(|&place| fitted.nuisance[place]));
    let size = |step: i32| 1e-5 * 10_f64.powf(f64::from(step) / 3.0);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for level in 0..SIZES {
        for shape in 0..SIZES {
            for fall in FALLS {
                let variance: Vec<f64> = orders
                    .iter()
                    .map(|&order| match order {
                        0 => size(level).powi(2),
                        k => (size(shape) * (k as f64).powi(-fall)).powi(2),
                    })
                    .collect();
                let evidence = ln_evidence(&found, &covariance, &variance);
                if evidence.is_some_and(|evidence| best.as_ref().is_none_or(|(most, _)| evidence > *most)) {
                    best = evidence.map(|evidence| (evidence, variance));
                }
            }
        }
    }
    if let Some((_, variance)) = best {
        for (&place, variance) in places.iter().zip(variance) {
            weights[place] = weights[place].max(scale * scale / variance);
        }
    }
    weights
}

/// ln of the density of the fitted terms, whose errors have this covariance, when they vary about zero.
fn ln_evidence(found: &DVector<f64>, covariance: &DMatrix<f64>, variance: &[f64]) -> Option<f64> {
    let total = covariance + DMatrix::from_diagonal(&DVector::from_column_slice(variance));
    let cholesky = total.cholesky()?;
    let determinant: f64 = cholesky.l_dirty().diagonal().iter().map(|value| 2.0 * value.ln()).sum();
    let value = -0.5 * (determinant + found.dot(&cholesky.solve(found)));
    value.is_finite().then_some(value)
}

/// How many parameters a fit with these weights is worth: each held one counts for the share that the data have in it.
pub fn parameters(fitted: &Fit, weights: &[f64]) -> f64 {
    let mut normal = fitted.jacobian.tr_mul(&fitted.jacobian);
    for (k, weight) in weights.iter().enumerate() {
        normal[(k, k)] += weight;
    }
    let inverse = inverse_of_normal(&normal, 1e-14);
    let held: f64 = weights
        .iter()
        .enumerate()
        .map(|(k, weight)| weight * inverse[(k, k)])
        .sum();
    fitted.jacobian.ncols() as f64 - held
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Terms;

    impl Forward for Terms {
        fn nuisances(&self) -> usize {
            9
        }

        fn shape_terms(&self) -> Vec<Option<usize>> {
            (0..9).map(Some).collect()
        }

        fn effects(&self) -> &[Searchable] {
            &[]
        }

        fn predict(&self, _: &[f64], _: &[Hypothesis]) -> Option<DVector<f64>> {
            None
        }
    }

    /// A fit of nine terms, each known to 0.001.
    fn fitted(nuisance: &[f64; 9]) -> Fit {
        Fit {
            nuisance: nuisance.to_vec(),
            hypotheses: Vec::new(),
            prediction: DVector::zeros(9),
            residual: DVector::zeros(9),
            chi2: 0.0,
            jacobian: DMatrix::from_diagonal_element(9, 9, 1000.0),
            change: DVector::zeros(0),
        }
    }

    /// What is left of a term once it is held: N/(N + w).
    fn kept(weights: &[f64], k: usize) -> f64 {
        1e6 / (1e6 + weights[k])
    }

    #[test]
    fn terms_of_the_size_of_their_noise_go_back_to_the_model() {
        let noise = [0.3, -0.9, 0.8, 0.1, -1.1, 0.7, -0.4, 0.9, -0.6].map(|z| 1e-3 * z);
        let weights = weights(&Terms, &fitted(&noise), 1.0);
        for k in 0..9 {
            assert!(kept(&weights, k) < 0.1, "term {k}: {}", kept(&weights, k));
        }
        assert!(parameters(&fitted(&noise), &weights) < 1.0);
    }

    #[test]
    fn terms_far_beyond_their_noise_stay() {
        let found = [0.05, 0.03, -0.02, 0.015, 0.01, -0.01, 0.008, -0.007, 0.006];
        let weights = weights(&Terms, &fitted(&found), 1.0);
        for k in 0..9 {
            assert!(kept(&weights, k) > 0.95, "term {k}: {}", kept(&weights, k));
        }
    }

    /// A wrong level and a wrong first term say nothing of the eighth.
    #[test]
    fn the_fine_terms_are_held_where_only_the_coarse_ones_are_wrong() {
        let found = [0.03, 0.02, 0.004, 0.0007, -0.0009, 0.0006, 0.0003, -0.0008, 0.0005];
        let weights = weights(&Terms, &fitted(&found), 1.0);
        assert!(kept(&weights, 0) > 0.99 && kept(&weights, 1) > 0.98);
        assert!(kept(&weights, 8) < 0.3, "{}", kept(&weights, 8));
    }
}
