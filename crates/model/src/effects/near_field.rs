//! The light does not come from a point: a ring of LEDs, each with the far field's lobe, aimed inward by ψ.
//! 
//! It replaces the emitter of a point or disc. The far field stays what the file says.

use crate::emitter::Emitter;

use super::act::Act;
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS_AND_MAPS, Split, amplitude, shape};

/// Limited photometric distance; breakdown of the inverse square law.
pub(super) static NEAR_FIELD: EffectSpec = EffectSpec {
    name: "near_field",
    standard_name: "limited photometric distance; breakdown of the inverse square law",
    sentence: "The light does not come from a point: at a short distance the size of the luminous area shows[, as a ring of {radius_mm} radius].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "Σ wᵢ I(ψ, θᵢ) cos εᵢ / rᵢ² over a ring of LEDs, εᵢ the incidence at the detector",
    source: "CIE 121, limiting photometric distance; exact sum over a ring",
    parameters: &[
        amplitude("radius_mm", "mm", (10.0, 60.0), 20.0, READINGS_AND_MAPS),
        ParameterSpec { required: false, step: 1.0, ..shape("aim_deg", "°", 0.0, (0.0, 10.0), &[0.0, 2.5, 5.0, 7.5, 10.0], READINGS_AND_MAPS) },
    ],
    amplitude_power: 2,
    shows_in: "distance_mm",
    splits: &[Split { from: "axial_centre", by: "second_distance" }, Split { from: "sensor_axial", by: "distances" }, Split { from: "exposure_offset", by: "exposures" }],
    acts: &[Act::Emitter(ring)],
};

/// LEDs on the ring: the trapezoid rule converges geometrically in radius over distance.
const LEDS: usize = 12;

fn ring(values: &[f64]) -> Emitter {
    Emitter::Leds {
        position_mm: Vec::new(),
        weight: Vec::new(),
        radius_mm: vec![values[0].abs()],
        count: vec![LEDS],
        aim_deg: values[1],
    }
}
