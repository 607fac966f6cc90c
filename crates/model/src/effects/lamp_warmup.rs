//! The lamp is brighter while it is cold and settles. Where the time is not known, warm-up is complete.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "lamp_warmup",
    standard_name: "stabilisation (thermal droop)",
    sentence: "The lamp was read before it was warm[: {amplitude_rel:%} too bright at first][, gone to a third after \
        {time_constant_s:min}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + A e^(−t/τ)",
    source: "first-order thermal relaxation; EN 13032-1 and LM-79, stabilisation",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.1), 0.01),
        shape(
            "time_constant_s",
            "s",
            600.0,
            (60.0, 1800.0),
            &[60.0, 120.0, 240.0, 420.0, 700.0, 1100.0, 1800.0],
        )
        .above_zero(),
    ],
    shows_in: "time_s",
    look_alikes: &[
        ("lamp_drift", "reference_repeats"),
        ("temp_coefficient", "reference_repeats"),
    ],
    acts: &[Act::Lamp(droop)],
    ..EffectSpec::NEUTRAL
};

fn droop(&[amplitude_rel, time_constant_s, ..]: &Values, time_s: Option<f64>) -> f64 {
    time_s.map_or(1.0, |time_s| 1.0 + amplitude_rel * (-time_s / time_constant_s).exp())
}
