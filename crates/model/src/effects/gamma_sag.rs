//! The arm bends under its weight, most where it is horizontal.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "gamma_sag",
    standard_name: "gravity sag of the arm",
    sentence: "The arm bends under its weight[, by {amplitude_deg:size} where it is horizontal].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + s·cos γ",
    source: "bending of a cantilever under its weight, to first order",
    parameters: &[amplitude("amplitude_deg", "°", (-0.3, 0.3), 0.1)],
    shows_in: "gamma_deg",
    look_alikes: &[("gamma_zero", "rotate_c_180")],
    acts: &[Act::Axes(sag)],
    ..EffectSpec::NEUTRAL
};

fn sag(&[amplitude_deg, ..]: &Values, _: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += amplitude_deg * axes.gamma_deg.to_radians().cos();
}
