//! The lamp's colour changes over γ: a sensor that weighs the spectrum otherwise than V(λ) gets another signal for a
//! lumen of light than on the axis. So do the readings of another head than that of the model: how much depends on its
//! own curve. A head that reads too much on the axis as well has a spectral mismatch; a beam that has changed shows on
//! every head alike.

use super::act::{Act, DetectorView, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, Stage, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "colour_over_angle",
    standard_name: "colour changes over angle (angular colour uniformity)",
    sentence: "The lamp's colour changes over γ[: towards 90° a lumen gives {sensor_rel:%} {sensor_rel:more|less} \
        signal than on the axis][: towards 90° another head reads {head_rel:%} {head_rel:more|less} than on the axis].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "1 + k·sin²γ on the watts of a lumen (maps in W/m² and relative ones) and on readings of heads 1, 2, …",
    source: "colour over angle, to the lowest order that is smooth at γ = 0",
    parameters: &[
        amplitude("sensor_rel", "1", (-0.5, 0.5), 0.02).only_on(Stage::Maps),
        amplitude("head_rel", "1", (-0.1, 0.1), 0.01).of_other_heads(),
    ],
    shows_in: "gamma_deg",
    look_alikes: &[
        ("spectral_mismatch", "spectra_over_angle"),
        ("beam_width", "spectra_over_angle"),
    ],
    acts: &[Act::Colour(of_a_lumen), Act::Detector(head)],
    ..EffectSpec::NEUTRAL
};

fn of_a_lumen(&[sensor_rel, ..]: &Values, cos_gamma: f64) -> f64 {
    1.0 + sensor_rel * (1.0 - cos_gamma * cos_gamma)
}

fn head(&[_, head_rel, ..]: &Values, view: &DetectorView) -> f64 {
    if view.head == 0 {
        return 1.0;
    }
    1.0 + head_rel * view.gamma_deg.to_radians().sin().powi(2)
}
