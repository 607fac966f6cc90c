//! The meter's gain follows the temperature. Where the temperature was not recorded nothing is applied.

use isolux_record::observation::ReadingCoordinates;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, constant};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "temp_coefficient",
    standard_name: "temperature dependence f6,T",
    sentence: "The meter's gain follows its temperature[: {coefficient_per_k:%} {coefficient_per_k:more|less} for each \
        kelvin].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + α(T − T₀)",
    source: "ISO/CIE 19476, f6,T",
    parameters: &[
        amplitude("coefficient_per_k", "1/K", (-0.01, 0.01), 0.001),
        constant("reference_c", "°C", 25.0, (15.0, 35.0)),
    ],
    shows_in: "ambient_c",
    look_alikes: &[
        ("lamp_drift", "reference_repeats"),
        ("polarization", "reference_repeats"),
    ],
    acts: &[Act::Response { apply, invert }],
    ..EffectSpec::NEUTRAL
};

fn gain(&[coefficient_per_k, reference_c, ..]: &Values, at: &ReadingCoordinates) -> f64 {
    at.ambient_c
        .map_or(1.0, |ambient_c| 1.0 + coefficient_per_k * (ambient_c - reference_c))
}

fn apply(values: &Values, light_lx: f64, at: &ReadingCoordinates) -> f64 {
    light_lx * gain(values, at)
}

fn invert(values: &Values, reading_lx: f64, at: &ReadingCoordinates) -> f64 {
    reading_lx / gain(values, at)
}
