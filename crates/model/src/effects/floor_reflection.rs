//! Light of the lamp that the floor returns to the detector, one bounce. A baffle in the direct path leaves it,
//! lamp-off readings do not have it.

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "floor_reflection",
    standard_name: "inter-reflection stray light, angle dependent",
    sentence: "The floor returns light of the lamp to the detector[, as one of reflectance {albedo} would][ {height_mm} \
        below the axis].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "E + ρ/π ∫ I(Θ) cosθ₁ cosθ₂ cosθ_det / (r₁² r₂²) dA over the floor at Z = −h",
    source: "diffuse inter-reflection of one bounce (Lambert); EN 13032-1, stray light",
    parameters: &[
        amplitude("albedo", "1", (0.02, 0.9), 0.1).share(),
        shape(
            "height_mm",
            "mm",
            1300.0,
            (800.0, 2000.0),
            &[800.0, 1100.0, 1500.0, 2000.0],
        )
        .above_zero(),
    ],
    shows_in: "gamma_deg",
    look_alikes: &[("ambient_stray", "second_distance")],
    acts: &[Act::Floor(floor)],
    ..EffectSpec::NEUTRAL
};

// The integral is in the prediction of a reading (`crate::floor`), because it needs the luminaire.
fn floor(&[albedo, height_mm, ..]: &Values) -> (f64, f64) {
    (albedo, height_mm)
}
