//! Fourth stage: who else could make what each name makes, and what is found in the end.

use nalgebra::DVector;

use crate::alternatives::EmpiricalAlternative;
use crate::forward::Hypothesis;
use crate::noise::{NoiseTest, noisy_rho};
use crate::shrinkage::weights;

use super::outcome::{Comparison, Label, Names, Outcome, Unexplained};
use super::scanned::Scanned;
use super::select::Selected;

pub(super) fn compete(scanned: Scanned, selected: Selected<'_, '_>) -> Option<Outcome> {
    let Selected {
        estimate,
        names: Names {
            mut members,
            fit: mut current,
        },
        unexplained,
        noise_test,
    } = selected;
    let problem = estimate.problem;
    let all = |members: &[Hypothesis]| {
        let of = |i: usize| estimate.comparison(members, i, unexplained);
        (0..members.len()).map(of).collect::<Option<Vec<_>>>()
    };
    let mut comparisons = all(&members)?;
    // Of two names that are hardly apart the last refit may have put the other first, and left a weak one nothing to
    // make.
    let before = members.clone();
    for (i, comparison) in comparisons.iter().enumerate() {
        if let Some(better) = better_name(&members, i, comparison) {
            members[i] = better;
        }
    }
    if !comparisons.iter().all(nothing_is_likelier) {
        let mut nothing = comparisons.iter().map(nothing_is_likelier);
        members.retain(|_| !nothing.next().unwrap_or(false));
    }
    if members != before {
        current = estimate.fit(&members)?;
        members.clone_from(&current.hypotheses);
        comparisons = all(&members)?;
    }
    let unexplained = unexplained
        .map(|(candidate, explained)| estimate.unexplained(&current, candidate, explained))
        .or_else(|| noise_test.as_ref().and_then(|test| no_noise(test, problem.rows.len())));
    let mut noise = estimate.noise.clone();
    if let Some(test) = noise_test.as_ref().filter(|test| test.disagrees()) {
        // What is no noise makes none larger.
        noise.scale = noise.scale.min(test.limit);
        noise.rho = noisy_rho(noise.rho);
    }
    let held = weights(problem.forward, &current, noise.scale);
    let baseline = estimate.fit_held(&[], &held)?;
    let after = estimate.fit_held(&members, &held)?;
    Some(Outcome {
        moved_before: estimate.moved(&baseline),
        moved_after: estimate.moved(&after),
        known: problem.known.clone(),
        baseline,
        after,
        noise,
        rounding: estimate.rounding,
        errors: problem.errors.clone(),
        p_global: scanned.p_global,
        comparisons,
        unexplained,
        places: scanned.places,
        visibility: scanned.visibility,
        noise_test,
        held,
        nulls: problem.settings.nulls,
        sequence: problem.sequence.clone(),
    })
}

/// What a test of the noise found, as structure without a name.
fn no_noise(test: &NoiseTest, rows: usize) -> Option<Unexplained> {
    let first = test.findings.first()?;
    Some(Unexplained {
        alternative: EmpiricalAlternative {
            coordinate: first.coordinate,
            family: "noise",
            range: first.range,
            note: test.note(),
            directions: 0,
            columns: Vec::new(),
        },
        sigma: test.explained().sqrt(),
        pattern: DVector::zeros(rows),
    })
}

/// The hypothesis of another name that is more probable than member `i`'s, and no member itself.
fn better_name(members: &[Hypothesis], i: usize, comparison: &Comparison) -> Option<Hypothesis> {
    let top = comparison.ranked.first()?;
    let is_new = |effect: usize| members.iter().all(|member| member.effect != effect);
    match top.label {
        Label::Named(effect) if effect != members[i].effect && is_new(effect) => top.hypothesis.clone(),
        _ => None,
    }
}

/// Whether nothing at all is more probable than any name or pattern.
fn nothing_is_likelier(comparison: &Comparison) -> bool {
    let all: f64 = comparison.ranked.iter().map(|ranked| ranked.posterior).sum();
    comparison.ranked.first().is_none_or(|top| 1.0 - all > top.posterior)
}
