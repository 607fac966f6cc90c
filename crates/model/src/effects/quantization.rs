//! The converter has steps.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "quantization",
    standard_name: "quantization (ADC step)",
    sentence: "The converter has steps that show[: {step_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "rounded to a multiple of the step; step 0 means none",
    source: "EMVA 1288, quantization noise",
    parameters: &[amplitude("step_rel", "1", (0.0, 0.02), 0.005)],
    period_of_signal: true,
    shows_in: "level",
    acts: &[Act::Readout(digits)],
    ..EffectSpec::NEUTRAL
};

fn digits(&[step_rel, ..]: &Values, signal: f64) -> f64 {
    if step_rel > 0.0 {
        (signal / step_rel).round() * step_rel
    } else {
        signal
    }
}
