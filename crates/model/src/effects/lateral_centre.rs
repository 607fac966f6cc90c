//! The light centre is beside the optical axis, at azimuth φ of the luminaire's frame: a dipole in C that grows like
//! 1/d.

use glam::DVec3;

use super::act::{Act, Mounting, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "lateral_centre",
    standard_name: "photometric centre offset, lateral",
    sentence: "The light centre is beside the optical axis[, by {offset_mm:size}][ towards C {azimuth_deg}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "P − r·(cos φ, sin φ, 0)",
    source: "CIE 121, light centre; vector algebra",
    parameters: &[amplitude("offset_mm", "mm", (0.0, 20.0), 2.0), azimuth(360.0)],
    shows_in: "c_deg",
    look_alikes: &[("luminaire_tilt", "second_distance")],
    acts: &[Act::Mount(shift)],
    ..EffectSpec::NEUTRAL
};

fn shift(&[offset_mm, azimuth_deg, ..]: &Values, mounting: &mut Mounting) {
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    mounting.detector_mm -= DVec3::new(offset_mm * cos, offset_mm * sin, 0.0);
}
