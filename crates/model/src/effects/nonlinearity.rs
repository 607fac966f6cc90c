//! The reading grows otherwise than the light. k > 0 saturates.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, Stage, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "nonlinearity",
    standard_name: "linearity error f3",
    sentence: "The reading does not grow in proportion to the light[: {inverse_scale_per_lx:%} {inverse_scale_per_lx:too \
        little|too much} for each lx][: {inverse_scale:%} {inverse_scale:too little|too much} at full scale].",
    belongs_to: &[BelongsTo::Bench, BelongsTo::Sensor],
    stages: READINGS_AND_MAPS,
    formula: "E/(1 + kE)",
    source: "ISO/CIE 19476, f3; EMVA 1288, linearity",
    parameters: &[
        amplitude("inverse_scale_per_lx", "1/lx", (-1e-3, 1e-3), 1e-5).only_on(Stage::Readings),
        amplitude("inverse_scale", "1", (-0.05, 0.05), 0.005).only_on(Stage::Maps),
    ],
    shows_in: "level",
    look_alikes: &[("exposure_offset", "exposures"), ("ambient_stray", "second_distance")],
    acts: &[Act::Response { apply, invert }, Act::Signal(signal)],
    ..EffectSpec::NEUTRAL
};

fn apply(&[inverse_scale_per_lx, ..]: &Values, light_lx: f64, _: &ReadingCoordinates) -> f64 {
    light_lx / (1.0 + inverse_scale_per_lx * light_lx)
}

fn invert(&[inverse_scale_per_lx, ..]: &Values, reading_lx: f64, _: &ReadingCoordinates) -> f64 {
    reading_lx / (1.0 - inverse_scale_per_lx * reading_lx)
}

fn signal(&[_, inverse_scale, ..]: &Values, signal: f64) -> f64 {
    signal / (1.0 + inverse_scale * signal)
}
