//! Light modulated faster than it is sampled shows as a slow beat in time.

use std::f64::consts::TAU;

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS_AND_MAPS, Role, Split, amplitude};

/// Modulated light f7, aliased.
pub(super) static FLICKER_ALIAS: EffectSpec = EffectSpec {
    name: "flicker_alias",
    standard_name: "modulated light f7, aliased",
    sentence: "The light is modulated faster than it is read, and shows as a slow beat[ of {amplitude_rel:%}][ every {period_s}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + A sin(2πt/T + φ)",
    source: "ISO/CIE 19476, f7; sampling theorem",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.05), 0.005, READINGS_AND_MAPS),
        ParameterSpec { key: "period_s", unit: "s", null: 60.0, plausible: (5.0, 3600.0), step: 1.0, role: Role::Period, stages: READINGS_AND_MAPS, required: true },
        ParameterSpec { key: "phase_rad", role: Role::Phase { period: TAU }, unit: "rad", null: 0.0, plausible: (0.0, TAU), step: 0.1, stages: READINGS_AND_MAPS, required: false },
    ],
    amplitude_power: 1,
    shows_in: "time_s",
    splits: &[Split { from: "lamp_drift", by: "reference_repeats" }],
    acts: &[Act::Lamp(beat)],
};

fn beat(values: &[f64], time_s: Option<f64>) -> f64 {
    time_s.map_or(1.0, |time_s| 1.0 + values[0] * (TAU * time_s / values[1] + values[2]).sin())
}
