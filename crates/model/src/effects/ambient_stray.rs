//! Constant stray light: room light that reaches the detector whether the lamp burns or not.
//! 
//! A capped detector does not see it; that is what tells it from a zero offset.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Stray light, constant.
pub(super) static AMBIENT_STRAY: EffectSpec = EffectSpec {
    name: "ambient_stray",
    standard_name: "stray light, constant",
    sentence: "Light from the room reaches the detector whether the lamp burns or not[: {illuminance_lx}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "E + E_a on lit, baffled and lamp-off readings",
    source: "EN 13032-1, stray light; ISO/CIE 19476",
    parameters: &[
        amplitude("illuminance_lx", "lx", (0.0, 1.0), 0.01, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "dark_offset", by: "dark" }, Split { from: "floor_reflection", by: "second_distance" }],
    acts: &[Act::Ambient(light)],
};

fn light(values: &[f64]) -> f64 {
    values[0]
}
