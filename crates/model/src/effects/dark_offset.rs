//! What the instrument shows without light; on maps a share of full scale. Added last; the only thing that a capped
//! record shows.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, Stage, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "dark_offset",
    standard_name: "zero offset (dark signal)",
    sentence: "The instrument shows something when no light reaches it[: {offset_lx}][: {offset_rel:%} of full scale].",
    belongs_to: &[BelongsTo::Bench, BelongsTo::Sensor],
    stages: READINGS_AND_MAPS,
    formula: "E + E_d on every reading; signal + offset_rel of full scale on every map",
    source: "ISO/CIE 19476 (zero); EMVA 1288 (dark signal)",
    parameters: &[
        amplitude("offset_lx", "lx", (-1.5, 1.5), 0.01).only_on(Stage::Readings),
        amplitude("offset_rel", "1", (-0.01, 0.01), 0.001).only_on(Stage::Maps),
    ],
    shows_in: "level",
    look_alikes: &[("ambient_stray", "dark"), ("ambient_light", "dark_maps")],
    acts: &[Act::Zero(zero), Act::SignalZero(signal)],
    ..EffectSpec::NEUTRAL
};

fn zero(&[offset_lx, ..]: &Values) -> f64 {
    offset_lx
}

fn signal(&[_, offset_rel, ..]: &Values) -> f64 {
    offset_rel
}
