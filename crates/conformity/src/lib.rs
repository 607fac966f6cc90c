//! What a laboratory may claim of a measurement: its conditions against their limits, its results against requirements,
//! and what a report has to state.

pub mod before;
mod checklist;
mod conditions;
mod decision;
mod measured;

use isolux_modulation::Modulation;
use isolux_record::{Conditions, Logged, Requirements, Run};
use isolux_reduce::Reduction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use checklist::{Item, checklist};
pub use conditions::{JudgedCondition, Standing};
pub use decision::{Decision, Outcome, decide};

/// `conformity.json`: what was judged of a day.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Conformity {
    /// Standard that the limits of the conditions were taken from, as the job names it.
    pub standard: Option<String>,
    /// The conditions of the measurement.
    pub conditions: Vec<JudgedCondition>,
    /// The requirements of the job.
    pub requirements: Vec<Decision>,
    /// What a report has to state, and what is missing.
    pub checklist: Vec<Item>,
}

impl Conformity {
    /// Of a run, its events, its reduction and the record of its light over time, by the limits of a job.
    pub fn of(
        conditions: &Conditions,
        requirements: &Requirements,
        run: &Run,
        events: &[Logged],
        reduction: &Reduction,
        light: Option<&Modulation>,
    ) -> Self {
        let judged = conditions::judge(conditions, run, events, reduction);
        let requirements = decision::all(requirements, reduction, light);
        Self {
            standard: conditions.standard.clone(),
            checklist: checklist(run, events, reduction, &judged, &requirements),
            conditions: judged,
            requirements,
        }
    }

    /// How many requirements are passed, failed and not decided.
    pub fn counts(&self) -> [usize; 3] {
        [Outcome::Pass, Outcome::Fail, Outcome::NotDecided]
            .map(|outcome| self.requirements.iter().filter(|one| one.outcome == outcome).count())
    }

    /// How many conditions are met, not met and not known.
    pub fn standings(&self) -> [usize; 3] {
        [Standing::Met, Standing::NotMet, Standing::NotKnown]
            .map(|standing| self.conditions.iter().filter(|one| one.standing == standing).count())
    }

    /// The requirements in one sentence; none where nothing is required.
    pub fn sentence(&self) -> Option<String> {
        let [pass, fail, not_decided] = self.counts();
        (!self.requirements.is_empty()).then(|| {
            let failed: Vec<&str> = (self.requirements.iter())
                .filter(|one| one.outcome == Outcome::Fail)
                .map(|one| one.what.as_str())
                .collect();
            let which = if failed.is_empty() {
                String::new()
            } else {
                format!(" ({})", failed.join(", "))
            };
            format!(
                "{pass} of {} pass, {fail} fail{which}, {not_decided} not decided",
                self.requirements.len()
            )
        })
    }
}
