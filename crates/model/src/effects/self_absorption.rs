//! Something of the luminaire or of its mount stands in the way of the light, in a patch of directions.

use glam::DVec3;

use super::act::{Act, Ray};
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS_AND_MAPS, Split, amplitude, shape};

/// Self-absorption; absorption by the mount.
pub(super) static SELF_ABSORPTION: EffectSpec = EffectSpec {
    name: "self_absorption",
    standard_name: "self-absorption; absorption by the mount",
    sentence: "Something stands in the way of the light[: {depth_rel:%} are missing][ about C {azimuth_deg}][, γ {gamma_deg}][, over {width_deg}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 − q·exp((cos ω − 1)/σ²), ω the angle from the direction (C₀, γ₀), σ = w/2.355",
    source: "obstructed solid angle with a soft edge",
    parameters: &[
        amplitude("depth_rel", "1", (0.0, 0.5), 0.02, READINGS_AND_MAPS),
        ParameterSpec { required: true, ..shape("azimuth_deg", "°", 0.0, (0.0, 360.0), &[0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0], READINGS_AND_MAPS) },
        shape("gamma_deg", "°", 45.0, (0.0, 90.0), &[20.0, 40.0, 60.0], READINGS_AND_MAPS),
        shape("width_deg", "°", 20.0, (5.0, 60.0), &[10.0, 20.0, 40.0], READINGS_AND_MAPS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[Split { from: "dead_sector", by: "rotate_c_180" }],
    acts: &[Act::Direction(shadow)],
};

/// Full width at half depth of a Gaussian over its standard deviation, √(8 ln 2).
const FULL_WIDTH: f64 = 2.354_820_045_030_949;

fn shadow(values: &[f64], ray: &Ray) -> f64 {
    let (sin_c, cos_c) = values[1].to_radians().sin_cos();
    let (sin, cos) = values[2].to_radians().sin_cos();
    let width = values[3].to_radians() / FULL_WIDTH;
    let cos_apart = ray.direction.dot(DVec3::new(sin * cos_c, sin * sin_c, cos));
    1.0 - values[0] * ((cos_apart - 1.0) / (width * width)).exp()
}
