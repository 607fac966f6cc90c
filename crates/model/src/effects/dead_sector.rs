//! A group of LEDs gives less light. The far field loses a dipole in C that grows like tan γ where the LEDs lean, and
//! nothing but its level where they do not; near the lamp there is a dipole in 1/d besides. Where the emitter has no LEDs
//! a ring of them is taken, at 0.84 of the luminous area's radius (28 mm for a point), that leans inwards by `aim_deg`.

use super::act::{Act, PartLaw, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, azimuth_of, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "dead_sector",
    standard_name: "failed or dimmed LEDs (C-dependent)",
    sentence: "Some LEDs give less light than the others[: {depth_rel:%} less][ about C {azimuth_deg}][, over {width_deg}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "Σ (1 − q·lobe(Cᵢ − C₀, w)) I(ψ, θᵢ)/rᵢ² over Σ I(ψ, θᵢ)/rᵢ², lobe a raised cosine over the azimuth of the \
        LEDs",
    source: "sum over a ring of aimed LEDs",
    parameters: &[
        amplitude("depth_rel", "1", (0.0, 0.3), 0.05).share(),
        azimuth_of(AZIMUTHS_DEG),
        shape("width_deg", "°", 120.0, (20.0, 240.0), &[30.0, 60.0, 140.0]).above_zero(),
        shape("aim_deg", "°", 6.0, (-10.0, 20.0), &[0.0, 4.0])
            .optional(1.0)
            .without_leds(),
    ],
    shows_in: "c_deg",
    look_alikes: &[
        ("luminaire_tilt", "second_distance"),
        ("self_absorption", "second_distance"),
    ],
    acts: &[Act::Part(PartLaw {
        given: dimming,
        aim_deg: |values| values[AIM],
    })],
    ..EffectSpec::NEUTRAL
};

/// Place of `aim_deg` among the values.
const AIM: usize = 3;

/// One sector is no sum of two at right angles: azimuths are tried one by one.
const AZIMUTHS_DEG: &[f64] = &[
    0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0, 240.0, 270.0, 300.0, 330.0,
];

fn dimming(&[depth_rel, azimuth_deg, width_deg, ..]: &Values, led_deg: f64) -> f64 {
    let apart = (led_deg - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
    // The width is the full one at half depth.
    let lobe = if apart.abs() < width_deg {
        0.5 * (1.0 + (std::f64::consts::PI * apart / width_deg).cos())
    } else {
        0.0
    };
    1.0 - depth_rel * lobe
}
