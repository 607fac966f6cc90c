//! The photometer weighs the lamp's spectrum otherwise than V(λ), and the colour changes over γ.

use super::act::{Act, DetectorView, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "spectral_mismatch",
    standard_name: "spectral mismatch f1′ (F*)",
    sentence: "The lux meter weighs this spectrum otherwise than V(λ)[: {factor:off1%} {factor:too much|too little}][, \
        changing by {slope_per_deg:%} for each degree of γ].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "F·(1 + s·|γ|)",
    source: "ISO/CIE 19476, f1′; colour over angle to first order",
    parameters: &[
        amplitude("factor", "1", (0.97, 1.03), 0.005).null(1.0),
        amplitude("slope_per_deg", "1/°", (-5e-4, 5e-4), 1e-4),
    ],
    shows_in: "gamma_deg",
    look_alikes: &[("colour_over_angle", "spectra_over_angle")],
    acts: &[Act::Detector(response)],
    ..EffectSpec::NEUTRAL
};

fn response(&[factor, slope_per_deg, ..]: &Values, view: &DetectorView) -> f64 {
    factor * (1.0 + slope_per_deg * view.gamma_deg.abs())
}
