//! Candidates against what a fit leaves, under one estimate of the noise.

use nalgebra::DMatrix;

use crate::basis::{Basis, inverse_of_normal};
use crate::evidence::ln_sum_exp;
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::scan::{Candidate, Found, Scan, Who, p_value, statistic};

use super::estimate::Estimate;

impl Estimate<'_, '_> {
    /// The scan of what a fit leaves, all candidates against its residual; effects that are in it already and `extra`
    /// directions are projected out.
    pub(super) fn scan(&self, fitted: &Fit, members: &[Hypothesis], extra: Option<usize>) -> Scan {
        let mut out = Basis::spanning(&fitted.jacobian, 1e-9);
        if let Some(candidate) = extra {
            out.extend(&self.pattern(candidate), 1e-6);
        }
        let kept: Vec<_> = self
            .problem
            .dictionary
            .candidates
            .iter()
            .filter(|candidate| match candidate.who {
                Who::Named { effect, .. } => members.iter().all(|member| member.effect != effect),
                Who::Unnamed { .. } => true,
            })
            .cloned()
            .collect();
        let residual = &fitted.residual / self.noise.scale;
        let whitened = |numbers: &[usize]| self.whitened(numbers);
        let freedom = self.problem.settings.fit_scale.then_some(self.freedom);
        Scan::new(&whitened, kept, out, &residual, self.noise.scale, freedom)
    }

    /// The whitened columns of one candidate.
    pub(super) fn pattern(&self, candidate: usize) -> DMatrix<f64> {
        self.whitened(
            &self.problem.dictionary.candidates[candidate]
                .columns
                .clone()
                .collect::<Vec<_>>(),
        )
    }

    /// Numbers, in the dictionary, of the candidates that a scan with these members keeps.
    pub(super) fn kept(&self, members: &[Hypothesis]) -> Vec<usize> {
        (0..self.problem.dictionary.candidates.len())
            .filter(|&k| match self.problem.dictionary.candidates[k].who {
                Who::Named { effect, .. } => members.iter().all(|member| member.effect != effect),
                Who::Unnamed { .. } => true,
            })
            .collect()
    }

    /// Whether noise alone makes a scan like this less often than the significance, or never did.
    pub(super) fn disagrees(&self, found: &[Found]) -> bool {
        let never = 1.0 / (self.nulls.len() + 1) as f64;
        p_value(statistic(found), &self.nulls) <= self.problem.settings.significance.max(never)
    }

    pub(super) fn name_evidence(&self, found: &[Found]) -> Vec<(usize, f64)> {
        let mut terms: Vec<Vec<f64>> = vec![Vec::new(); self.problem.forward.effects().len()];
        for one in found {
            if let Who::Named { effect, .. } = one.who {
                terms[effect].push(one.ln_evidence);
            }
        }
        let mut named: Vec<(usize, f64)> = terms
            .iter()
            .enumerate()
            .filter(|(_, terms)| !terms.is_empty())
            .map(|(effect, terms)| (effect, ln_sum_exp(terms)))
            .collect();
        named.sort_by(|a, b| b.1.total_cmp(&a.1));
        named
    }

    /// The best shape of an effect in a scan, as a starting point for the fit.
    pub(super) fn guess(&self, fitted: &Fit, found: &[Found], effect: usize) -> Option<(Hypothesis, f64)> {
        let best = found
            .iter()
            .filter(|one| matches!(one.who, Who::Named { effect: e, .. } if e == effect))
            .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))?;
        let Who::Named { shape, .. } = best.who else {
            return None;
        };
        let shape = if self.problem.forward.effects()[effect].one_by_one {
            self.nearest_value(fitted, effect)?
        } else {
            shape
        };
        let who = Who::Named { effect, shape };
        Some((self.hypothesis(fitted, who, shape)?, best.explained))
    }

    /// Of an effect whose amplitudes are tried one by one, the one that leaves least of what a fit leaves: its pattern has
    /// one size, which the scan does not ask for.
    fn nearest_value(&self, fitted: &Fit, effect: usize) -> Option<usize> {
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut residual = fitted.residual.clone();
        out.project_out_vector(&mut residual);
        let searchable = &self.problem.forward.effects()[effect];
        let candidates = self.problem.dictionary.candidates.iter().enumerate();
        let left = candidates.filter_map(|(number, candidate)| match candidate.who {
            Who::Named { effect: e, shape } if e == effect => {
                let mut pattern = self.pattern(number) * searchable.step_of(shape, 0);
                out.project_out(&mut pattern);
                Some((shape, (&residual - pattern.column(0)).norm_squared()))
            }
            _ => None,
        });
        left.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(shape, _)| shape)
    }

    /// A hypothesis with the amplitudes that the linear model gives.
    pub(super) fn hypothesis(&self, fitted: &Fit, who: Who, shape: usize) -> Option<Hypothesis> {
        let Who::Named { effect, .. } = who else { return None };
        let searchable = &self.problem.forward.effects()[effect];
        let is_it = |candidate: &Candidate| candidate.who == who;
        let candidate = self.problem.dictionary.candidates.iter().position(is_it)?;
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut columns = self.pattern(candidate);
        out.project_out(&mut columns);
        let mut residual = fitted.residual.clone();
        out.project_out_vector(&mut residual);
        let normal = columns.tr_mul(&columns);
        let inverse = inverse_of_normal(&normal, 1e-14);
        let mut linear: Vec<f64> = (inverse * columns.tr_mul(&residual)).iter().copied().collect();
        for (value, (low, high)) in linear.iter_mut().zip(&searchable.limits) {
            *value = value.clamp(*low, *high);
        }
        if searchable.one_by_one {
            linear[0] = searchable.step_of(shape, 0);
        }
        if searchable.never_negative {
            linear[0] = linear[0].max(0.05 * searchable.step_of(shape, 0));
        }
        Some(Hypothesis {
            effect,
            linear,
            shape: searchable.shapes[shape].clone(),
        })
    }

    /// Squared significance of member `i` with all others free.
    pub(super) fn explained_by(&self, members: &[Hypothesis], fitted: &Fit, i: usize) -> f64 {
        let others = all_but(members, i);
        self.fit(&others)
            .map_or(0.0, |without| (without.chi2 - fitted.chi2) / self.noise.scale.powi(2))
    }
}

/// The members without the one at `i`.
pub(super) fn all_but(members: &[Hypothesis], i: usize) -> Vec<Hypothesis> {
    [&members[..i], &members[i + 1..]].concat()
}
