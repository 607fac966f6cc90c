//! One range of the meter has another gain: a jump at the range change.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, range};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "range_step",
    standard_name: "range change f11",
    sentence: "One range of the meter does not agree with the others[: it shows {factor_rel:%} too \
        {factor_rel:much|little}][, range {range}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "(1 + s)·E in one range",
    source: "ISO/CIE 19476, f11",
    parameters: &[amplitude("factor_rel", "1", (-0.01, 0.01), 0.001), range()],
    shows_in: "range",
    look_alikes: &[("nonlinearity", "second_distance")],
    acts: &[Act::Response { apply, invert }],
    ..EffectSpec::NEUTRAL
};

fn gain(&[factor_rel, range, ..]: &Values, at: &ReadingCoordinates) -> f64 {
    if at.range.map(f64::from) == Some(range) {
        1.0 + factor_rel
    } else {
        1.0
    }
}

fn apply(values: &Values, light_lx: f64, at: &ReadingCoordinates) -> f64 {
    light_lx * gain(values, at)
}

fn invert(values: &Values, reading_lx: f64, at: &ReadingCoordinates) -> f64 {
    reading_lx / gain(values, at)
}
