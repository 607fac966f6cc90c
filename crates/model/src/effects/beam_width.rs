//! The lamp's beam is wider or narrower than when the model was made: another temperature or age of its optics, another
//! seat in them. A lobe cosᵐγ becomes one of another exponent, whatever m is, and its flux stays. At one distance it
//! changes readings nearly as a light centre off the axes does.

use crate::luminaire::lobe_cosine;

use super::act::{Act, DirectionFactor, Ray, Values};
use super::spec::{BelongsTo, EffectSpec, READINGS_AND_MAPS, amplitude};

pub(super) static SPEC: EffectSpec = EffectSpec {
    name: "beam_width",
    standard_name: "width of the luminous intensity distribution",
    sentence: "The lamp's beam is wider or narrower than in the model[: the exponent of its lobe is {exponent:size} \
        {exponent:smaller|larger}].",
    belongs_to: &[BelongsTo::Luminaire],
    stages: READINGS_AND_MAPS,
    formula: "(max(cos γ, cos 85°)/c)^(−n), c the geometric mean of that cosine over the flux",
    source: "generalized cosine lobe Iₘ = I₀·cosᵐγ; c keeps the flux to the first order of n",
    parameters: &[amplitude("exponent", "1", (-1.0, 1.0), 0.05)],
    shape_over_gamma: true,
    shows_in: "gamma_deg",
    look_alikes: &[("axial_centre", "second_distance"), ("near_field", "second_distance")],
    acts: &[Act::Direction(widened)],
    ..EffectSpec::NEUTRAL
};

fn widened(&[exponent, ..]: &Values) -> DirectionFactor {
    Box::new(move |ray: &Ray| (lobe_cosine(ray.direction.z) / ray.mean_cosine).powf(-exponent))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use isolux_photometry::IntensityDistribution;

    use super::SPEC;
    use crate::{Effect, Emitter, Luminaire, Model, Spectral};

    /// A lobe of an exponent and 100 lm, its intensity in closed form.
    fn lobe_cd(exponent: f64, gamma_deg: f64) -> f64 {
        100.0 * (exponent + 1.0) / TAU * gamma_deg.to_radians().cos().max(0.0).powf(exponent)
    }

    #[test]
    fn a_wider_lobe_is_one_of_a_smaller_exponent_and_the_same_flux() {
        for (exponent, change) in [(1.0, 0.05), (8.0, 0.2), (45.0, -0.9)] {
            let gamma_deg: Vec<f64> = (0..=180).map(f64::from).collect();
            let intensity_cd = gamma_deg.iter().map(|gamma| lobe_cd(exponent, *gamma)).collect();
            let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap();
            let lamp = Luminaire::new(distribution, Emitter::Disc { diameter_mm: 1.0 }, Spectral::None);
            let effect = Effect::new(&SPEC, &[change]).unwrap();
            let wider = Model::of(lamp).with_effects(vec![effect]).distribution().unwrap();
            for gamma in [0.0, 5.0, 20.0, 40.0] {
                let (found, wanted) = (wider.intensity_cd_at(0.0, gamma), lobe_cd(exponent - change, gamma));
                assert!(
                    (found / wanted - 1.0).abs() < 1.5e-3,
                    "{exponent} {change} {gamma}: {found} {wanted}"
                );
            }
            let flux_lm = wider.flux_lm();
            assert!((flux_lm / 100.0 - 1.0).abs() < 1.5e-3, "{flux_lm}");
        }
    }
}
