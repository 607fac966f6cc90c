//! The sensor is farther than the stage says.

use super::act::{Act, Placement, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "sensor_axial",
    standard_name: "sensor misplaced along the axis",
    sentence: "The sensor is not where its stage says[: it is {offset_mm:size} {offset_mm:farther away|nearer}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "d + δ",
    source: "vector algebra",
    parameters: &[amplitude("offset_mm", "mm", (-3.0, 3.0), 0.5)],
    shows_in: "distance_mm",
    look_alikes: &[("near_field", "distances"), ("exposure_offset", "exposures")],
    acts: &[Act::Placement(shift)],
    ..EffectSpec::NEUTRAL
};

fn shift(&[offset_mm, ..]: &Values, placement: &mut Placement) {
    placement.pose.distance_mm += offset_mm;
}
