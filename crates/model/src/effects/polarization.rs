//! The detector answers to the plane of polarization, which turns with C: twice around, even on the axis.

use super::act::{Act, DetectorView, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude, azimuth};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "polarization",
    standard_name: "polarization dependence f8",
    sentence: "The detector answers to the plane of polarization, which turns with C[: {amplitude_rel:%}].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + p cos 2(C − C₀)",
    source: "ISO/CIE 19476, f8",
    parameters: &[amplitude("amplitude_rel", "1", (0.0, 0.02), 0.002), azimuth(180.0)],
    shows_in: "c_deg",
    look_alikes: &[("temp_coefficient", "reference_repeats")],
    acts: &[Act::Detector(response)],
    ..EffectSpec::NEUTRAL
};

fn response(&[amplitude_rel, azimuth_deg, ..]: &Values, view: &DetectorView) -> f64 {
    1.0 + amplitude_rel * (2.0 * (view.c_deg - azimuth_deg).to_radians()).cos()
}
