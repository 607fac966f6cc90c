//! A reflection inside the camera puts a soft spot at a fixed place of the sensor.

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "ghost",
    standard_name: "ghost reflection",
    sentence: "A reflection inside the camera puts a soft spot on the sensor[: {amplitude_rel:%}][ at x {x_mm}][, y \
        {y_mm}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + A exp(−((x − x₀)² + (y − y₀)²)/(2w²))",
    source: "a Gaussian image of the source",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.02), 0.005),
        shape("x_mm", "mm", 0.0, (-12.0, 12.0), &[-7.0, 0.0, 7.0]),
        shape("y_mm", "mm", 0.0, (-12.0, 12.0), &[-7.0, 0.0, 7.0]),
        shape("width_mm", "mm", 3.0, (0.5, 8.0), &[1.5, 3.0, 6.0]).above_zero(),
    ],
    shows_in: "x_mm",
    look_alikes: &[("vignetting", "tilts")],
    acts: &[Act::Pixel(spot)],
    ..EffectSpec::NEUTRAL
};

fn spot(&[amplitude_rel, x_mm, y_mm, width_mm]: &Values, pixel: &Pixel) -> f64 {
    let (x, y) = ((pixel.x_mm - x_mm) / width_mm, (pixel.y_mm - y_mm) / width_mm);
    1.0 + amplitude_rel * (-0.5 * (x * x + y * y)).exp()
}
