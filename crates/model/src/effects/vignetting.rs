//! The corners of the sensor get less, whatever stands before it.

use super::act::{Act, Pixel};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude};

/// Vignetting.
pub(super) static VIGNETTING: EffectSpec = EffectSpec {
    name: "vignetting",
    standard_name: "vignetting",
    sentence: "The corners of the sensor get less light[: {coefficient_rel:%} less at the edge].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 − v·r², r in half widths of the sensor",
    source: "lowest even order",
    parameters: &[
        amplitude("coefficient_rel", "1", (0.0, 0.05), 0.01, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "radius_mm",
    splits: &[Split { from: "near_field", by: "distances" }],
    acts: &[Act::Pixel(shade)],
};

fn shade(values: &[f64], pixel: &Pixel) -> f64 {
    let square = (pixel.x_mm * pixel.x_mm + pixel.y_mm * pixel.y_mm) / (pixel.half_width_mm * pixel.half_width_mm);
    1.0 - values[0] * square
}
