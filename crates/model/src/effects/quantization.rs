//! The converter has steps.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

/// Quantization (ADC step).
pub(super) static QUANTIZATION: EffectSpec = EffectSpec {
    name: "quantization",
    standard_name: "quantization (ADC step)",
    sentence: "The converter has steps that show[: {step_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "rounded to a multiple of the step; step 0 means none",
    source: "EMVA 1288, quantization noise",
    parameters: &[
        amplitude("step_rel", "1", (0.0, 0.02), 0.005, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[],
    acts: &[Act::Readout(digits)],
};

fn digits(values: &[f64], signal: f64) -> f64 {
    if values[0] > 0.0 { (signal / values[0]).round() * values[0] } else { signal }
}
