//! Light and charge spread to neighbours. Blind on smooth maps.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "crosstalk",
    standard_name: "crosstalk (point spread)",
    sentence: "Light or charge of a pixel spreads to its neighbours[, over {width_px}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "signal ⊗ Gaussian of standard deviation w",
    source: "EMVA 1288; point spread function",
    parameters: &[amplitude("width_px", "px", (0.0, 3.0), 1.0)],
    amplitude_power: 2,
    shows_in: "x_mm",
    acts: &[Act::Blur(width)],
    ..EffectSpec::NEUTRAL
};

fn width(&[width_px, ..]: &Values) -> f64 {
    width_px.abs()
}
