//! The detector departs from the cosine. Hardly seen by a detector that faces the axes.

use super::act::{Act, DetectorView, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "cosine_f2",
    standard_name: "directional response f2",
    sentence: "The detector answers to slanting light otherwise than by the cosine[, by {coefficient_rel:%} \
        {coefficient_rel:too much|too little} at 60°].",
    belongs_to: &[BelongsTo::Bench],
    stages: READINGS,
    formula: "1 + k·(1 − cos ε)/(1 − cos 60°), ε the angle of incidence",
    source: "ISO/CIE 19476, f2, lowest even order; k is the error at 60°",
    parameters: &[amplitude("coefficient_rel", "1", (-0.1, 0.1), 0.05)],
    shows_in: "incidence_deg",
    acts: &[Act::Detector(response)],
    ..EffectSpec::NEUTRAL
};

fn response(&[coefficient_rel, ..]: &Values, view: &DetectorView) -> f64 {
    1.0 + coefficient_rel * 2.0 * (1.0 - view.cos_incidence)
}
