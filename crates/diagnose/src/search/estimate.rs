//! First stage: the problem under one estimate of its noise, every fit and every candidate whitened with it.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::calibration::{CORRELATED_U, MOST_CORRELATED};
use crate::fit::{Fit, fit};
use crate::forward::{Forward, Hypothesis};
use crate::known::{Moved, expected_change};
use crate::noise::limits::FEWEST;
use crate::read_out::ReadOut;
use crate::reference::Reference;
use crate::rounding::Rounding;
use crate::shrinkage::Held;
use crate::whitener::Whitener;
use crate::whitening::{Correlation, Noise, heavy_tail_weights};

use super::fits::Fits;
use super::problem::Problem;

/// A fit of a model that is read out, from given effects on.
type Law<'l> = dyn Fn(&ReadOut<'_>, &[Hypothesis]) -> Option<Fit> + 'l;

/// A whitened dictionary of up to so many values (a quarter of a gigabyte) is kept; a larger one is computed block by
/// block wherever it is needed.
const KEPT_VALUES: usize = 1 << 25;

pub(super) struct Estimate<'p, 'a> {
    pub(super) problem: &'p Problem<'a>,
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
    fits: Fits,
}

/// The model without effects, and the noise that it leaves.
pub(super) struct Baseline<'p, 'a> {
    pub(super) estimate: Estimate<'p, 'a>,
    pub(super) fit: Fit,
}

/// First stage: the noise that the plain fit leaves, and the fit under that noise.
pub(super) fn baseline<'p, 'a>(problem: &'p Problem<'a>) -> Option<Baseline<'p, 'a>> {
    let first = Estimate::of(problem, problem.plain.nuisance.clone(), Arc::default(), &problem.plain);
    let fit = first.fit(&[])?;
    let start = fit.nuisance.clone();
    let estimate = Estimate {
        start,
        fits: Fits::default(),
        ..first
    };
    Some(Baseline { estimate, fit })
}

impl<'p, 'a> Estimate<'p, 'a> {
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

    fn of(problem: &'p Problem<'a>, start: Vec<f64>, nulls: Arc<[f64]>, fitted: &Fit) -> Self {
        let Problem {
            sequence, u, errors, ..
        } = problem;
        let n = problem.measured.len();
        let raw = &problem.measured - &fitted.prediction;
        let rounding = Rounding::new(problem.rows, fitted.prediction.as_slice());
        let forward = ReadOut {
            forward: problem.forward,
            change: &fitted.change,
        };
        let parameters = problem.parameter_columns(&forward, fitted);
        let unweighted = Whitener::new(sequence, &rounding, u.map(|u| 1.0 / u), 0.0, errors);
        let basis = problem.smooth_directions(&unweighted, &parameters);
        let mut residual = unweighted.vector(&raw);
        basis.project_out_vector(&mut residual);
        let freedom = (n as f64 - basis.rank() as f64).max(1.0);
        let rms = (residual.norm_squared() / freedom).sqrt().max(f64::MIN_POSITIVE);
        let Correlation { rho, u: u_rho } = sequence.autocorrelation(&residual, basis.directions());
        // A third of the rms is the least that counts where the noise is not known.
        let stated = if problem.settings.fit_scale { 0.0 } else { 1.0 / rms };
        let least = stated.max(1.0 / 3.0);
        let weights = heavy_tail_weights(&(&residual / rms), sequence, least);
        // White noise has a correlation of this size by chance, and a few rows tell none.
        let (rho, u_rho) = if n >= FEWEST && rho > CORRELATED_U * u_rho {
            (rho, u_rho)
        } else {
            (0.0, 0.0)
        };
        // Without correlation and outliers the second whitening would be the first.
        let (whitener, basis) = if rho == 0.0 && weights.iter().all(|weight| *weight == 1.0) {
            (unweighted, basis)
        } else {
            // The next one is as large.
            drop(basis);
            let whitener = Whitener::new(sequence, &rounding, row_scale(u, &weights), rho, errors);
            let basis = problem.smooth_directions(&whitener, &parameters);
            (whitener, basis)
        };
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
            fits: Fits::default(),
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
        let make = || {
            self.fit_with(members, &|forward, members| {
                fit(
                    forward,
                    &self.problem.measured,
                    &self.whitener(),
                    &self.start,
                    &self.problem.tangents,
                    members,
                )
            })
        };
        self.fits.get_or(members, make)
    }

    /// A fit by `law`, repeated where an effect reads out the light until what the model knows of itself stays where it
    /// is: a sensor that is full hides how bright the light was that filled it.
    fn fit_with(&self, members: &[Hypothesis], law: &Law<'_>) -> Option<Fit> {
        /// Repetitions at most; the change in σ of any row below which there is none, and that of χ² (where steps of a
        /// signal come and go with each repetition, rows never settle).
        const MOST: usize = 12;
        const SETTLED: f64 = 0.1;
        const SETTLED_CHI2: f64 = 1.0;
        let effects = self.problem.forward.effects();
        let reads_out = members.iter().any(|one| effects[one.effect].one_by_one);
        let mut change = DVector::zeros(0);
        if reads_out && !self.problem.known.is_empty() {
            change = DVector::zeros(self.problem.measured.len());
        }
        let is_period = |one: &&Hypothesis| effects[one.effect].period_of_signal;
        if members.iter().any(|one| is_period(&one)) && !self.problem.errors.is_empty() {
            // A period is none but where the light is.
            let others: Vec<Hypothesis> = members.iter().filter(|one| !is_period(one)).cloned().collect();
            change = self.whole_change(&self.fit_with(&others, law)?);
        }
        let mut members = members.to_vec();
        let mut repeated = 0;
        let mut chi2 = f64::INFINITY;
        loop {
            let forward = ReadOut {
                forward: self.problem.forward,
                change: &change,
            };
            let fitted = law(&forward, &members)?;
            repeated += 1;
            if change.is_empty() || repeated == MOST {
                return Some(Fit { change, ..fitted });
            }
            let next = self.change_beside(&forward, &fitted);
            let settled = (&next - &change).component_div(&self.problem.u).amax() < SETTLED;
            if settled || (fitted.chi2 - chi2).abs() < SETTLED_CHI2 {
                return Some(Fit { change, ..fitted });
            }
            members.clone_from(&fitted.hypotheses);
            (change, chi2) = (next, fitted.chi2);
        }
    }

    /// Where the readings put what the model knows of itself, beside a fit.
    pub(super) fn moved(&self, fitted: &Fit) -> Moved {
        let left = &self.problem.measured - &fitted.prediction;
        Moved::of(&self.problem.known, &self.whitener(), &left)
    }

    /// What all errors that rows share are expected to change, beside a fit.
    fn whole_change(&self, fitted: &Fit) -> DVector<f64> {
        let left = &self.problem.measured - &fitted.prediction;
        expected_change(&self.problem.errors, &self.whitener(), &left)
    }

    /// Where the readings that were read out as they are put what the model knows of itself: those at the level of a full
    /// sensor know nothing of the light. Where that leaves too few, all count.
    fn change_beside(&self, forward: &ReadOut<'_>, fitted: &Fit) -> DVector<f64> {
        /// Share of the rows that must be left.
        const LEAST: f64 = 0.1;
        let effects = self.problem.forward.effects();
        if fitted.hypotheses.iter().any(|one| effects[one.effect].period_of_signal) {
            return self.whole_change(fitted);
        }
        let mut changed = vec![false; self.problem.measured.len()];
        let (last, before): (Vec<_>, Vec<_>) = fitted
            .hypotheses
            .iter()
            .cloned()
            .partition(|one| effects[one.effect].one_by_one);
        let light = self.problem.forward.predict(&fitted.nuisance, &before);
        for (one, light) in last.iter().zip(light.iter().cycle()) {
            if let Some(read) = forward.read_out(one.effect, one.linear[0], light) {
                let off = (read - light).component_div(&self.problem.u);
                for (changed, off) in changed.iter_mut().zip(off.iter()) {
                    *changed |= off.abs() > 1e-6;
                }
            }
        }
        let left = changed.iter().filter(|changed| !**changed).count();
        if left as f64 <= LEAST * changed.len() as f64 || left == changed.len() {
            return self.moved(fitted).change;
        }
        let whole = self.whitener();
        let mut row_scale = whole.row_scale.clone();
        for (scale, _) in row_scale.iter_mut().zip(&changed).filter(|(_, changed)| **changed) {
            *scale = 0.0;
        }
        let beside = Whitener::new(
            self.problem.sequence,
            &self.rounding,
            row_scale,
            whole.rho,
            &self.problem.errors,
        );
        let left = &self.problem.measured - &fitted.prediction;
        Moved::of(&self.problem.known, &beside, &left).change
    }

    /// A fit whose refitted terms are held.
    pub(super) fn fit_held(&self, members: &[Hypothesis], weights: &[f64]) -> Option<Fit> {
        self.fit_with(members, &|forward, members| {
            fit(
                &Held { forward, weights },
                &self.problem.measured,
                &self.whitener(),
                &self.start,
                &self.problem.tangents,
                members,
            )
        })
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
