//! The light centre is on the optical axis but not in the intersection of the axes.
//! 
//! It lies at z·e_z of the luminaire's frame; the detector still faces the intersection.

use super::act::{Act, Mounting};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude};

/// Photometric centre offset, axial.
pub(super) static AXIAL_CENTRE: EffectSpec = EffectSpec {
    name: "axial_centre",
    standard_name: "photometric centre offset, axial",
    sentence: "The light centre is not where the axes meet, but on the optical axis[, {offset_mm:size} {offset_mm:nearer to|farther from} the detector].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "P − z·e_z",
    source: "CIE 121, light centre; vector algebra",
    parameters: &[
        amplitude("offset_mm", "mm", (-30.0, 30.0), 2.0, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "distance_mm",
    splits: &[Split { from: "near_field", by: "second_distance" }, Split { from: "distance_offset", by: "second_distance" }],
    acts: &[Act::Mount(shift)],
};

fn shift(values: &[f64], mounting: &mut Mounting) {
    mounting.detector_mm.z -= values[0];
}
