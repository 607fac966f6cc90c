//! The lamp's axis is not perpendicular to the γ axis: γ = 0 is never reached. Second order in ε and even in γ, so that
//! an honest refit of the lamp's shape absorbs nearly all of it.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

/// Non-perpendicularity of the axes.
pub(super) static AXIS_NONPERP: EffectSpec = EffectSpec {
    name: "axis_nonperp",
    standard_name: "non-perpendicularity of the axes",
    sentence: "The axes are not perpendicular to each other[: {angle_deg:size} are missing], so that γ = 0° is never reached.",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "cos γ′ = cos γ · cos ε",
    source: "rotation matrix",
    parameters: &[
        amplitude("angle_deg", "°", (0.0, 0.3), 0.3, READINGS),
    ],
    amplitude_power: 2,
    shows_in: "gamma_deg",
    splits: &[],
    acts: &[Act::Axes(lean_out)],
};

fn lean_out(values: &[f64], _: &ReadingCoordinates, axes: &mut Axes) {
    axes.nonperp_deg += values[0];
}
