//! The light centre is beside the optical axis, at azimuth φ of the luminaire's frame: a dipole in C that grows like
//! 1/d.

use glam::DVec3;

use super::act::{Act, Mounting};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude, azimuth};

/// Photometric centre offset, lateral.
pub(super) static LATERAL_CENTRE: EffectSpec = EffectSpec {
    name: "lateral_centre",
    standard_name: "photometric centre offset, lateral",
    sentence: "The light centre is beside the optical axis[, by {offset_mm:size}][ towards C {azimuth_deg}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "P − r·(cos φ, sin φ, 0)",
    source: "CIE 121, light centre; vector algebra",
    parameters: &[
        amplitude("offset_mm", "mm", (0.0, 20.0), 2.0, READINGS),
        azimuth(360.0, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[Split { from: "luminaire_tilt", by: "second_distance" }],
    acts: &[Act::Mount(shift)],
};

fn shift(values: &[f64], mounting: &mut Mounting) {
    let (sin, cos) = values[1].to_radians().sin_cos();
    mounting.detector_mm -= DVec3::new(values[0] * cos, values[0] * sin, 0.0);
}
