//! Light that the lamp throws on the floor and the floor returns to the detector, one bounce.
//! 
//! The integral is in the prediction of a reading (`bench::floor`), because it needs the luminaire. It is lamp-made
//! stray light: a baffle in the direct path leaves it, lamp-off readings do not have it.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude, shape};

/// Inter-reflection stray light, angle dependent.
pub(super) static FLOOR_REFLECTION: EffectSpec = EffectSpec {
    name: "floor_reflection",
    standard_name: "inter-reflection stray light, angle dependent",
    sentence: "The floor returns light of the lamp to the detector[, as one of reflectance {albedo} would][ {height_mm} below the axis].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "E + ρ/π ∫ I(Θ) cosθ₁ cosθ₂ cosθ_det / (r₁² r₂²) dA over the floor at Z = −h",
    source: "diffuse inter-reflection of one bounce (Lambert); EN 13032-1, stray light",
    parameters: &[
        amplitude("albedo", "1", (0.02, 0.9), 0.1, READINGS),
        shape("height_mm", "mm", 1300.0, (800.0, 2000.0), &[800.0, 1100.0, 1500.0, 2000.0], READINGS),
    ],
    amplitude_power: 1,
    shows_in: "gamma_deg",
    splits: &[Split { from: "ambient_stray", by: "second_distance" }],
    acts: &[Act::Floor(floor)],
};

fn floor(values: &[f64]) -> (f64, f64) {
    (values[0], values[1])
}
