//! Panes before the sensor reflect the more the more obliquely the light falls.

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, amplitude, constant};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "cover_glass",
    standard_name: "Fresnel loss of the cover glass",
    sentence: "Panes before the sensor reflect slanting light away[, as many as {plates} would].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "T(θ)^k, T = ½(T_s + T_p) of a plate with inner reflections",
    source: "Fresnel equations; T = (1 − R)/(1 + R) per polarization",
    parameters: &[
        amplitude("plates", "1", (0.0, 4.0), 1.0),
        constant("index", "1", 1.52, (1.3, 2.0)).above_zero(),
    ],
    shows_in: "incidence_deg",
    look_alikes: &[("pixel_angular", "tilts")],
    acts: &[Act::Pixel(transmission)],
    ..EffectSpec::NEUTRAL
};

fn transmission(&[plates, index, ..]: &Values, pixel: &Pixel) -> f64 {
    if plates == 0.0 {
        return 1.0;
    }
    let cos = pixel.cos_incidence.clamp(0.0, 1.0);
    let sin_inside = (1.0 - cos * cos).sqrt() / index;
    let cos_inside = (1.0 - sin_inside * sin_inside).max(0.0).sqrt();
    let plate = |amplitude: f64| {
        let reflected = amplitude * amplitude;
        (1.0 - reflected) / (1.0 + reflected)
    };
    let s = plate((cos - index * cos_inside) / (cos + index * cos_inside));
    let p = plate((cos_inside - index * cos) / (cos_inside + index * cos));
    (0.5 * (s + p)).powf(plates)
}
