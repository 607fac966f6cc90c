//! The sensitivity slopes across the sensor and turns with it.

use super::act::{Act, Pixel};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude, azimuth};

/// Photo response non-uniformity, gradient.
pub(super) static PRNU_GRADIENT: EffectSpec = EffectSpec {
    name: "prnu_gradient",
    standard_name: "photo response non-uniformity, gradient",
    sentence: "The sensitivity slopes across the sensor[: {gradient_rel:%} from the middle to the edge][, towards {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + g·(x cos φ + y sin φ)/half width",
    source: "EMVA 1288, PRNU, lowest order",
    parameters: &[
        amplitude("gradient_rel", "1", (0.0, 0.02), 0.003, MAPS),
        azimuth(360.0, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "x_mm",
    splits: &[Split { from: "sensor_tilt", by: "tilts" }, Split { from: "stage_lateral", by: "rotate_180" }],
    acts: &[Act::Pixel(response)],
};

fn response(values: &[f64], pixel: &Pixel) -> f64 {
    let (sin, cos) = values[1].to_radians().sin_cos();
    1.0 + values[0] * (pixel.x_mm * cos + pixel.y_mm * sin) / pixel.half_width_mm
}
