//! The light does not come from a point: LEDs on two circles, each with the far field's lobe, aimed inward by ψ. They
//! replace the emitter of a point or disc. The far field stays what the file says.
//!
//! Two circles stand for every radial profile, a ring, rings or a disc: for light that is even around the axis the
//! distance sees the profile by the moments of r² alone, and two radii with their shares have the same first four as
//! any profile (Gauss quadrature of order 2 in r²). A fit finds the radius and the share of the inner circle, from a
//! ring (0) by an even disc (one half) to a small ring (1).

use crate::emitter::Emitter;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, constant, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "near_field",
    standard_name: "limited photometric distance; breakdown of the inverse square law",
    sentence: "The light does not come from a point: at a short distance the size of the luminous area shows[, as \
        light from a circle of {radius_mm} radius][ and, {inner_share:%} of it, from one {inner_radius_rel:%} as \
        wide].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "Σ wᵢ I(ψ, θᵢ) cos εᵢ / rᵢ² over LEDs on two circles that stand for any radial profile, \
        εᵢ the incidence at the detector",
    source: "CIE 121, limiting photometric distance; Gauss quadrature of the radial profile",
    parameters: &[
        amplitude("radius_mm", "mm", (10.0, 60.0), 20.0),
        shape("aim_deg", "°", 0.0, (0.0, 10.0), &[0.0, 2.5, 5.0, 7.5, 10.0]).optional(1.0),
        shape("inner_share", "", 0.0, (0.0, 1.0), &[0.0]).optional(0.01).share(),
        // That of an even disc, unless a file says otherwise: fits of both beside the radius are several times as slow.
        constant("inner_radius_rel", "", 0.5176, (0.0, 1.0)).share(),
    ],
    amplitude_power: 2,
    shows_in: "distance_mm",
    look_alikes: &[
        ("axial_centre", "second_distance"),
        ("sensor_axial", "distances"),
        ("exposure_offset", "exposures"),
    ],
    acts: &[Act::Emitter(circles)],
    ..EffectSpec::NEUTRAL
};

/// LEDs on a circle: the trapezoid rule converges geometrically in radius over distance.
const LEDS: usize = 12;

fn circles(&[radius_mm, aim_deg, inner_share, inner_radius_rel]: &Values) -> Emitter {
    let radius_mm = radius_mm.abs();
    let (radius_mm, weight) = if inner_share == 0.0 {
        (vec![radius_mm], Vec::new())
    } else {
        (
            vec![radius_mm, inner_radius_rel * radius_mm],
            vec![1.0 - inner_share, inner_share],
        )
    };
    Emitter::Leds {
        position_mm: Vec::new(),
        count: vec![LEDS; radius_mm.len()],
        weight,
        radius_mm,
        aim_deg,
    }
}
