//! The lamp's axis is not perpendicular to the γ axis: γ = 0 is never reached. Even in γ: a refit of the lamp's shape
//! absorbs nearly all of it.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "axis_nonperp",
    standard_name: "non-perpendicularity of the axes",
    sentence: "The axes are not perpendicular to each other[: {angle_deg:size} are missing], so that γ = 0° is never \
        reached.",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "cos γ′ = cos γ · cos ε",
    source: "rotation matrix",
    parameters: &[amplitude("angle_deg", "°", (0.0, 0.3), 0.3)],
    amplitude_power: 2,
    shows_in: "gamma_deg",
    acts: &[Act::Axes(lean_out)],
    ..EffectSpec::NEUTRAL
};

fn lean_out(&[angle_deg, ..]: &Values, _: &ReadingCoordinates, axes: &mut Axes) {
    axes.nonperp_deg += angle_deg;
}
