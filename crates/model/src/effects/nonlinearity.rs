//! The reading grows otherwise than the light. k > 0 saturates.

use isolux_record::observation::ReadingCoordinates;

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, READINGS, READINGS_AND_MAPS, Split, amplitude};

/// Linearity error f3.
pub(super) static NONLINEARITY: EffectSpec = EffectSpec {
    name: "nonlinearity",
    standard_name: "linearity error f3",
    sentence: "The reading does not grow in proportion to the light[: {inverse_scale_per_lx:%} {inverse_scale_per_lx:too little|too much} for each lx][: {inverse_scale:%} {inverse_scale:too little|too much} at full scale].",
    belongs_to: &[BelongsTo::Bench, BelongsTo::Sensor],
    stages: READINGS_AND_MAPS,
    formula: "E/(1 + kE)",
    source: "ISO/CIE 19476, f3; EMVA 1288, linearity",
    parameters: &[
        amplitude("inverse_scale_per_lx", "1/lx", (-1e-3, 1e-3), 1e-5, READINGS),
        amplitude("inverse_scale", "1", (-0.05, 0.05), 0.005, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "exposure_offset", by: "exposures" }, Split { from: "ambient_stray", by: "second_distance" }],
    acts: &[Act::Response { apply, invert }, Act::Signal(signal)],
};

fn apply(values: &[f64], light_lx: f64, _: &ReadingCoordinates) -> f64 {
    light_lx / (1.0 + values[0] * light_lx)
}

fn invert(values: &[f64], reading_lx: f64, _: &ReadingCoordinates) -> f64 {
    reading_lx / (1.0 - values[0] * reading_lx)
}

fn signal(values: &[f64], signal: f64) -> f64 {
    signal / (1.0 + values[1] * signal)
}
