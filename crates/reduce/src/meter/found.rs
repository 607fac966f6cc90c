//! What one property of the lux meter does to the readings of a run, corrected or not.

use isolux_record::{Quality, Reading, ReadingKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The factors of a property of the lux meter as `budget.json` has them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MeterFactors {
    /// Whether readings were multiplied by them.
    pub corrected: bool,
    /// Smallest and largest of the lit readings.
    pub factor: [f64; 2],
    /// Relative standard uncertainty that all readings share.
    pub u_rel: f64,
}

/// What a property does.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// By what each row is multiplied; empty: by nothing.
    pub factors: Vec<f64>,
    /// Relative standard uncertainty that all readings share.
    pub u_rel: f64,
    /// What no part says.
    pub missing: Option<String>,
    /// What a person should know.
    pub note: Option<String>,
    /// The table of the effect that makes readings again, as a model file has it.
    pub effect: Option<String>,
    /// The factors, where they are known.
    pub facts: Option<MeterFactors>,
}

impl Found {
    /// Of factors of all rows with the uncertainty `u_rel`: applied, or what they leave where they are not.
    pub fn of(rows: &[Reading], factors: Vec<f64>, u_rel: f64, corrected: bool) -> Self {
        let mut factor = [f64::INFINITY, f64::NEG_INFINITY];
        for (_, value) in rows.iter().zip(&factors).filter(|(row, _)| is_lit(row)) {
            factor = [factor[0].min(*value), factor[1].max(*value)];
        }
        if factor[0] > factor[1] {
            factor = [1.0; 2];
        }
        let left_out = factor.map(|factor| (factor - 1.0).abs());
        let u_rel = if corrected {
            u_rel
        } else {
            u_rel.hypot(left_out[0].max(left_out[1]))
        };
        Self {
            u_rel,
            facts: Some(MeterFactors {
                corrected,
                factor,
                u_rel,
            }),
            factors: if corrected { factors } else { Vec::new() },
            ..Self::default()
        }
    }

    /// Something that nothing is known of.
    pub fn unknown(what: String) -> Self {
        Self {
            missing: Some(what),
            ..Self::default()
        }
    }
}

/// Whether a row is a reading of the lamp with a number.
pub fn is_lit(row: &Reading) -> bool {
    row.kind == ReadingKind::Lit && row.quality == Quality::Ok && row.illuminance_lx.is_some()
}
