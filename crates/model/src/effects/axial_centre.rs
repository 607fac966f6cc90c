//! The light centre is on the optical axis but not in the intersection of the axes. It lies at z·e_z of the
//! luminaire's frame; the detector still faces the intersection.

use super::act::{Act, Mounting, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "axial_centre",
    standard_name: "photometric centre offset, axial",
    sentence: "The light centre is not where the axes meet, but on the optical axis[, {offset_mm:size} {offset_mm:nearer \
        to|farther from} the detector].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "P − z·e_z",
    source: "CIE 121, light centre; vector algebra",
    parameters: &[amplitude("offset_mm", "mm", (-30.0, 30.0), 2.0)],
    shows_in: "distance_mm",
    look_alikes: &[
        ("near_field", "second_distance"),
        ("distance_offset", "second_distance"),
        ("beam_width", "second_distance"),
    ],
    acts: &[Act::Mount(shift)],
    ..EffectSpec::NEUTRAL
};

fn shift(&[offset_mm, ..]: &Values, mounting: &mut Mounting) {
    mounting.detector_mm.z -= offset_mm;
}
