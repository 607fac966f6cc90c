//! The stage puts the sensor beside where it says, in the room: turning the sensor does not turn it.

use glam::DVec2;

use super::act::{Act, Placement};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude, azimuth};

/// Sensor misplaced sideways.
pub(super) static STAGE_LATERAL: EffectSpec = EffectSpec {
    name: "stage_lateral",
    standard_name: "sensor misplaced sideways",
    sentence: "The stage puts the sensor beside where it says[, by {offset_mm:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "centre + r·(cos φ, sin φ, 0) in the luminaire frame",
    source: "vector algebra",
    parameters: &[
        amplitude("offset_mm", "mm", (0.0, 5.0), 0.5, MAPS),
        azimuth(360.0, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "x_mm",
    splits: &[Split { from: "sensor_tilt", by: "distances" }, Split { from: "source_tilt", by: "distances" }, Split { from: "prnu_gradient", by: "rotate_180" }],
    acts: &[Act::Placement(shift)],
};

fn shift(values: &[f64], placement: &mut Placement) {
    let (sin, cos) = values[1].to_radians().sin_cos();
    placement.pose.offset_mm += DVec2::new(values[0] * cos, values[0] * sin);
}
