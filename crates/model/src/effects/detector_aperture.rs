//! The detector averages over its aperture. Even in γ: a refit of the lamp's shape absorbs nearly all of it.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "detector_aperture",
    standard_name: "angular size of the detector",
    sentence: "The detector is so large that it averages over directions[: {diameter_mm} wide].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "I + (a/d)² (⅛ ∇²I − ¾ I), a the radius of the flat aperture",
    source: "mean over a disc, to second order",
    parameters: &[amplitude("diameter_mm", "mm", (0.0, 60.0), 20.0)],
    amplitude_power: 2,
    shows_in: "gamma_deg",
    acts: &[Act::Aperture(radius)],
    ..EffectSpec::NEUTRAL
};

fn radius(&[diameter_mm, ..]: &Values) -> f64 {
    diameter_mm / 2.0
}
