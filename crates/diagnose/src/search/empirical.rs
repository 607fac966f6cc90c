//! Structure that no effect in the catalogue makes: what is left after the names, and what one pattern does better than
//! they.

use super::outcome::Unexplained;
use crate::basis::{Basis, inverse_of_normal};
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::scan::{Who, p_value, strongest_unnamed};

use super::estimate::Estimate;

impl Estimate<'_, '_> {
    /// What is left after all named effects, if it is significant and not small beside them: the best alternative.
    pub(super) fn left_over(&self, fitted: &Fit, members: &[Hypothesis]) -> Option<(usize, f64)> {
        let found = self.scan(fitted, members, None).look();
        if !self.disagrees(&found) {
            return None;
        }
        let strongest = (0..members.len())
            .map(|i| self.explained_by(members, fitted, i))
            .fold(0.0, f64::max);
        let best = strongest_unnamed(&found)?;
        let kept: Vec<usize> = self.kept(members);
        // The disagreement itself may be a name that was not taken: a pattern counts by its own evidence.
        if p_value(best.ln_evidence, &self.nulls) > self.problem.settings.significance {
            return None;
        }
        (best.explained > self.problem.settings.further(strongest)).then_some((kept[best.candidate], best.explained))
    }

    /// The best alternative in the scan of a fit, significant or not.
    pub(super) fn strongest_alternative(&self, fitted: &Fit, members: &[Hypothesis]) -> Option<(usize, f64)> {
        let found = self.scan(fitted, members, None).look();
        let best = strongest_unnamed(&found)?;
        Some((self.kept(members)[best.candidate], best.explained))
    }

    /// The pattern without a name that alone makes what the members (and what they leave unexplained) make, and better.
    ///
    /// Two names and a remainder can imitate one unknown thing; one unknown thing is the simpler belief.
    pub(super) fn one_without_a_name(
        &self,
        fitted: &Fit,
        members: &[Hypothesis],
        extra: Option<(usize, f64)>,
    ) -> Option<(usize, f64)> {
        let base = self.fit(&[])?;
        let found = self.scan(&base, &[], None).look();
        let alone = strongest_unnamed(&found)?;
        let variance = self.noise.scale.powi(2);
        let mut explained = (base.chi2 - fitted.chi2) / variance;
        let mut evidence = 0.5 * explained;
        for (i, member) in members.iter().enumerate() {
            let own = self.explained_by(members, fitted, i);
            evidence += self.refined_evidence(fitted, i, member, own) - 0.5 * own;
        }
        if let Some((candidate, more)) = extra {
            let left = self.scan(fitted, members, None);
            let of = left
                .look()
                .into_iter()
                .find(|one| matches!(one.who, Who::Unnamed { .. }) && self.kept(members)[one.candidate] == candidate)?;
            evidence += of.ln_evidence;
            explained += more;
        }
        let margin = if members.len() + usize::from(extra.is_some()) > 1 {
            0.0
        } else {
            0.5 * self.alias_margin(explained)
        };
        (alone.ln_evidence > evidence + margin).then(|| (self.kept(&[])[alone.candidate], alone.explained))
    }

    pub(super) fn unexplained(&self, fitted: &Fit, candidate: usize, explained: f64) -> Unexplained {
        let Who::Unnamed { alternative } = self.problem.dictionary.candidates[candidate].who else {
            unreachable!("only alternatives are unexplained")
        };
        let out = Basis::spanning(&fitted.jacobian, 1e-9);
        let mut inside = self.pattern(candidate);
        out.project_out(&mut inside);
        let normal = inside.tr_mul(&inside);
        let amplitudes = inverse_of_normal(&normal, 1e-14) * inside.tr_mul(&fitted.residual);
        let numbers: Vec<usize> = self.problem.dictionary.candidates[candidate].columns.clone().collect();
        let pattern = self.problem.dictionary.columns(&numbers) * amplitudes;
        Unexplained {
            alternative: self.problem.alternatives[alternative].clone(),
            sigma: explained.sqrt(),
            pattern,
        }
    }
}
