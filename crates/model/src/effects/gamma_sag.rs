//! The arm bends under its weight, most where it is horizontal.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Gravity sag of the arm.
pub(super) static GAMMA_SAG: EffectSpec = EffectSpec {
    name: "gamma_sag",
    standard_name: "gravity sag of the arm",
    sentence: "The arm bends under its weight[, by {amplitude_deg:size} where it is horizontal].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + s·cos γ",
    source: "bending of a cantilever under its weight, to first order",
    parameters: &[
        amplitude("amplitude_deg", "°", (-0.3, 0.3), 0.1, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "gamma_deg",
    splits: &[Split { from: "gamma_zero", by: "rotate_c_180" }],
    acts: &[Act::Axes(sag)],
};

fn sag(values: &[f64], _: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += values[0] * axes.gamma_deg.to_radians().cos();
}
