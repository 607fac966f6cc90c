//! First stage: the problem under one estimate of its noise, every fit and every candidate whitened with it.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::calibration::{CORRELATED_U, MOST_CORRELATED};
use crate::fit::{Fit, fit};
use crate::forward::{Forward, Hypothesis};
use crate::known::Moved;
use crate::reference::Reference;
use crate::rounding::Rounding;
use crate::shrinkage::Held;
use crate::whitener::Whitener;
use crate::whitening::{Correlation, Noise, heavy_tail_weights};

use super::problem::Problem;

/// A whitened dictionary of up to so many values (a quarter of a gigabyte) is kept; a larger one is computed block by
/// block wherever it is needed.
const KEPT_VALUES: usize = 1 << 25;

pub(super) struct Estimate<'p, 'a, F: Forward + ?Sized> {
    pub(super) problem: &'p Problem<'a, F>,
    /// Nuisance from which every fit begins.
    start: Vec<f64>,
    pub(super) rounding: Rounding,
    /// What the rows share through the model's distribution, prepared for this noise.
    reference: Arc<Reference>,
    pub(super) noise: Noise,
    /// Rows less what was fitted to find the noise.
    pub(super) freedom: f64,
    /// The dictionary, whitened, where it is small.
    kept: Option<DMatrix<f64>>,
    /// Statistics of simulated scans of noise alone, rising.
    pub(super) nulls: Arc<[f64]>,
}

/// The model without effects, and the noise that it leaves.
pub(super) struct Baseline<'p, 'a, F: Forward + ?Sized> {
    pub(super) estimate: Estimate<'p, 'a, F>,
    pub(super) fit: Fit,
}

/// First stage: the noise that the plain fit leaves, and the fit under that noise.
pub(super) fn baseline<'p, 'a, F: Forward + ?Sized>(problem: &'p Problem<'a, F>) -> Option<Baseline<'p, 'a, F>> {
    let first = Estimate::of(problem, problem.plain.nuisance.clone(), Arc::default(), &problem.plain);
    let fit = first.fit(&[])?;
    let start = fit.nuisance.clone();
    let estimate = Estimate { start, ..first };
    Some(Baseline { estimate, fit })
}

impl<'p, 'a, F: Forward + ?Sized> Estimate<'p, 'a, F> {
    /// The same with simulated scans of noise alone, rising.
    pub(super) fn with_nulls(self, nulls: Vec<f64>) -> Self {
        let nulls = nulls.into();
        Self { nulls, ..self }
    }

    /// Noise from what is left of a fit after everything smooth is projected out: outlier weights, ρ, scale. What is
    /// rounded alike goes by the levels of the fit: dark readings that an effect lifts by different amounts are none of
    /// them alike.
    pub(super) fn again(self, fitted: &Fit) -> Self {
        let Self {
            problem,
            start,
            nulls,
            kept,
            ..
        } = self;
        // The next one is as large.
        drop(kept);
        Self::of(problem, start, nulls, fitted)
    }

    fn of(problem: &'p Problem<'a, F>, start: Vec<f64>, nulls: Arc<[f64]>, fitted: &Fit) -> Self {
        let Problem {
            sequence, u, errors, ..
        } = problem;
        let n = problem.measured.len();
        let raw = &problem.measured - &fitted.prediction;
        let rounding = Rounding::new(problem.rows, fitted.prediction.as_slice());
        let parameters = problem.parameter_columns(fitted);
        let unweighted = Whitener::new(sequence, &rounding, u.map(|u| 1.0 / u), 0.0, errors);
        let basis = problem.smooth_directions(&unweighted, &parameters);
        let mut residual = unweighted.vector(&raw);
        basis.project_out_vector(&mut residual);
        let freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let rms = (residual.norm_squared() / freedom).sqrt().max(f64::MIN_POSITIVE);
        let Correlation { rho, u: u_rho } = sequence.autocorrelation(&residual, basis.directions());
        drop(basis);
        let weights = heavy_tail_weights(&(&residual / rms));
        // White noise has a correlation of this size by chance.
        let (rho, u_rho) = if rho > CORRELATED_U * u_rho {
            (rho, u_rho)
        } else {
            (0.0, 0.0)
        };
        let whitener = Whitener::new(sequence, &rounding, row_scale(u, &weights), rho, errors);
        let basis = problem.smooth_directions(&whitener, &parameters);
        let mut residual = whitener.vector(&raw);
        basis.project_out_vector(&mut residual);
        let freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let variance = |off: f64| {
            let possible = (rho + off).clamp(0.0, MOST_CORRELATED);
            sequence.expected_variance(possible, rho, basis.directions())
        };
        let variance_at = if u_rho > 0.0 {
            [variance(-u_rho), variance(u_rho)]
        } else {
            [1.0; 2]
        };
        let observed = (residual.norm_squared() / freedom).sqrt().max(problem.least_scale);
        let scale = if problem.settings.fit_scale { observed } else { 1.0 };
        let kept = (n * problem.dictionary.width() <= KEPT_VALUES).then(|| {
            let all: Vec<usize> = (0..problem.dictionary.width()).collect();
            let mut columns = problem.dictionary.columns(&all);
            whitener.apply(&mut columns);
            columns
        });
        let reference = Arc::clone(&whitener.reference);
        Self {
            problem,
            start,
            rounding,
            reference,
            noise: Noise {
                scale,
                observed,
                rho,
                u_rho,
                variance_at,
                weights,
            },
            freedom,
            kept,
            nulls,
        }
    }

    pub(super) fn whitener(&self) -> Whitener<'_> {
        Whitener {
            sequence: self.problem.sequence,
            rounding: &self.rounding,
            row_scale: row_scale(&self.problem.u, &self.noise.weights),
            rho: self.noise.rho,
            reference: Arc::clone(&self.reference),
        }
    }

    pub(super) fn fit(&self, members: &[Hypothesis]) -> Option<Fit> {
        fit(
            self.problem.forward,
            &self.problem.measured,
            &self.whitener(),
            &self.start,
            &self.problem.tangents,
            members,
        )
    }

    /// Where the readings put what the model knows of itself, beside a fit.
    pub(super) fn moved(&self, fitted: &Fit) -> Moved {
        let left = &self.problem.measured - &fitted.prediction;
        Moved::of(&self.problem.known, &self.whitener(), &left)
    }

    /// A fit whose refitted terms are held.
    pub(super) fn fit_held(&self, members: &[Hypothesis], weights: &[f64]) -> Option<Fit> {
        let forward = Held {
            forward: self.problem.forward,
            weights,
        };
        fit(
            &forward,
            &self.problem.measured,
            &self.whitener(),
            &self.start,
            &self.problem.tangents,
            members,
        )
    }

    /// Columns of the dictionary, whitened with the present noise.
    pub(super) fn whitened(&self, numbers: &[usize]) -> DMatrix<f64> {
        if let Some(kept) = &self.kept {
            return kept.select_columns(numbers);
        }
        let mut columns = self.problem.dictionary.columns(numbers);
        self.whitener().apply(&mut columns);
        columns
    }
}

/// √weight / u of each row.
fn row_scale(u: &DVector<f64>, weights: &[f64]) -> DVector<f64> {
    u.zip_map(&DVector::from_column_slice(weights), |u, weight| weight.sqrt() / u)
}
