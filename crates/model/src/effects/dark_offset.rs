//! What the instrument shows when no light reaches it.
//! 
//! On readings in lx, on maps as a share of the sensor's full scale. It is added last, after every response, and is the
//! only thing that a capped record shows.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, MAPS, READINGS, READINGS_AND_MAPS, Split, amplitude};

/// Zero offset (dark signal).
pub(super) static DARK_OFFSET: EffectSpec = EffectSpec {
    name: "dark_offset",
    standard_name: "zero offset (dark signal)",
    sentence: "The instrument shows something when no light reaches it[: {offset_lx}][: {offset_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Bench, BelongsTo::Sensor],
    stages: READINGS_AND_MAPS,
    formula: "E + E_d on every reading; signal + offset_rel of full scale on every map",
    source: "ISO/CIE 19476 (zero); EMVA 1288 (dark signal)",
    parameters: &[
        amplitude("offset_lx", "lx", (-1.5, 1.5), 0.01, READINGS),
        amplitude("offset_rel", "1", (-0.01, 0.01), 0.001, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "level",
    splits: &[Split { from: "ambient_stray", by: "dark" }, Split { from: "ambient_light", by: "dark_maps" }],
    acts: &[Act::Zero(zero), Act::SignalZero(signal)],
};

fn zero(values: &[f64]) -> f64 {
    values[0]
}

fn signal(values: &[f64]) -> f64 {
    values[1]
}
