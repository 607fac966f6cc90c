//! A block of measurements that is weighed, and those that are suggested.

use crate::assumed::Part;
use crate::document::NextEntry;

/// Seconds that a reading takes.
pub(super) const READING_S: f64 = 4.0;

/// Suggestions, best first, and the plan files that carry them out.
#[derive(Debug, Clone, Default)]
pub struct Next {
    /// Entries of `next_measurement`.
    pub entries: Vec<NextEntry>,
    /// File name and content of each plan.
    pub plans: Vec<(String, String)>,
    /// Said when there are alternatives and nothing would tell them apart.
    pub note: Option<String>,
}

/// A block that could be measured.
pub(super) struct Block {
    pub what: &'static str,
    pub part: Part,
    pub sigma: Vec<f64>,
    pub minutes: f64,
    pub plan: String,
}

/// The finite value in the middle, of an even number the upper of two: a plan takes angles and distances that were
/// measured at, which their mean need not be.
pub(super) fn middle_one(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// What an axis was sent to, of what it read back: a plan in which the angles of the encoder stood would have no even
/// step, or would begin behind a limit by a count.
pub(super) fn nominal(angle_deg: f64) -> f64 {
    // No minus before a zero.
    (angle_deg * 20.0).round() / 20.0 + 0.0
}
