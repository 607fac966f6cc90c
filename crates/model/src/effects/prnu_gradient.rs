//! The sensitivity slopes across the sensor and turns with it.

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "prnu_gradient",
    standard_name: "photo response non-uniformity, gradient",
    sentence: "The sensitivity slopes across the sensor[: {gradient_rel:%} from the middle to the edge][, towards \
        {azimuth_deg}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + g·(x cos φ + y sin φ)/half width",
    source: "EMVA 1288, PRNU, lowest order",
    parameters: &[amplitude("gradient_rel", "1", (0.0, 0.02), 0.003), azimuth(360.0)],
    shows_in: "x_mm",
    look_alikes: &[("sensor_tilt", "tilts"), ("stage_lateral", "rotate_180")],
    acts: &[Act::Pixel(response)],
    ..EffectSpec::NEUTRAL
};

fn response(&[gradient_rel, azimuth_deg, ..]: &Values, pixel: &Pixel) -> f64 {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    1.0 + gradient_rel * (pixel.x_mm * cos + pixel.y_mm * sin) / pixel.half_width_mm
}
