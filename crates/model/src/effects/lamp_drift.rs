//! The lamp or its supply drifts evenly. Where the time is not known it stands at the reference time.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS_AND_MAPS, Role, Split, amplitude};

/// Depreciation (supply drift).
pub(super) static LAMP_DRIFT: EffectSpec = EffectSpec {
    name: "lamp_drift",
    standard_name: "depreciation (supply drift)",
    sentence: "The lamp or its supply changed evenly while it was read[: {rate_per_h:%} {rate_per_h:brighter|dimmer} with every hour].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + r·(t − t₀)",
    source: "linear drift; LM-79, stability",
    parameters: &[
        amplitude("rate_per_h", "1/h", (-0.02, 0.02), 0.002, READINGS_AND_MAPS),
        ParameterSpec { key: "reference_s", unit: "s", null: 0.0, plausible: (0.0, 360_000.0), step: 60.0, role: Role::Constant, stages: READINGS_AND_MAPS, required: false },
    ],
    amplitude_power: 1,
    shows_in: "time_s",
    splits: &[Split { from: "lamp_warmup", by: "reference_repeats" }, Split { from: "temp_coefficient", by: "reference_repeats" }],
    acts: &[Act::Lamp(drift)],
};

fn drift(values: &[f64], time_s: Option<f64>) -> f64 {
    time_s.map_or(1.0, |time_s| 1.0 + values[0] * (time_s - values[1]) / 3600.0)
}
