//! The γ scale has its zero elsewhere: odd in signed γ.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "gamma_zero",
    standard_name: "γ zero error (alignment)",
    sentence: "The γ scale has its zero [{offset_deg:size} ]beside the optical axis.",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "γ + δ",
    source: "EN 13032-1, alignment of the goniometer axes",
    parameters: &[amplitude("offset_deg", "°", (-0.5, 0.5), 0.1)],
    shows_in: "gamma_deg",
    look_alikes: &[("backlash", "reverse_travel"), ("gamma_sag", "rotate_c_180")],
    acts: &[Act::Axes(turn)],
    ..EffectSpec::NEUTRAL
};

fn turn(&[offset_deg, ..]: &Values, _: &ReadingCoordinates, axes: &mut Axes) {
    axes.gamma_deg += offset_deg;
}
