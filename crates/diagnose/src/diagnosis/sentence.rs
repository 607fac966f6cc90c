//! The verdict, and the one sentence that says it.

use isolux_model::digits;

use crate::document::{EffectEntry, Independence, UnexplainedEntry, Verdict};
use crate::search::Outcome;

pub(super) fn verdict(outcome: &Outcome, effects: &[EffectEntry]) -> Verdict {
    if outcome.unexplained.is_some() {
        Verdict::Unexplained
    } else if effects.iter().any(|effect| !effect.equivalents.is_empty()) {
        Verdict::Ambiguous
    } else if effects.is_empty() {
        Verdict::Consistent
    } else {
        Verdict::Named
    }
}

pub(super) fn sentence(
    verdict: Verdict,
    effects: &[EffectEntry],
    unexplained: Option<&UnexplainedEntry>,
    outcome: &Outcome,
    independence: Independence,
) -> String {
    if independence == Independence::SameRun {
        // What was fitted to the readings agrees with them; that it does is no evidence, and its p would look like
        // some.
        return match verdict {
            Verdict::Consistent => format!(
                "consistency check of the record: its readings agree with the model that was made from them (noise {:.2} × stated); \
                 this is no test of the model",
                outcome.noise.scale
            ),
            _ => format!(
                "consistency check of the record: its readings disagree with the model that was made from them: {}",
                described(verdict, effects, unexplained, outcome)
            ),
        };
    }
    described(verdict, effects, unexplained, outcome)
}

fn described(
    verdict: Verdict,
    effects: &[EffectEntry],
    unexplained: Option<&UnexplainedEntry>,
    outcome: &Outcome,
) -> String {
    let sets: Vec<String> = effects
        .iter()
        .map(|effect| {
            let mut set = vec![format!("{}{}", effect.name, changes(effect))];
            set.extend(effect.equivalents.iter().cloned());
            set.join(" or ")
        })
        .collect();
    let named = sets.join(", and ");
    match verdict {
        Verdict::Consistent => format!(
            "model and measurement agree within noise (p = {:.3}, noise {:.2} × stated)",
            outcome.p_global, outcome.noise.scale
        ),
        Verdict::Named => format!("the data single out {named}"),
        Verdict::Ambiguous => format!("something is missing, and these data cannot tell which: {named}"),
        Verdict::Unexplained => {
            let place = unexplained.map_or_else(String::new, |u| {
                format!(
                    "{}, along {} between {} and {} ({:.1} σ)",
                    u.note,
                    u.coordinate,
                    digits(u.range[0], 4),
                    digits(u.range[1], 4),
                    u.significance_sigma
                )
            });
            let besides = if named.is_empty() {
                String::new()
            } else {
                format!("; besides: {named}")
            };
            format!("unexplained: {place}; no effect in the catalogue makes it{besides}")
        }
    }
}

/// What the amplitudes of an effect that the model has already have changed to; nothing for a new one.
fn changes(effect: &EffectEntry) -> String {
    let changed: Vec<String> = effect
        .parameters
        .iter()
        .filter_map(|(key, parameter)| {
            let before = parameter.before.filter(|before| *before != parameter.value)?;
            let (from, to) = (digits(before, 3), digits(parameter.value, 3));
            Some(format!("{key} changed from {from} to {to}"))
        })
        .collect();
    if changed.is_empty() {
        String::new()
    } else {
        format!(" ({})", changed.join(", "))
    }
}
