//! Who else could make what one member makes, and how probable each of them is.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::outcome::{Comparison, Label, Ranked};
use crate::basis::Basis;
use crate::calibration::{ALIAS, ALIAS_MARGIN, AS_MUCH, OUTSIDE_CATALOGUE, REFITTED, TWIN};
use crate::evidence::{ln_bayes_factor, ln_sum_exp};
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::scan::{Found, Who, p_value, sign_evidence, statistic};

use super::candidates::all_but;
use super::estimate::Estimate;

/// One row of a comparison before it is a probability.
struct Entry {
    label: Label,
    /// Every pattern under this label.
    evidence: Vec<Evidence>,
    explained: f64,
    hypothesis: Option<Hypothesis>,
}

/// What one pattern says.
#[derive(Clone, Copy)]
struct Evidence {
    /// ln(prior · Bayes factor).
    ln: f64,
    /// σ² that it explains.
    explained: f64,
    /// Its directions.
    directions: usize,
}

impl Evidence {
    /// The same with a likelihood that is as blunt as if the noise were larger, what was assumed before as it was.
    fn blunted(&self, sharpness: f64) -> f64 {
        self.ln - ln_bayes_factor(self.explained, self.directions)
            + ln_bayes_factor(self.explained * sharpness, self.directions)
    }
}

/// An effect in the place of the member, fitted.
struct Refined {
    effect: usize,
    hypothesis: Hypothesis,
    /// σ² that it explains.
    explained: f64,
    /// ln(prior · Bayes factor).
    evidence: f64,
}

impl Estimate<'_, '_> {
    /// A possible name that explains as much as the first one stays within reach of it, whatever was assumed before: no
    /// prior of ours is worth more than [`TWIN`]. `entries` fall with their evidence, and do after it.
    fn keep_twins(&self, entries: &mut [(f64, Entry)]) {
        let Some((top, first)) = entries.first().map(|(evidence, entry)| (*evidence, entry)) else {
            return;
        };
        if !matches!(first.label, Label::Named(_)) {
            return;
        }
        let least = first.explained - AS_MUCH;
        let possible = |entry: &Entry| match (&entry.label, &entry.hypothesis) {
            (Label::Named(effect), Some(hypothesis)) => {
                let searchable = &self.problem.forward.effects()[*effect];
                let right_way = !searchable.one_sided || hypothesis.linear[0] >= 0.0;
                right_way && searchable.implausibility(&hypothesis.linear) == 0.0
            }
            _ => false,
        };
        for (evidence, entry) in entries.iter_mut().skip(1) {
            if entry.explained >= least && possible(entry) {
                *evidence = evidence.max(top - TWIN);
            }
        }
        entries.sort_by(|a, b| b.0.total_cmp(&a.0));
    }

    /// Who else could be member `i`, with all other members free and what is unexplained projected out.
    pub(super) fn comparison(
        &self,
        members: &[Hypothesis],
        i: usize,
        extra: Option<(usize, f64)>,
    ) -> Option<Comparison> {
        let others = all_but(members, i);
        let base = self.fit(&others)?;
        let scan = self.scan(&base, &others, extra.map(|(candidate, _)| candidate));
        let found = scan.look();
        let named = self.name_evidence(&found);
        let top = named.first().map_or(f64::NEG_INFINITY, |(_, evidence)| *evidence);
        let variance = self.noise.scale.powi(2);
        let (most, apart, share) = REFITTED;
        let close: Vec<usize> = named
            .iter()
            .enumerate()
            .filter(|(rank, (effect, evidence))| {
                *effect == members[i].effect || (*rank < most && *evidence > top - apart - share * top.max(0.0))
            })
            .map(|(_, (effect, _))| *effect)
            .collect();
        let refined: Vec<Refined> = close
            .par_iter()
            .filter_map(|&effect| {
                let (start, linear) = self.guess(&base, &found, effect)?;
                let start = if effect == members[i].effect {
                    members[i].clone()
                } else {
                    start
                };
                let mut tried = others.clone();
                tried.push(start);
                let fitted = self.fit(&tried)?;
                let hypothesis = fitted.hypotheses.last()?.clone();
                // With a pattern without a name beside it only the scan knows what is left for the name.
                let explained = if extra.is_some() {
                    linear
                } else {
                    (base.chi2 - fitted.chi2) / variance
                };
                Some(Refined {
                    effect,
                    evidence: self.refined_evidence(&fitted, others.len(), &hypothesis, explained),
                    hypothesis,
                    explained,
                })
            })
            .collect();
        let entries = self.entries(&named, &refined, &found);
        // What the formulas are allowed to be wrong by adds to the noise of every comparison: the likelihood is blunted
        // by that, never what was assumed before.
        let strongest = entries.iter().map(|entry| entry.explained).fold(0.0, f64::max);
        let sharpness = 1.0 / (1.0 + self.problem.settings.model_form.powi(2) * strongest);
        let blunted = |entry: &Entry| {
            let terms: Vec<f64> = entry.evidence.iter().map(|one| one.blunted(sharpness)).collect();
            ln_sum_exp(&terms)
        };
        let mut entries: Vec<(f64, Entry)> = entries.into_iter().map(|entry| (blunted(&entry), entry)).collect();
        entries.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.keep_twins(&mut entries);
        let best = entries.first().map_or(0.0, |entry| entry.0).max(0.0);
        let weights: Vec<f64> = entries.iter().map(|entry| (entry.0 - best).exp()).collect();
        let total = weights.iter().sum::<f64>() + (-best).exp();
        let own = entries
            .iter()
            .find(|(_, entry)| entry.label == Label::Named(members[i].effect))
            .map_or(0.0, |(_, entry)| {
                ln_sum_exp(&entry.evidence.iter().map(|one| one.ln).collect::<Vec<_>>())
            });
        let ranked = entries
            .into_iter()
            .zip(weights)
            .map(|((_, entry), weight)| Ranked {
                label: entry.label,
                posterior: weight / total,
                ln_evidence: ln_sum_exp(&entry.evidence.iter().map(|one| one.ln).collect::<Vec<_>>()),
                sigma: entry.explained.max(0.0).sqrt(),
                hypothesis: entry.hypothesis,
            })
            .collect();
        Some(Comparison {
            ranked,
            ln_bayes_factor: own,
            p_value: p_value(statistic(&found), &self.nulls),
        })
    }

    /// What could be the member: every name as it was refitted or as the scan saw it, and the coordinates without one.
    fn entries(&self, named: &[(usize, f64)], refined: &[Refined], found: &[Found]) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::new();
        for &(effect, evidence) in named {
            let linear = found
                .iter()
                .filter(|one| matches!(one.who, Who::Named { effect: e, .. } if e == effect))
                .map(|one| one.explained)
                .fold(0.0, f64::max);
            let directions = self.problem.forward.effects()[effect].step.len();
            entries.push(match refined.iter().find(|refined| refined.effect == effect) {
                Some(refined) => Entry {
                    label: Label::Named(effect),
                    evidence: vec![Evidence {
                        ln: refined.evidence,
                        explained: refined.explained,
                        directions,
                    }],
                    explained: refined.explained,
                    hypothesis: Some(refined.hypothesis.clone()),
                },
                None => Entry {
                    label: Label::Named(effect),
                    evidence: vec![Evidence {
                        ln: evidence,
                        explained: linear,
                        directions,
                    }],
                    explained: linear,
                    hypothesis: None,
                },
            });
        }
        let best_name = entries.iter().map(|entry| entry.explained).fold(0.0, f64::max);
        for one in found {
            if let Who::Unnamed { alternative } = one.who {
                let label = Label::Unnamed(self.problem.alternatives[alternative].coordinate);
                // A generic pattern that does no better than a name is that name's likeness, not another cause.
                let alias = one.explained < best_name + self.alias_margin(best_name);
                let evidence = Evidence {
                    ln: one.ln_evidence - if alias { ALIAS } else { 0.0 },
                    explained: one.explained,
                    directions: self.problem.alternatives[alternative].directions,
                };
                match entries.iter_mut().find(|entry| entry.label == label) {
                    Some(entry) => {
                        entry.evidence.push(evidence);
                        entry.explained = entry.explained.max(one.explained);
                    }
                    None => entries.push(Entry {
                        label,
                        evidence: vec![evidence],
                        explained: one.explained,
                        hypothesis: None,
                    }),
                }
            }
        }
        entries
    }

    /// ln(prior · Bayes factor) of member `i` of a fit that explains `explained`, its shape averaged over what was
    /// assumed of it (Laplace).
    pub(super) fn refined_evidence(&self, fitted: &Fit, i: usize, member: &Hypothesis, explained: f64) -> f64 {
        let effects = self.problem.forward.effects();
        let searchable = &effects[member.effect];
        let mut evidence = ((1.0 - OUTSIDE_CATALOGUE) / effects.len().max(1) as f64).ln()
            + ln_bayes_factor(explained, member.linear.len());
        if searchable.one_sided {
            evidence += sign_evidence(member.linear[0]);
        }
        evidence += searchable.ln_small(member.linear[0]) - 0.5 * searchable.implausibility(&member.linear);
        let fixed = !searchable.fixed.is_empty() && searchable.fixed.iter().all(|fixed| *fixed);
        if fixed || searchable.one_by_one {
            return evidence - searchable.ways().ln();
        }
        let free: Vec<usize> = (0..member.shape.len()).filter(|&j| !searchable.fixed[j]).collect();
        if free.is_empty() {
            return evidence;
        }
        // The columns of this member's shapes, everything else projected out.
        let width = |hypothesis: &Hypothesis| {
            let fixed = &effects[hypothesis.effect].fixed;
            hypothesis.linear.len() + fixed.iter().filter(|fixed| !**fixed).count()
        };
        let start =
            fitted.nuisance.len() + fitted.hypotheses[..i].iter().map(width).sum::<usize>() + member.linear.len();
        let own = start..start + free.len();
        let rest: Vec<usize> = (0..fitted.jacobian.ncols()).filter(|k| !own.contains(k)).collect();
        let mut inside = fitted.jacobian.columns(own.start, own.len()).into_owned();
        Basis::spanning(&fitted.jacobian.select_columns(&rest), 1e-9).project_out(&mut inside);
        for (place, &j) in free.iter().enumerate() {
            let spread = searchable.assumed[j];
            inside.column_mut(place).scale_mut(spread.sigma() / self.noise.scale);
            evidence -= 0.5 * spread.beyond(member.shape[j]).powi(2);
        }
        let information = DMatrix::identity(free.len(), free.len()) + inside.tr_mul(&inside);
        let determinant = information.determinant();
        if determinant.is_finite() {
            evidence - 0.5 * determinant.max(1.0).ln()
        } else {
            evidence
        }
    }

    /// What a pattern without a name must explain more than a name, in σ², before it counts as another pattern.
    pub(super) fn alias_margin(&self, explained: f64) -> f64 {
        ALIAS_MARGIN + 4.0 * self.problem.settings.model_form.powi(2) * explained.max(0.0)
    }
}
