//! All light differs by one factor: the lamp gives more or less than when the model was made (current, temperature,
//! age), or the meters of the two days were calibrated differently.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EVERYTHING, EffectSpec, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "light_level",
    standard_name: "luminous flux of the lamp or calibration of the meter",
    sentence: "All light differs from the model by one factor, of the lamp or of a meter's calibration[: it is \
        {factor_rel:%} {factor_rel:brighter|dimmer}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: EVERYTHING,
    formula: "(1 + f)·E",
    source: "ISO/CIE 19476, calibration; LM-79, stability of the lamp",
    parameters: &[amplitude("factor_rel", "1", (-0.1, 0.1), 0.005)],
    shows_in: "level",
    look_alikes: &[
        ("distance_offset", "second_distance"),
        ("air_absorption", "second_distance"),
        ("exposure_offset", "exposures"),
        ("ler_scale", "distances"),
    ],
    acts: &[Act::Lamp(scale)],
    ..EffectSpec::NEUTRAL
};

fn scale(&[factor_rel, ..]: &Values, _: Option<f64>) -> f64 {
    1.0 + factor_rel
}
