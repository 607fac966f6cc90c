//! The stage puts the sensor beside where it says, in the room: turning the sensor does not turn it.

use glam::DVec2;

use super::act::{Act, Placement, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "stage_lateral",
    standard_name: "sensor misplaced sideways",
    sentence: "The stage puts the sensor beside where it says[, by {offset_mm:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "centre + r·(cos φ, sin φ, 0) in the luminaire frame",
    source: "vector algebra",
    parameters: &[amplitude("offset_mm", "mm", (0.0, 5.0), 0.5), azimuth(360.0)],
    shows_in: "x_mm",
    look_alikes: &[
        ("sensor_tilt", "distances"),
        ("source_tilt", "distances"),
        ("prnu_gradient", "rotate_180"),
    ],
    acts: &[Act::Placement(shift)],
    ..EffectSpec::NEUTRAL
};

fn shift(&[offset_mm, azimuth_deg, ..]: &Values, placement: &mut Placement) {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    placement.pose.offset_mm += DVec2::new(offset_mm * cos, offset_mm * sin);
}
