//! A group of LEDs gives less light: the sum over a ring of aimed LEDs with some of them dimmed, over the same sum
//! whole.
//!
//! The dimmed side takes away both its own place and the lobe that it aims elsewhere, so that the loss is a dipole in C
//! that grows like tan γ and has a part in 1/d. Where the model's emitter has no LEDs of its own, the ring is a usual
//! one: 28 mm, aimed inward by 6°.

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS_AND_MAPS, Split, amplitude, shape};

/// Failed or dimmed LEDs (C-dependent).
pub(super) static DEAD_SECTOR: EffectSpec = EffectSpec {
    name: "dead_sector",
    standard_name: "failed or dimmed LEDs (C-dependent)",
    sentence: "Some LEDs give less light than the others[: {depth_rel:%} less][ about C {azimuth_deg}][, over {width_deg}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "Σ (1 − q·lobe(Cᵢ − C₀, w)) I(ψ, θᵢ)/rᵢ² over Σ I(ψ, θᵢ)/rᵢ², lobe a raised cosine over the azimuth of the LEDs",
    source: "sum over a ring of aimed LEDs",
    parameters: &[
        amplitude("depth_rel", "1", (0.0, 0.3), 0.05, READINGS_AND_MAPS),
        ParameterSpec {
            required: true,
            ..shape("azimuth_deg", "°", 0.0, (0.0, 360.0), AZIMUTHS_DEG, READINGS_AND_MAPS)
        },
        shape("width_deg", "°", 120.0, (20.0, 240.0), &[60.0, 140.0], READINGS_AND_MAPS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[
        Split { from: "luminaire_tilt", by: "second_distance" },
        Split { from: "self_absorption", by: "second_distance" },
    ],
    acts: &[Act::Part(dimming)],
};

/// One sector is no sum of two at right angles: azimuths are tried one by one.
const AZIMUTHS_DEG: &[f64] = &[0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0, 240.0, 270.0, 300.0, 330.0];

fn dimming(values: &[f64], azimuth_deg: f64) -> f64 {
    let apart = (azimuth_deg - values[1] + 180.0).rem_euclid(360.0) - 180.0;
    // The width is the full one at half depth.
    let lobe = if apart.abs() < values[2] { 0.5 * (1.0 + (std::f64::consts::PI * apart / values[2]).cos()) } else { 0.0 };
    1.0 - values[0] * lobe
}
