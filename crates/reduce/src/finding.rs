//! What of a record does not agree, and the rows that show it.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a budget lacks where a disagreement was accepted.
pub const ACCEPTED: &str = "a drift beyond the limits was accepted";

/// Rows that a sentence names at most.
const MOST_ROWS: usize = 6;

/// What does not agree, and the rows that show it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// What is wrong and which limit it breaks, one sentence.
    pub what: String,
    /// The rows that show it.
    pub rows: Vec<Evidence>,
}

/// A row that shows a disagreement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evidence {
    /// Its number.
    pub row: u64,
    /// Seconds since the lamp was switched on.
    pub time_s: Option<f64>,
    /// C of the plan.
    pub c_deg: f64,
    /// γ of the plan.
    pub gamma_deg: f64,
    /// What was read.
    pub illuminance_lx: Option<f64>,
}

/// A disagreement that a person has accepted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Accepted {
    /// Why, in their words; empty where they gave none.
    pub reason: String,
    /// What was accepted.
    pub findings: Vec<Finding>,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.what)?;
        for (place, row) in self.rows.iter().take(MOST_ROWS).enumerate() {
            let comma = if place == 0 { "" } else { ";" };
            write!(f, "{comma} row {} at", row.row)?;
            if let Some(time_s) = row.time_s {
                write!(f, " {time_s:.0} s,")?;
            }
            write!(f, " C {}° γ {}°", row.c_deg, row.gamma_deg)?;
            if let Some(lux) = row.illuminance_lx {
                write!(f, ", {lux} lx")?;
            }
        }
        match self.rows.len().saturating_sub(MOST_ROWS) {
            0 => Ok(()),
            more => write!(f, "; and {more} more"),
        }
    }
}

/// An accepted disagreement, for a note.
pub fn note(accepted: &Accepted) -> String {
    let reason = match accepted.reason.trim() {
        "" => String::new(),
        reason => format!(" ({reason})"),
    };
    format!("{ACCEPTED}{reason}: {}", sentences(&accepted.findings))
}

/// The findings one after the other, for a message.
pub fn sentences(findings: &[Finding]) -> String {
    let words: Vec<String> = findings.iter().map(Finding::to_string).collect();
    words.join(". ")
}
