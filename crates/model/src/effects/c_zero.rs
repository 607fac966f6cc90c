//! The C scale has its zero elsewhere. Only an asymmetric lamp shows it.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Axes, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "c_zero",
    standard_name: "C zero error",
    sentence: "The C scale has its zero [{offset_deg:size} ]beside the luminaire's own C0.",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "C + δ",
    source: "EN 13032-1, alignment of the goniometer axes",
    parameters: &[amplitude("offset_deg", "°", (-5.0, 5.0), 0.5)],
    shows_in: "c_deg",
    acts: &[Act::Axes(turn)],
    ..EffectSpec::NEUTRAL
};

fn turn(&[offset_deg, ..]: &Values, _: &ReadingCoordinates, axes: &mut Axes) {
    axes.c_deg += offset_deg;
}
