//! Third stage: the named effects, and what stays without a name.

use crate::calibration::{BESIDE_SHARE, MISFIT, MISFIT_SIGMA};
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::noise::NoiseTest;

use super::estimate::{Baseline, Estimate};
use super::outcome::{Label, Names};
use super::scanned::Scanned;

/// The effects that were taken, and what they leave.
pub(super) struct Selected<'p, 'a> {
    pub(super) estimate: Estimate<'p, 'a>,
    pub(super) names: Names,
    /// Number of the strongest candidate without a name in the dictionary and what it explains, in σ².
    pub(super) unexplained: Option<(usize, f64)>,
    pub(super) noise_test: Option<NoiseTest>,
}

/// What a look at one member's alternatives changed.
pub(super) enum Change {
    None,
    Swapped,
    /// A pattern without a name makes it better, or nothing is left for it to make.
    Dropped,
}

/// Names while the scan disagrees; then whether what they leave is noise.
pub(super) fn select<'p, 'a>(baseline: Baseline<'p, 'a>, scanned: &Scanned) -> Option<Selected<'p, 'a>> {
    let Baseline { estimate, fit } = baseline;
    let estimate = estimate.with_nulls(scanned.nulls.clone());
    let selected = if scanned.p_global <= estimate.problem.settings.significance {
        let (estimate, names) = estimate.grow(&scanned.scan, &scanned.found, &fit);
        estimate.settle(names)?
    } else {
        Selected {
            estimate,
            names: Names::none(&fit),
            unexplained: None,
            noise_test: None,
        }
    };
    selected.noise_tested()
}

impl<'p, 'a> Estimate<'p, 'a> {
    /// Exchanges and drops names until none has a better alternative, and weighs them against what has no name.
    fn settle(self, names: Names) -> Option<Selected<'p, 'a>> {
        let (mut estimate, mut names) = (self, names);
        for _ in 0..4 {
            let left = estimate.left_over(&names.fit, &names.members);
            match estimate.replace_or_drop(&mut names.members, left)? {
                Change::None => break,
                Change::Swapped => {
                    if let Some(fitted) = estimate.fit(&names.members) {
                        names.fit = fitted;
                    }
                    // What the better name leaves may hold a second one.
                    (estimate, names) = estimate.again(&names.fit).extend(names);
                }
                Change::Dropped => {
                    names.fit = estimate.fit(&names.members)?;
                    estimate = estimate.again(&names.fit);
                }
            }
        }
        let Names {
            mut members,
            fit: mut current,
        } = names;
        let mut unexplained = estimate.left_over(&current, &members);
        if let Some((alone, explained)) = estimate.one_without_a_name(&current, &members, unexplained) {
            members.clear();
            unexplained = Some((alone, explained));
        } else if let Some((_, left)) = unexplained {
            // What has no name may be all there is: only names that are strong beside it stay.
            let strong = beside(&members, &estimate.strengths(&members, &current), left);
            if strong.len() < members.len() {
                members = strong;
                current = estimate.fit(&members)?;
                unexplained = estimate.strongest_alternative(&current, &members);
            }
        } else if members.is_empty() {
            unexplained = estimate.strongest_alternative(&current, &members);
        }
        // Strongest first.
        let mut strongest: Vec<(f64, Hypothesis)> = estimate
            .strengths(&members, &current)
            .into_iter()
            .zip(members)
            .collect();
        strongest.sort_by(|a, b| b.0.total_cmp(&a.0));
        let members: Vec<Hypothesis> = strongest.into_iter().map(|(_, member)| member).collect();
        let fit = estimate.fit(&members)?;
        Some(Selected {
            estimate,
            names: Names { members, fit },
            unexplained,
            noise_test: None,
        })
    }

    /// Looks at every member's alternatives: a better name takes its place, a better pattern without a name removes it.
    pub(super) fn replace_or_drop(&self, members: &mut Vec<Hypothesis>, extra: Option<(usize, f64)>) -> Option<Change> {
        for i in 0..members.len() {
            let comparison = self.comparison(members, i, extra)?;
            let Some(top) = comparison.ranked.first() else { continue };
            let nothing = 1.0 - comparison.ranked.iter().map(|ranked| ranked.posterior).sum::<f64>();
            if nothing > top.posterior {
                members.remove(i);
                return Some(Change::Dropped);
            }
            match (&top.label, &top.hypothesis) {
                (Label::Named(effect), Some(hypothesis)) if *effect != members[i].effect => {
                    members[i] = hypothesis.clone();
                    return Some(Change::Swapped);
                }
                (Label::Unnamed(_), _) => {
                    let named: f64 = comparison
                        .ranked
                        .iter()
                        .filter(|ranked| matches!(ranked.label, Label::Named(_)))
                        .map(|ranked| ranked.posterior)
                        .sum();
                    let unnamed: f64 = comparison
                        .ranked
                        .iter()
                        .filter(|ranked| matches!(ranked.label, Label::Unnamed(_)))
                        .map(|ranked| ranked.posterior)
                        .sum();
                    if unnamed > named {
                        members.remove(i);
                        return Some(Change::Dropped);
                    }
                }
                _ => {}
            }
        }
        Some(Change::None)
    }

    /// What each of the members explains, in σ².
    fn strengths(&self, members: &[Hypothesis], fitted: &Fit) -> Vec<f64> {
        (0..members.len())
            .map(|i| self.explained_by(members, fitted, i))
            .collect()
    }
}

/// The members that explain [`BESIDE_SHARE`] times what is left without a name.
fn beside(members: &[Hypothesis], strengths: &[f64], left: f64) -> Vec<Hypothesis> {
    let strong = members
        .iter()
        .zip(strengths)
        .filter(|(_, own)| **own > BESIDE_SHARE * left);
    strong.map(|(member, _)| member.clone()).collect()
}

impl Selected<'_, '_> {
    /// With the test of the noise, and without the names that a place without one explains better.
    fn noise_tested(self) -> Option<Self> {
        let Self {
            estimate,
            mut names,
            mut unexplained,
            ..
        } = self;
        let mut noise_test = estimate.noise_test(&names.fit);
        // A name that leaves nothing but noise stays: a period or a patch of the same readings could always explain a
        // little more.
        if noise_test.as_ref().is_some_and(NoiseTest::disagrees) {
            let (fewer, without) = estimate.no_places(names.members.clone(), &names.fit)?;
            if fewer.len() < names.members.len() {
                names = Names {
                    members: fewer,
                    fit: without,
                };
                noise_test = estimate.noise_test(&names.fit);
            }
        }
        let left = noise_test
            .as_ref()
            .filter(|test| test.disagrees())
            .map(NoiseTest::explained);
        if let Some(left) = left.filter(|_| !names.members.is_empty()) {
            let strengths = estimate.strengths(&names.members, &names.fit);
            let strongest = strengths.iter().copied().fold(0.0, f64::max);
            if left <= estimate.problem.settings.further(strongest) {
                // As small as what the formula of a name may leave.
                noise_test = noise_test.map(NoiseTest::without_findings);
            } else {
                // What is no noise and has no name may be all there is, too.
                let strong = beside(&names.members, &strengths, left);
                if strong.len() < names.members.len() {
                    let fit = estimate.fit(&strong)?;
                    names = Names { members: strong, fit };
                    noise_test = estimate.noise_test(&names.fit);
                    if unexplained.is_some() {
                        unexplained = estimate.strongest_alternative(&names.fit, &names.members);
                    }
                }
            }
        }
        let tested = noise_test.as_ref().is_some_and(NoiseTest::disagrees);
        // By the rows less what was fitted: what is smooth is in this residual, and of a few dozen rows most of it.
        let Fit { residual, jacobian, .. } = &names.fit;
        let freedom = residual.len().saturating_sub(jacobian.ncols()).max(1) as f64;
        let left = names.fit.chi2 / estimate.noise.scale.powi(2) / freedom;
        // Of few rows noise leaves more by chance.
        let most = MISFIT.max(1.0 + MISFIT_SIGMA * (2.0 / freedom).sqrt());
        if unexplained.is_none() && !tested && left > most {
            unexplained = estimate.strongest_alternative(&names.fit, &names.members);
        }
        Some(Self {
            estimate,
            names,
            unexplained,
            noise_test,
        })
    }
}
