//! One range of the meter has another gain: a jump at the range change.

use isolux_record::observation::ReadingCoordinates;

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS, Role, Split, amplitude};

/// Range change f11.
pub(super) static RANGE_STEP: EffectSpec = EffectSpec {
    name: "range_step",
    standard_name: "range change f11",
    sentence: "One range of the meter does not agree with the others[: it shows {factor_rel:%} too {factor_rel:much|little}][, range {range}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "(1 + s)·E in one range",
    source: "ISO/CIE 19476, f11",
    parameters: &[
        amplitude("factor_rel", "1", (-0.01, 0.01), 0.001, READINGS),
        ParameterSpec { key: "range", unit: "", null: 0.0, plausible: (0.0, 10.0), step: 1.0, role: Role::RangeId, stages: READINGS, required: true },
    ],
    amplitude_power: 1,
    shows_in: "range",
    splits: &[Split { from: "nonlinearity", by: "second_distance" }],
    acts: &[Act::Response { apply, invert }],
};

fn gain(values: &[f64], at: &ReadingCoordinates) -> f64 {
    if at.range.map(f64::from) == Some(values[1]) { 1.0 + values[0] } else { 1.0 }
}

fn apply(values: &[f64], light_lx: f64, at: &ReadingCoordinates) -> f64 {
    light_lx * gain(values, at)
}

fn invert(values: &[f64], reading_lx: f64, at: &ReadingCoordinates) -> f64 {
    reading_lx / gain(values, at)
}
