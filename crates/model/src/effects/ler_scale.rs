//! The spectrum gives another efficacy than the light has: W/m² are off by one factor, lx are not.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "ler_scale",
    standard_name: "luminous efficacy of radiation (wrong spectrum)",
    sentence: "The spectrum is not that of the light[: its efficacy is {factor:off1%} too {factor:high|low}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: MAPS,
    formula: "K · factor",
    source: "K = K_m ∫SV dλ / ∫S dλ",
    parameters: &[amplitude("factor", "1", (0.97, 1.03), 0.005).null(1.0).above_zero()],
    shows_in: "level",
    look_alikes: &[("sensor_axial", "distances")],
    acts: &[Act::Efficacy(scale)],
    ..EffectSpec::NEUTRAL
};

fn scale(&[factor, ..]: &Values) -> f64 {
    factor
}
