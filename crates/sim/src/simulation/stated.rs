//! The facts of a result, from its map.

use std::borrow::Cow;

use isolux_model::{Accuracy, Scene};

use super::facts::{AccuracyFacts, Facts, MapUnit, PixelBound};
use super::mean_uncertainty::MeanUncertainty;
use super::rays::Rays;
use super::receiver::Receiver;
use super::{Method, Solved, noise_free};
use crate::direct::Counts;
use crate::noise::{self, Moments};
use crate::setup::Setup;

/// All that `result.json` states of a map but for what the caller's clock and the camera say.
pub(super) fn facts(scene: &Scene, setup: &Setup, receiver: &Receiver<'_>, method: Method, solved: &Solved) -> Facts {
    // A map has at least one pixel.
    let moments = noise::moments(&solved.map).unwrap_or(Moments {
        mean: 0.0,
        min: 0.0,
        max: 0.0,
        std: 0.0,
    });
    let mean = moments.mean;
    let counts = solved.counts.as_ref();
    let ray = counts.map(|counts| Rays::of(counts, setup, noise_free(setup, Accuracy::Standard).0));
    let u_mean_numeric = ray.as_ref().map_or(solved.bound.mean_lx, |ray| {
        mean.abs().max(ray.value / setup.sensor.pixels() as f64) * ray.relative_of_mean
    });
    let distance_mm = scene.model.placement(scene.sensor.pose).pose.centre_mm().length();
    let of_mean = MeanUncertainty::of(scene, mean, u_mean_numeric, setup.ler_lm_per_w.is_some(), distance_mm);
    let effects = scene.model.in_simulation();
    let (sampling, rays, seed) = match method {
        Method::Inverse => (None, None, None),
        Method::Direct { sampling, rays, seed } => (Some(sampling.word().into()), Some(rays), Some(seed)),
    };
    let inverse = rays.is_none();
    let efficacy = receiver.efficacy(setup.ler_lm_per_w);
    Facts {
        method: if inverse { "inverse" } else { "direct" }.into(),
        sampling,
        rays,
        seed,
        unit: MapUnit::of(setup),
        mean,
        u_mean_numeric,
        accuracy: inverse.then(|| AccuracyFacts::of(scene.accuracy, &solved.bound)),
        pixel_error_bound: inverse.then_some(PixelBound {
            absolute: solved.bound.largest_lx,
            relative: solved.bound.largest,
        }),
        u_mean: of_mean.u,
        u_mean_missing: of_mean.missing,
        min: moments.min,
        max: moments.max,
        std: moments.std,
        uniformity_min_over_mean: if mean == 0.0 { 0.0 } else { moments.min / mean },
        rays_on_sensor: counts.map(Counts::on_sensor),
        relative_error_per_pixel: ray.as_ref().map(|ray| ray.relative_per_pixel),
        max_ray_noise: ray.as_ref().map(|ray| ray.maximum),
        max_noise_free: ray.as_ref().map(|ray| ray.max_noise_free),
        effects_applied: effects.applied.into_iter().map(Cow::Borrowed).collect(),
        effects_not_applicable: effects.not_applicable.into_iter().map(Cow::Borrowed).collect(),
        elapsed_s: None,
        std_without_ray_noise: ray.as_ref().map(|ray| noise::std_without_noise(&moments, ray.value)),
        rays_for_1_percent_per_pixel: ray.as_ref().map(|ray| ray.needed),
        empty_pixels: counts.map(Counts::empty),
        one_ray_in_a_pixel: ray.as_ref().map(|ray| ray.value),
        flux_lm: scene
            .model
            .distribution()
            .map_or(f64::NAN, |distribution| distribution.flux_lm()),
        ler_lm_per_w: setup.ler_lm_per_w,
        pixels: scene.sensor.pixels,
        size_mm: scene.sensor.size_mm,
        photon_irradiance_per_m2_s: receiver.photon_irradiance(mean),
        illuminance_lx: mean * efficacy.filter(|_| setup.ler_lm_per_w.is_some()).unwrap_or(1.0),
        camera: None,
        colour: receiver.colour,
        bands: receiver.bands(mean),
        electrons_per_s_per_pixel: receiver.electrons_per_s(mean),
        uniformity_without_ray_noise: ray.as_ref().map(|ray| ray.uniformity),
        against: None,
        findings: findings(scene, setup, receiver, &moments, solved),
    }
}

/// What the operator should know.
fn findings(scene: &Scene, setup: &Setup, receiver: &Receiver<'_>, moments: &Moments, solved: &Solved) -> Vec<String> {
    let mut findings = setup.findings.clone();
    if moments.max == 0.0 && moments.min == 0.0 {
        findings.push(match &solved.counts {
            Some(counts) => format!(
                "none of the {} rays reached the sensor: the map is empty, not dark",
                counts.rays
            ),
            None => "the distribution is zero in every direction of the sensor: the map is dark".to_owned(),
        });
    }
    if solved.counts.is_none() && solved.bound.of_allowed > 1.0 {
        findings.push(format!(
            "accuracy {}: the bound of a pixel's error is {:.1} times what is allowed",
            scene.accuracy.word(),
            solved.bound.of_allowed
        ));
    }
    findings.extend(receiver.finding.clone());
    findings
}
