//! The chip is askew in its camera: the tilt turns with the sensor. The side of
//! the sensor at azimuth φ is lifted towards the lamp.

use super::act::{Act, Placement};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude, azimuth};

/// Tilt of the sensor in its mount.
pub(super) static SENSOR_TILT: EffectSpec = EffectSpec {
    name: "sensor_tilt",
    standard_name: "tilt of the sensor in its mount",
    sentence: "The chip sits askew in its camera[, by {angle_deg:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "R · R_tilt, which lifts the side at azimuth φ of the sensor towards the lamp",
    source: "rotation matrix",
    parameters: &[
        amplitude("angle_deg", "°", (0.0, 2.0), 0.3, MAPS),
        azimuth(360.0, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "x_mm",
    splits: &[Split { from: "stage_lateral", by: "distances" }, Split { from: "source_tilt", by: "rotate_180" }, Split { from: "prnu_gradient", by: "tilts" }],
    acts: &[Act::Placement(tilt)],
};

fn tilt(values: &[f64], placement: &mut Placement) {
    placement.pose.mount_tilt_deg = [values[0], values[1]];
}
