//! The detector answers to the plane of polarization, which turns with C: twice around, even on the axis.

use super::act::{Act, DetectorView};
use super::spec::{BelongsTo, EffectSpec, READINGS, Split, amplitude, azimuth};

/// Polarization dependence f8.
pub(super) static POLARIZATION: EffectSpec = EffectSpec {
    name: "polarization",
    standard_name: "polarization dependence f8",
    sentence: "The detector answers to the plane of polarization, which turns with C[: {amplitude_rel:%}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + p cos 2(C − C₀)",
    source: "ISO/CIE 19476, f8",
    parameters: &[
        amplitude("amplitude_rel", "1", (0.0, 0.02), 0.002, READINGS),
        azimuth(180.0, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "c_deg",
    splits: &[Split { from: "temp_coefficient", by: "reference_repeats" }],
    acts: &[Act::Detector(response)],
};

fn response(values: &[f64], view: &DetectorView) -> f64 {
    1.0 + values[0] * (2.0 * (view.c_deg - values[1]).to_radians()).cos()
}
