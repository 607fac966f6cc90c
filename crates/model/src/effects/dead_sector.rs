//! A group of LEDs gives less light: one side of C is darker, and the more so the larger γ is.
//! 
//! On the axis all groups look alike and the loss is a matter of level; off the axis a group that is aimed to its side has a
//! share that grows like tan γ.

use super::act::{Act, Ray};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, ParameterSpec, Split, amplitude, shape};

/// Failed or dimmed LEDs (C-dependent).
pub(super) static DEAD_SECTOR: EffectSpec = EffectSpec {
    name: "dead_sector",
    standard_name: "failed or dimmed LEDs (C-dependent)",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 − q·lobe(C − C₀, w)·tan γ, lobe = exp((cos ΔC − 1)/σ²), σ = w/2.355",
    source: "share of a sector of aimed LEDs in a direction: (cos ψ + sin ψ tan γ cos ΔC)ⁿ to first order in ψ",
    parameters: &[
        amplitude("depth_rel", "1", (0.0, 0.3), 0.02, READINGS_AND_MAPS),
        ParameterSpec {
            required: true,
            ..shape("azimuth_deg", "°", 0.0, (0.0, 360.0), AZIMUTHS_DEG, READINGS_AND_MAPS)
        },
        shape("width_deg", "°", 120.0, (20.0, 240.0), &[40.0, 80.0, 140.0, 220.0], READINGS_AND_MAPS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[Split { from: "luminaire_tilt", by: "second_distance" }, Split { from: "self_absorption", by: "second_distance" }],
    acts: &[Act::Direction(dimming)],
};

/// One lobe is no sum of two at right angles: azimuths are tried one by one.
const AZIMUTHS_DEG: &[f64] = &[0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 210.0, 240.0, 270.0, 300.0, 330.0];

/// Beyond this γ the growth is held: a sector cannot dim more than it gave.
const GAMMA_HELD_DEG: f64 = 75.0;

/// Full width at half depth of a Gaussian over its standard deviation, √(8 ln 2).
const FULL_WIDTH: f64 = 2.354_820_045_030_949;

fn dimming(values: &[f64], ray: &Ray) -> f64 {
    let width = values[2].to_radians() / FULL_WIDTH;
    let lobe = (((ray.c_deg - values[1]).to_radians().cos() - 1.0) / (width * width)).exp();
    let growth = ray.gamma_deg.min(GAMMA_HELD_DEG).to_radians().tan();
    (1.0 - values[0] * lobe * growth).max(0.0)
}
