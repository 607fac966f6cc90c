//! A result against a limit by an agreed decision rule (ISO/IEC 17025, 7.8.6; ILAC-G8:09/2019, 4.2; JCGM 106).

use std::f64::consts::SQRT_2;

use isolux_modulation::Modulation;
use isolux_record::Bounds;
use isolux_record::requirements::{DecisionRule, Requirement, Requirements};
use isolux_reduce::{Quantity, Reduction};
use isolux_units::digits::K;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::measured;

/// What a decision says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The requirement is kept.
    Pass,
    /// It is not.
    Fail,
    /// The rule gives no decision, or what it needs is not known.
    NotDecided,
}

impl Outcome {
    /// As a table has it.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::NotDecided => "cannot be decided",
        }
    }
}

/// A requirement and what was decided of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Decision {
    /// Name of the quantity, with its unit.
    pub quantity: String,
    /// What it is, with its half-plane where there are several.
    pub what: String,
    /// What was measured; null where it was not.
    pub measured: Option<Quantity>,
    /// Smallest value that is allowed.
    pub smallest: Option<f64>,
    /// Largest value that is allowed.
    pub largest: Option<f64>,
    /// The rule: `simple`, `guarded` or `shared_risk`.
    #[schemars(with = "String")]
    pub rule: DecisionRule,
    /// What was decided.
    pub outcome: Outcome,
    /// Probability that the decision is false: that the true value is beyond the limit where it passed, within it where
    /// it failed; null where there is no decision, or no uncertainty.
    pub probability_false: Option<f64>,
    /// Why there is no decision, or no probability.
    pub reason: Option<String>,
    /// Where the limit comes from.
    pub source: Option<String>,
}

/// Every requirement of a job.
pub fn all(requirements: &Requirements, reduction: &Reduction, light: Option<&Modulation>) -> Vec<Decision> {
    let mut decisions = Vec::new();
    for limit in &requirements.limit {
        // A job was checked when it was read.
        let (Some(key), Some(rule), Ok(bounds)) = (limit.key(), requirements.rule_of(limit), limit.limits("")) else {
            continue;
        };
        let found = measured::of(limit, reduction, light);
        if found.is_empty() {
            decisions.push(decision(limit, key.what.to_owned(), rule, bounds, None));
        }
        decisions.extend(found.into_iter().map(|(plane, quantity)| {
            let what = plane.map_or_else(|| key.what.to_owned(), |plane| format!("{}, {plane}", key.what));
            decision(limit, what, rule, bounds, Some(quantity))
        }));
    }
    decisions
}

fn decision(
    limit: &Requirement,
    what: String,
    rule: DecisionRule,
    bounds: Bounds,
    measured: Option<Quantity>,
) -> Decision {
    let (outcome, probability_false, reason) = match &measured {
        None => (Outcome::NotDecided, None, Some("not measured".to_owned())),
        Some(quantity) => {
            let (outcome, probability) = decide(rule, bounds, quantity.value, quantity.u, limit.largest_u);
            let reason = match (outcome, quantity.u) {
                (_, None) => Some(format!("no uncertainty: {}", quantity.missing.join("; "))),
                (Outcome::NotDecided, Some(u)) if rule == DecisionRule::SharedRisk => Some(format!(
                    "U is {:.3}, above the {} that was agreed",
                    K * u,
                    limit.largest_u.unwrap_or_default()
                )),
                (Outcome::NotDecided, Some(_)) => Some("the value lies within U of the limit".to_owned()),
                _ => None,
            };
            (outcome, probability, reason)
        }
    };
    Decision {
        quantity: limit.quantity.clone(),
        what,
        measured,
        smallest: bounds.smallest,
        largest: bounds.largest,
        rule,
        outcome,
        probability_false,
        reason,
        source: limit.source.clone(),
    }
}

/// The decision on `value` with its standard uncertainty `u`, and the probability that it is false: of a normal
/// distribution about the value, nothing being known of the luminaire before (JCGM 106, 7.4). `largest_u` is the
/// expanded uncertainty that was agreed for a shared risk.
pub fn decide(
    rule: DecisionRule,
    bounds: Bounds,
    value: f64,
    u: Option<f64>,
    largest_u: Option<f64>,
) -> (Outcome, Option<f64>) {
    let by_value = if bounds.hold(value) {
        Outcome::Pass
    } else {
        Outcome::Fail
    };
    let outcome = match (rule, u) {
        _ if !value.is_finite() => Outcome::NotDecided,
        (DecisionRule::Simple, _) => by_value,
        (DecisionRule::Guarded, Some(u)) if bounds.narrowed(K * u).hold(value) => Outcome::Pass,
        (DecisionRule::Guarded, Some(u)) if !bounds.narrowed(-K * u).hold(value) => Outcome::Fail,
        (DecisionRule::SharedRisk, Some(u)) if largest_u.is_some_and(|largest| K * u <= largest) => by_value,
        (DecisionRule::Guarded | DecisionRule::SharedRisk, _) => Outcome::NotDecided,
    };
    let within = u.map(|u| within(bounds, value, u));
    let probability = match outcome {
        Outcome::Pass => within.map(|within| 1.0 - within),
        Outcome::Fail => within,
        Outcome::NotDecided => None,
    };
    (outcome, probability)
}

/// Probability that the true value lies within the limits.
fn within(bounds: Bounds, value: f64, u: f64) -> f64 {
    if u == 0.0 {
        return f64::from(u8::from(bounds.hold(value)));
    }
    // From the tail, so that small ones keep their digits.
    let beyond = |by: f64| 0.5 * libm::erfc(by / (u * SQRT_2));
    let below = bounds.smallest.map_or(0.0, |smallest| beyond(value - smallest));
    let above = bounds.largest.map_or(0.0, |largest| beyond(largest - value));
    (1.0 - below - above).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        smallest: Some(300.0),
        largest: Some(400.0),
    };

    #[test]
    fn rules_differ_within_the_uncertainty_of_a_limit_alone() {
        use DecisionRule::{Guarded, SharedRisk, Simple};
        use Outcome::{Fail, NotDecided, Pass};
        let of = |rule, value, u| decide(rule, BOUNDS, value, u, Some(5.0)).0;
        for (value, simple, guarded) in [
            (350.0, Pass, Pass),
            (304.1, Pass, Pass),
            (303.9, Pass, NotDecided),
            (300.0, Pass, NotDecided),
            (299.9, Fail, NotDecided),
            (295.9, Fail, Fail),
            (404.1, Fail, Fail),
        ] {
            assert_eq!(of(Simple, value, Some(2.0)), simple, "{value}");
            assert_eq!(of(Guarded, value, Some(2.0)), guarded, "{value}");
            assert_eq!(of(SharedRisk, value, Some(2.0)), simple, "{value}");
            // Above what was agreed.
            assert_eq!(of(SharedRisk, value, Some(2.6)), NotDecided, "{value}");
            assert_eq!(
                (of(Guarded, value, None), of(Simple, value, None)),
                (NotDecided, simple)
            );
        }
        let at = |value| decide(Simple, BOUNDS, value, Some(2.0), None).1.unwrap();
        // One and two standard uncertainties of a normal distribution: 15.87 % and 2.28 %.
        assert!((at(302.0) - 0.158_655).abs() < 1e-6 && (at(396.0) - 0.022_750).abs() < 1e-6);
        assert!((at(298.0) - 0.158_655).abs() < 1e-6);
    }

    /// The stated probability against what happens: true values that nothing is known of, each measured once.
    #[test]
    fn false_decisions_are_as_frequent_as_stated() {
        let mut state = 7_u64;
        let mut unit = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        for (rule, u) in [
            (DecisionRule::Simple, 4.0),
            (DecisionRule::Simple, 30.0),
            (DecisionRule::Guarded, 4.0),
            (DecisionRule::SharedRisk, 4.0),
        ] {
            for wanted in [Outcome::Pass, Outcome::Fail] {
                let (mut decided, mut false_ones, mut stated) = (0_u32, 0_u32, 0.0);
                for _ in 0..400_000 {
                    let truth = 150.0 + 400.0 * unit();
                    let noise = (-2.0 * unit().ln()).sqrt() * (std::f64::consts::TAU * unit()).cos();
                    let value = truth + u * noise;
                    // Where the range of true values ends, something is known of them.
                    if !(240.0..=460.0).contains(&value) {
                        continue;
                    }
                    let (outcome, probability) = decide(rule, BOUNDS, value, Some(u), Some(10.0));
                    if outcome == wanted {
                        decided += 1;
                        stated += probability.unwrap();
                        false_ones += u32::from(BOUNDS.hold(truth) != (wanted == Outcome::Pass));
                    }
                }
                let scatter = f64::from(false_ones).max(9.0).sqrt();
                assert!(
                    (f64::from(false_ones) - stated).abs() < 4.0 * scatter,
                    "{rule:?} u {u} {wanted:?}: {false_ones} of {decided}, stated {stated}"
                );
            }
        }
    }
}
