//! Room light that reaches the detector whether the lamp burns or not. A capped detector does not see it, unlike a
//! zero offset.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "ambient_stray",
    standard_name: "stray light, constant",
    sentence: "Light from the room reaches the detector whether the lamp burns or not[: {illuminance_lx}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "E + E_a on lit, baffled and lamp-off readings",
    source: "EN 13032-1, stray light; ISO/CIE 19476",
    parameters: &[amplitude("illuminance_lx", "lx", (0.0, 1.0), 0.01)],
    shows_in: "level",
    look_alikes: &[("dark_offset", "dark"), ("floor_reflection", "second_distance")],
    acts: &[Act::Ambient(light)],
    ..EffectSpec::NEUTRAL
};

fn light(&[illuminance_lx, ..]: &Values) -> f64 {
    illuminance_lx
}
