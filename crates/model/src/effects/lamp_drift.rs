//! The lamp or its supply drifts evenly. Where the time is not known it stands at the reference time. A lamp that
//! drifts otherwise than it did is as bright as the file says at some time since it was switched on, not at the file's.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, origin};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "lamp_drift",
    standard_name: "depreciation (supply drift)",
    sentence: "The lamp or its supply changed evenly while it was read[: {rate_per_h:%} {rate_per_h:brighter|dimmer} with \
        every hour].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + r·(t − t₀)",
    source: "linear drift; LM-79, stability",
    parameters: &[
        amplitude("rate_per_h", "1/h", (-0.02, 0.02), 0.002),
        origin("reference_s", "s", (0.0, 360_000.0), (0.0, 7200.0)),
    ],
    shows_in: "time_s",
    look_alikes: &[
        ("lamp_warmup", "reference_repeats"),
        ("temp_coefficient", "reference_repeats"),
    ],
    acts: &[Act::Lamp(drift)],
    ..EffectSpec::NEUTRAL
};

fn drift(&[rate_per_h, reference_s, ..]: &Values, time_s: Option<f64>) -> f64 {
    time_s.map_or(1.0, |time_s| 1.0 + rate_per_h * (time_s - reference_s) / 3600.0)
}
