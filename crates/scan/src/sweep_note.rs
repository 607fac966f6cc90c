//! What a plan says of a block that is read in motion: its sweeps, and how long they take.

use isolux_record::Station;
use isolux_record::plan::{Block, Pass, RINGS};

use crate::second;
use crate::sweeps::{AT_REST, pass_s};

/// A sentence on a block of sweeps beside what its directions would take at rest, each `at_rest_s`.
pub(crate) fn note(station: &Station, block: &Block, at_rest_s: f64) -> Option<String> {
    let passes = block.passes();
    let moving_s = |passes: &[Pass]| passes.iter().map(|pass| pass_s(station, pass)).sum::<f64>();
    let directions = block.c_deg.len() * block.gamma_deg.len();
    let at_rest_s = directions as f64 * at_rest_s;
    if passes.is_empty() {
        return None;
    }
    let second = second::words(station, block);
    if block.target.is_some() {
        // The first half-plane, the one across and the rings are swept whatever the light is.
        let least = passes.len() - (block.c_deg.len() - 1) + 1;
        return Some(format!(
            "block `{}`: {least} to {} sweeps, {:.0} to {:.0} s of motion: {RINGS} rings and the half-planes that \
             they show to be needed, {second}and {AT_REST} directions at rest; all {directions} directions at rest \
             take {at_rest_s:.0} s or more",
            block.name,
            passes.len(),
            moving_s(&passes[..least]),
            moving_s(&passes),
        ));
    }
    Some(format!(
        "block `{}`: {} sweeps, {:.0} s of motion, {second}and {AT_REST} directions at rest; \
         the same {directions} directions at rest take {at_rest_s:.0} s or more",
        block.name,
        passes.len(),
        moving_s(&passes),
    ))
}
