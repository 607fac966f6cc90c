//! The photometer weighs the lamp's spectrum otherwise than V(λ), and the colour changes over γ.

use super::act::{Act, DetectorView};
use super::spec::{BelongsTo, EffectSpec, ParameterSpec, READINGS, amplitude};

/// Spectral mismatch f1′ (F*).
pub(super) static SPECTRAL_MISMATCH: EffectSpec = EffectSpec {
    name: "spectral_mismatch",
    standard_name: "spectral mismatch f1′ (F*)",
    sentence: "The lux meter weighs this spectrum otherwise than V(λ)[: {factor:off1%} {factor:too much|too little}][, changing by {slope_per_deg:%} for each degree of γ].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "F·(1 + s·|γ|)",
    source: "ISO/CIE 19476, f1′; colour over angle to first order",
    parameters: &[
        ParameterSpec { null: 1.0, ..amplitude("factor", "1", (0.97, 1.03), 0.005, READINGS) },
        amplitude("slope_per_deg", "1/°", (-5e-4, 5e-4), 1e-4, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "gamma_deg",
    splits: &[],
    acts: &[Act::Detector(response)],
};

fn response(values: &[f64], view: &DetectorView) -> f64 {
    values[0] * (1.0 + values[1] * view.gamma_deg.abs())
}
