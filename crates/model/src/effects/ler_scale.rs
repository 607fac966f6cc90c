//! The spectrum gives another efficacy than the light has: W/m² are off by one factor, lx are not.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, ParameterSpec, Split, amplitude};

/// Luminous efficacy of radiation (wrong spectrum).
pub(super) static LER_SCALE: EffectSpec = EffectSpec {
    name: "ler_scale",
    standard_name: "luminous efficacy of radiation (wrong spectrum)",
    sentence: "The spectrum is not that of the light[: its efficacy is {factor:off1%} too {factor:high|low}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: MAPS,
    formula: "K · factor",
    source: "K = K_m ∫SV dλ / ∫S dλ",
    parameters: &[
        ParameterSpec { null: 1.0, ..amplitude("factor", "1", (0.97, 1.03), 0.005, MAPS) },
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "sensor_axial", by: "distances" }],
    acts: &[Act::Efficacy(scale)],
};

fn scale(values: &[f64]) -> f64 {
    values[0]
}
