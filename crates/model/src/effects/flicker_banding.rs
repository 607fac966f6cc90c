//! Modulated light and a rolling shutter draw bands along x.

use std::f64::consts::TAU;

use super::act::{Act, Pixel};
use super::spec::{BelongsTo, EffectSpec, MAPS, ParameterSpec, Role, Split, amplitude};

/// Rolling shutter flicker.
pub(super) static FLICKER_BANDING: EffectSpec = EffectSpec {
    name: "flicker_banding",
    standard_name: "rolling shutter flicker",
    sentence: "Modulated light and a rolling shutter draw bands along x[: {amplitude_rel:%}][ every {period_mm}].",
    belongs_to: &[BelongsTo::Sensor],
    stages: MAPS,
    formula: "1 + A sin(2πy/P + φ)",
    source: "rows are exposed one after the other",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.02), 0.003, MAPS),
        ParameterSpec { key: "period_mm", unit: "mm", null: 8.0, plausible: (1.0, 50.0), step: 0.1, role: Role::Period, stages: MAPS, required: true },
        ParameterSpec { key: "phase_rad", role: Role::Phase { period: TAU }, unit: "rad", null: 0.0, plausible: (0.0, TAU), step: 0.1, stages: MAPS, required: false },
    ],
    amplitude_power: 1,
    shows_in: "y_mm",
    splits: &[Split { from: "prnu_gradient", by: "rotate_180" }],
    acts: &[Act::Pixel(band)],
};

fn band(values: &[f64], pixel: &Pixel) -> f64 {
    1.0 + values[0] * (TAU * pixel.y_mm / values[1] + values[2]).sin()
}
