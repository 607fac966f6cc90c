//! Modulated light and a rolling shutter draw bands along x.

use std::f64::consts::TAU;

use super::act::{Act, Pixel, Values};
use super::spec::{BelongsTo, EffectSpec, MAPS, Sampling, amplitude, period, phase};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "flicker_banding",
    standard_name: "rolling shutter flicker",
    sentence: "Modulated light and a rolling shutter draw bands along x[: {amplitude_rel:%}][ every {period_mm}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + A sin(2πy/P + φ)",
    source: "rows are exposed one after the other",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.02), 0.003),
        period("period_mm", "mm", 8.0, (1.0, 50.0), Sampling::Rows),
        phase(),
    ],
    shows_in: "y_mm",
    look_alikes: &[("prnu_gradient", "rotate_180")],
    acts: &[Act::Pixel(band)],
    ..EffectSpec::NEUTRAL
};

fn band(&[amplitude_rel, period_mm, phase_rad, ..]: &Values, pixel: &Pixel) -> f64 {
    1.0 + amplitude_rel * (TAU * pixel.y_mm / period_mm + phase_rad).sin()
}
