//! The optical axis leans away from azimuth C₀: γ there is larger by τ.

use super::act::{Act, Mounting, Values, lean};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "luminaire_tilt",
    standard_name: "mounting tilt (axis misalignment)",
    sentence: "The luminaire hangs askew[, by {angle_deg:size}][ away from C {azimuth_deg}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + τ cos(C − C₀) to first order; exactly a rotation by τ",
    source: "rotation matrix",
    parameters: &[amplitude("angle_deg", "°", (0.0, 1.0), 0.1), azimuth(360.0)],
    shows_in: "c_deg",
    look_alikes: &[
        ("lateral_centre", "second_distance"),
        ("dead_sector", "second_distance"),
    ],
    acts: &[Act::Mount(tilt)],
    ..EffectSpec::NEUTRAL
};

fn tilt(&[angle_deg, azimuth_deg, ..]: &Values, mounting: &mut Mounting) {
    let turn = lean(angle_deg, azimuth_deg);
    mounting.detector_mm = turn * mounting.detector_mm;
    mounting.facing = turn * mounting.facing;
}
