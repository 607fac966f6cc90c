//! The luminaire hangs askew: its optical axis leans away from azimuth C₀, so that γ there is larger by τ.

use super::act::{Act, Mounting, lean};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude, azimuth};

/// Mounting tilt (axis misalignment).
pub(super) static LUMINAIRE_TILT: EffectSpec = EffectSpec {
    name: "luminaire_tilt",
    standard_name: "mounting tilt (axis misalignment)",
    sentence: "The luminaire hangs askew[, by {angle_deg:size}][ away from C {azimuth_deg}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + τ cos(C − C₀) to first order; exactly a rotation by τ",
    source: "rotation matrix",
    parameters: &[
        amplitude("angle_deg", "°", (0.0, 1.0), 0.1, READINGS),
        azimuth(360.0, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[Split { from: "lateral_centre", by: "second_distance" }, Split { from: "dead_sector", by: "second_distance" }],
    acts: &[Act::Mount(tilt)],
};

fn tilt(values: &[f64], mounting: &mut Mounting) {
    let turn = lean(values[0], values[1]);
    mounting.detector_mm = turn * mounting.detector_mm;
    mounting.facing = turn * mounting.facing;
}
