//! The detector averages over its aperture. Even in γ: an honest refit of the lamp's shape absorbs nearly all of it.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

/// Angular size of the detector.
pub(super) static DETECTOR_APERTURE: EffectSpec = EffectSpec {
    name: "detector_aperture",
    standard_name: "angular size of the detector",
    sentence: "The detector is so large that it averages over directions[: {diameter_mm} wide].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "I + (a/d)² (⅛ ∇²I − ¾ I), a the radius of the flat aperture",
    source: "mean over a disc, to second order",
    parameters: &[
        amplitude("diameter_mm", "mm", (0.0, 60.0), 20.0, READINGS),
    ],
    amplitude_power: 2,
    shows_in: "gamma_deg",
    splits: &[],
    acts: &[Act::Aperture(radius)],
};

fn radius(values: &[f64]) -> f64 {
    values[0] / 2.0
}
