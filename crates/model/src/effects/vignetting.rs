//! The corners of the sensor get less, whatever stands before it.

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "vignetting",
    standard_name: "vignetting",
    sentence: "The corners of the sensor get less light[: {coefficient_rel:%} less at the edge].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 − v·r², r in half widths of the sensor",
    source: "lowest even order",
    parameters: &[amplitude("coefficient_rel", "1", (0.0, 0.05), 0.01)],
    shows_in: "radius_mm",
    look_alikes: &[("near_field", "distances")],
    acts: &[Act::Pixel(shade)],
    ..EffectSpec::NEUTRAL
};

fn shade(&[coefficient_rel, ..]: &Values, pixel: &Pixel) -> f64 {
    let square = (pixel.x_mm * pixel.x_mm + pixel.y_mm * pixel.y_mm) / (pixel.half_width_mm * pixel.half_width_mm);
    1.0 - coefficient_rel * square
}
