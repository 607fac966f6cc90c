//! The meter's gain follows the temperature. Where the temperature was not recorded nothing is applied.

use isolux_record::observation::ReadingCoordinates;

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS, Role, Split, amplitude};

/// Temperature dependence f6,T.
pub(super) static TEMP_COEFFICIENT: EffectSpec = EffectSpec {
    name: "temp_coefficient",
    standard_name: "temperature dependence f6,T",
    sentence: "The meter's gain follows its temperature[: {coefficient_per_k:%} {coefficient_per_k:more|less} for each kelvin].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + α(T − T₀)",
    source: "ISO/CIE 19476, f6,T",
    parameters: &[
        amplitude("coefficient_per_k", "1/K", (-0.01, 0.01), 0.001, READINGS),
        ParameterSpec { key: "reference_c", unit: "°C", null: 25.0, plausible: (15.0, 35.0), step: 1.0, role: Role::Constant, stages: READINGS, required: false },
    ],
    amplitude_power: 1,
    shows_in: "ambient_c",
    splits: &[Split { from: "lamp_drift", by: "reference_repeats" }, Split { from: "polarization", by: "reference_repeats" }],
    acts: &[Act::Response { apply, invert }],
};

fn gain(values: &[f64], at: &ReadingCoordinates) -> f64 {
    at.ambient_c.map_or(1.0, |ambient_c| 1.0 + values[0] * (ambient_c - values[1]))
}

fn apply(values: &[f64], light_lx: f64, at: &ReadingCoordinates) -> f64 {
    light_lx * gain(values, at)
}

fn invert(values: &[f64], reading_lx: f64, at: &ReadingCoordinates) -> f64 {
    reading_lx / gain(values, at)
}
