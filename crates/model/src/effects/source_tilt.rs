//! The luminaire is tilted on the sensor bench: γ at azimuth φ is larger by τ.

use super::act::{Act, Placement, Values, lean};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "source_tilt",
    standard_name: "tilt of the source before the sensor",
    sentence: "The luminaire is askew before the sensor[, by {angle_deg:size}][ towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "direction turned by τ towards azimuth φ",
    source: "rotation matrix",
    parameters: &[amplitude("angle_deg", "°", (0.0, 3.0), 0.3), azimuth(360.0)],
    shows_in: "x_mm",
    look_alikes: &[("stage_lateral", "distances"), ("sensor_tilt", "rotate_180")],
    acts: &[Act::Placement(tilt)],
    ..EffectSpec::NEUTRAL
};

fn tilt(&[angle_deg, azimuth_deg, ..]: &Values, placement: &mut Placement) {
    placement.luminaire_from_room = lean(angle_deg, azimuth_deg) * placement.luminaire_from_room;
}
