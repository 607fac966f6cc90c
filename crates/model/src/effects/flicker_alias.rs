//! Light modulated faster than it is sampled shows as a slow beat in time.

use std::f64::consts::TAU;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, Sampling, amplitude, period, phase};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "flicker_alias",
    standard_name: "modulated light f7, aliased",
    sentence: "The light is modulated faster than it is read, and shows as a slow beat[ of {amplitude_rel:%}][ every \
        {period_s}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + A sin(2πt/T + φ)",
    source: "ISO/CIE 19476, f7; sampling theorem",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.05), 0.005),
        period("period_s", "s", 60.0, (5.0, 3600.0), Sampling::Time),
        phase(),
    ],
    shows_in: "time_s",
    look_alikes: &[("lamp_drift", "reference_repeats")],
    acts: &[Act::Lamp(beat)],
    ..EffectSpec::NEUTRAL
};

fn beat(&[amplitude_rel, period_s, phase_rad, ..]: &Values, time_s: Option<f64>) -> f64 {
    time_s.map_or(1.0, |time_s| {
        1.0 + amplitude_rel * (TAU * time_s / period_s + phase_rad).sin()
    })
}
