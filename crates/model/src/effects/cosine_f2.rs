//! The detector departs from the cosine. A detector that faces the axes sees nearly normal incidence: mostly blind.

use super::act::{Act, DetectorView};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

/// Directional response f2.
pub(super) static COSINE_F2: EffectSpec = EffectSpec {
    name: "cosine_f2",
    standard_name: "directional response f2",
    sentence: "The detector answers to slanting light otherwise than by the cosine[, by {coefficient_rel:%} {coefficient_rel:too much|too little} at 60°].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + k·(1 − cos ε)/(1 − cos 60°), ε the angle of incidence",
    source: "ISO/CIE 19476, f2, lowest even order; k is the error at 60°",
    parameters: &[
        amplitude("coefficient_rel", "1", (-0.1, 0.1), 0.05, READINGS),
    ],
    amplitude_power: 1,
    shows_in: "incidence_deg",
    splits: &[],
    acts: &[Act::Detector(response)],
};

fn response(values: &[f64], view: &DetectorView) -> f64 {
    1.0 + values[0] * 2.0 * (1.0 - view.cos_incidence)
}
