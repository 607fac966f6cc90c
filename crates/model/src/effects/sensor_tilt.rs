//! The chip is tilted in its camera: the tilt turns with the sensor.

use super::act::{Act, Placement, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "sensor_tilt",
    standard_name: "tilt of the sensor in its mount",
    sentence: "The chip sits askew in its camera[, by {angle_deg:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "R · R_tilt, which lifts the side at azimuth φ of the sensor towards the lamp",
    source: "rotation matrix",
    parameters: &[amplitude("angle_deg", "°", (0.0, 2.0), 0.3), azimuth(360.0)],
    shows_in: "x_mm",
    look_alikes: &[
        ("stage_lateral", "distances"),
        ("source_tilt", "rotate_180"),
        ("prnu_gradient", "tilts"),
    ],
    acts: &[Act::Placement(tilt)],
    ..EffectSpec::NEUTRAL
};

fn tilt(&[angle_deg, azimuth_deg, ..]: &Values, placement: &mut Placement) {
    placement.pose.mount_tilt_deg = [angle_deg, azimuth_deg];
}
