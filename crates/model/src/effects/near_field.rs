//! The light does not come from a point: a ring of LEDs, each with the far field's lobe, aimed inward by ψ. It
//! replaces the emitter of a point or disc. The far field stays what the file says.

use crate::emitter::Emitter;

use super::act::{Act, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "near_field",
    standard_name: "limited photometric distance; breakdown of the inverse square law",
    sentence: "The light does not come from a point: at a short distance the size of the luminous area shows[, as a ring of \
        {radius_mm} radius].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "Σ wᵢ I(ψ, θᵢ) cos εᵢ / rᵢ² over a ring of LEDs, εᵢ the incidence at the detector",
    source: "CIE 121, limiting photometric distance; exact sum over a ring",
    parameters: &[
        amplitude("radius_mm", "mm", (10.0, 60.0), 20.0),
        shape("aim_deg", "°", 0.0, (0.0, 10.0), &[0.0, 2.5, 5.0, 7.5, 10.0]).optional(1.0),
    ],
    amplitude_power: 2,
    shows_in: "distance_mm",
    look_alikes: &[
        ("axial_centre", "second_distance"),
        ("sensor_axial", "distances"),
        ("exposure_offset", "exposures"),
    ],
    acts: &[Act::Emitter(ring)],
    ..EffectSpec::NEUTRAL
};

/// LEDs on the ring: the trapezoid rule converges geometrically in radius over distance.
const LEDS: usize = 12;

fn ring(&[radius_mm, aim_deg, ..]: &Values) -> Emitter {
    Emitter::Leds {
        position_mm: Vec::new(),
        weight: Vec::new(),
        radius_mm: vec![radius_mm.abs()],
        count: vec![LEDS],
        aim_deg,
    }
}
