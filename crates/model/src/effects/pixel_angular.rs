//! A pixel takes less of light that falls obliquely.

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "pixel_angular",
    standard_name: "angular response of the pixels (micro-lenses, chief ray angle)",
    sentence: "The pixels take less of light that falls aslant[, with coefficient {coefficient}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "exp(−k tan² θ)",
    source: "Gaussian acceptance of a micro-lens",
    parameters: &[amplitude("coefficient", "1", (0.0, 1.0), 0.05)],
    shows_in: "incidence_deg",
    look_alikes: &[("cover_glass", "tilts")],
    acts: &[Act::Pixel(acceptance)],
    ..EffectSpec::NEUTRAL
};

fn acceptance(&[coefficient, ..]: &Values, pixel: &Pixel) -> f64 {
    let cos = pixel.cos_incidence.clamp(1e-6, 1.0);
    (-coefficient * (1.0 / (cos * cos) - 1.0)).exp()
}
