//! A reflection inside the camera puts a soft spot at a fixed place of the sensor.

use super::act::{Act, Pixel};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude, shape};

/// Ghost reflection.
pub(super) static GHOST: EffectSpec = EffectSpec {
    name: "ghost",
    standard_name: "ghost reflection",
    sentence: "A reflection inside the camera puts a soft spot on the sensor[: {amplitude_rel:%}][ at x {x_mm}][, y {y_mm}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + A exp(−((x − x₀)² + (y − y₀)²)/(2w²))",
    source: "a Gaussian image of the source",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.02), 0.005, MAPS),
        shape("x_mm", "mm", 0.0, (-12.0, 12.0), &[-7.0, 0.0, 7.0], MAPS),
        shape("y_mm", "mm", 0.0, (-12.0, 12.0), &[-7.0, 0.0, 7.0], MAPS),
        shape("width_mm", "mm", 3.0, (0.5, 8.0), &[1.5, 3.0, 6.0], MAPS),
    ],
    amplitude_power: 1,
    shows_in: "x_mm",
    splits: &[Split { from: "vignetting", by: "tilts" }],
    acts: &[Act::Pixel(spot)],
};

fn spot(values: &[f64], pixel: &Pixel) -> f64 {
    let (x, y) = ((pixel.x_mm - values[1]) / values[3], (pixel.y_mm - values[2]) / values[3]);
    1.0 + values[0] * (-0.5 * (x * x + y * y)).exp()
}
