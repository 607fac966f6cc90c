//! A pixel takes less of light that falls aslant.

use super::act::{Act, Pixel};
use super::spec::{BelongsTo, EffectSpec, MAPS, Split, amplitude};

/// Angular response of the pixels (micro-lenses, chief ray angle).
pub(super) static PIXEL_ANGULAR: EffectSpec = EffectSpec {
    name: "pixel_angular",
    standard_name: "angular response of the pixels (micro-lenses, chief ray angle)",
    sentence: "The pixels take less of light that falls aslant[, with coefficient {coefficient}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "exp(−k tan² θ)",
    source: "Gaussian acceptance of a micro-lens",
    parameters: &[
        amplitude("coefficient", "1", (0.0, 1.0), 0.05, MAPS),
    ],
    amplitude_power: 1,
    shows_in: "incidence_deg",
    splits: &[Split { from: "cover_glass", by: "tilts" }],
    acts: &[Act::Pixel(acceptance)],
};

fn acceptance(values: &[f64], pixel: &Pixel) -> f64 {
    let cos = pixel.cos_incidence.clamp(1e-6, 1.0);
    (-values[0] * (1.0 / (cos * cos) - 1.0)).exp()
}
