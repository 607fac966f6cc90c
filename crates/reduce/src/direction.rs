//! Directions of a plan: which were asked for, and which were read.

use isolux_record::Reading;

/// A direction (C, γ) as the plan has it, in degrees.
pub type Direction = (f64, f64);

/// The direction of the plan at which a reading was taken.
pub fn target(row: &Reading) -> Direction {
    (row.c_target_deg, row.gamma_target_deg)
}

/// The order of [`once`].
pub fn order(a: &Direction, b: &Direction) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// Sorted, each once.
pub fn once(directions: impl Iterator<Item = Direction>) -> Vec<Direction> {
    // Adding 0 makes −0 and 0 one.
    let mut directions: Vec<Direction> = directions.map(|(c, gamma)| (c + 0.0, gamma + 0.0)).collect();
    directions.sort_by(order);
    directions.dedup();
    directions
}
