//! A part of the luminaire or its mount blocks light in a patch of directions.

use isolux_photometry::direction;

use super::act::{Act, DirectionFactor, Ray, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude, azimuth_of, shape};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "self_absorption",
    standard_name: "self-absorption; absorption by the mount",
    sentence: "Something stands in the way of the light[: {depth_rel:%} are missing][ about C {azimuth_deg}][, γ \
        {gamma_deg}][, over {width_deg}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 − q·exp((cos ω − 1)/σ²), ω the angle from the direction (C₀, γ₀), σ = w/2.355",
    source: "obstructed solid angle with a soft edge",
    parameters: &[
        amplitude("depth_rel", "1", (0.0, 0.5), 0.02).share(),
        azimuth_of(&[0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0]),
        shape("gamma_deg", "°", 45.0, (0.0, 90.0), &[20.0, 40.0, 60.0]),
        shape("width_deg", "°", 20.0, (5.0, 60.0), &[10.0, 20.0, 40.0]).above_zero(),
    ],
    shows_in: "c_deg",
    look_alikes: &[("dead_sector", "rotate_c_180")],
    acts: &[Act::Direction(shadow)],
    ..EffectSpec::NEUTRAL
};

/// Full width at half depth of a Gaussian over its standard deviation, √(8 ln 2).
const FULL_WIDTH: f64 = 2.354_820_045_030_949;

fn shadow(&[depth_rel, azimuth_deg, gamma_deg, width_deg]: &Values) -> DirectionFactor {
    let width = width_deg.to_radians() / FULL_WIDTH;
    let (middle, per_cosine) = (direction(azimuth_deg, gamma_deg), 1.0 / (width * width));
    Box::new(move |ray: &Ray| 1.0 - depth_rel * ((ray.direction.dot(middle) - 1.0) * per_cosine).exp())
}
