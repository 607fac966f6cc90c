//! The luminaire is askew on the sensor bench: γ at azimuth φ is larger by τ.

use super::act::{Act, Placement, lean};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude, azimuth};

/// Tilt of the source before the sensor.
pub(super) static SOURCE_TILT: EffectSpec = EffectSpec {
    name: "source_tilt",
    standard_name: "tilt of the source before the sensor",
    sentence: "The luminaire is askew before the sensor[, by {angle_deg:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "direction turned by τ towards azimuth φ",
    source: "rotation matrix",
    parameters: &[
        amplitude("angle_deg", "°", (0.0, 3.0), 0.3, MAPS),
        azimuth(360.0, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "x_mm",
    splits: &[Split { from: "stage_lateral", by: "distances" }, Split { from: "sensor_tilt", by: "rotate_180" }],
    acts: &[Act::Placement(tilt)],
};

fn tilt(values: &[f64], placement: &mut Placement) {
    placement.luminaire_from_room = lean(values[0], values[1]) * placement.luminaire_from_room;
}
