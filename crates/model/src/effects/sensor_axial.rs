//! The sensor is farther than the stage says.

use super::act::{Act, Placement};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude};

/// Sensor misplaced along the axis.
pub(super) static SENSOR_AXIAL: EffectSpec = EffectSpec {
    name: "sensor_axial",
    standard_name: "sensor misplaced along the axis",
    sentence: "The sensor is not where its stage says[: it is {offset_mm:size} {offset_mm:farther away|nearer}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "d + δ",
    source: "vector algebra",
    parameters: &[
        amplitude("offset_mm", "mm", (-3.0, 3.0), 0.5, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "distance_mm",
    splits: &[Split { from: "near_field", by: "distances" }, Split { from: "exposure_offset", by: "exposures" }],
    acts: &[Act::Placement(shift)],
};

fn shift(values: &[f64], placement: &mut Placement) {
    placement.pose.distance_mm += values[0];
}
