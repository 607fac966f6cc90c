//! Direct against inverse, and the three samplings against each other.

use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;
use isolux_sim::direct::{self, Counts, DirectError, Sampling};
use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::sensor::{Pose, Sensor};
use isolux_sim::source::{LightSource, Shape};
use isolux_sim::table::IntensityTable;
use isolux_sim::{emission::Emission, noise};

fn lobe() -> IntensityDistribution {
    let c_deg: Vec<f64> = (0..8).map(|k| 45.0 * f64::from(k)).collect();
    let gamma_deg = vec![0.0, 4.0, 9.0, 15.0, 30.0, 60.0, 90.0, 180.0];
    let intensity_cd = c_deg
        .iter()
        .flat_map(|c: &f64| {
            gamma_deg.iter().map(|g: &f64| {
                20.0 + 900.0 * (-(g / 14.0).powi(2)).exp() * (1.0 + 0.5 * (g / 15.0).min(1.0) * c.to_radians().cos())
            })
        })
        .collect();
    IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
}

fn scene() -> (LightSource, Sensor) {
    let source = LightSource::single(
        Arc::new(IntensityTable::new(&lobe())),
        Shape::Disc {
            centre: DVec3::ZERO,
            radius: 3.0,
        },
    );
    let sensor = Sensor::new(&Pose {
        size_mm: [60.0, 40.0],
        pixels: [9, 6],
        distance_mm: 80.0,
        tilt_x_deg: 15.0,
        tilt_y_deg: -20.0,
        rot_z_deg: 30.0,
        offset_mm: [10.0, 5.0],
    })
    .unwrap();
    (source, sensor)
}

fn run(sampling: Sampling, rays: u64, seed: u64, inverse_lx: &[f64]) -> Counts {
    let (source, sensor) = scene();
    match sampling {
        Sampling::Traced => direct::traced(&source, &sensor, rays, seed),
        Sampling::Thinned => direct::thinned(&source, &sensor, rays, seed),
        Sampling::Expected => direct::expected(&source, &sensor, inverse_lx, rays, seed),
    }
    .unwrap()
}

#[test]
fn the_emission_holds_the_whole_flux() {
    let (source, sensor) = scene();
    let flux = lobe().flux_lm();
    let emission = Emission::new(&source, &sensor);
    assert!(
        (emission.flux_lm() / flux - 1.0).abs() < 1e-12,
        "{} {flux}",
        emission.flux_lm()
    );
    assert!(emission.cone() < 0.5, "the cone {} is hardly one", emission.cone());
}

#[test]
fn every_sampling_agrees_with_inverse_pixel_by_pixel() {
    let (source, sensor) = scene();
    let map = inverse::solve(&source, &sensor, Accuracy::Reference).illuminance_lx;
    for sampling in [Sampling::Traced, Sampling::Thinned, Sampling::Expected] {
        // χ² over pixels and seeds: counts of all seeds against their expectation.
        let (seeds, rays) = (8, 400_000);
        let (mut chi, mut degrees) = (0.0, 0.0);
        for seed in 0..seeds {
            let counts = run(sampling, rays, seed, &map);
            for (count, lux) in counts.count.iter().zip(&map) {
                let expected = lux / counts.lux_per_ray();
                chi += (*count as f64 - expected).powi(2) / expected;
                degrees += 1.0_f64;
            }
        }
        let sigma = (chi - degrees) / (2.0 * degrees).sqrt();
        assert!(sigma.abs() < 4.0, "{sampling:?}: χ² {chi} over {degrees}");
        // A small bias over the whole map would hide in χ²: compare the total with many rays.
        let counts = run(sampling, 10_000_000, 5, &map);
        let expected: f64 = noise::sum(map.iter().map(|lux| lux / counts.lux_per_ray()));
        let off = (counts.on_sensor() as f64 - expected) / expected.sqrt();
        assert!(
            off.abs() < 4.0,
            "{sampling:?}: {} rays, expected {expected}",
            counts.on_sensor()
        );
    }
}

#[test]
fn the_three_samplings_have_one_law() {
    let (source, sensor) = scene();
    let map = inverse::solve(&source, &sensor, Accuracy::Reference).illuminance_lx;
    let (seeds, rays) = (80_u64, 10_000);
    let statistics = |sampling| {
        let runs: Vec<(f64, f64)> = (0..seeds)
            .map(|seed| {
                let counts = run(sampling, rays, 1000 + seed, &map);
                (counts.on_sensor() as f64, *counts.count.iter().max().unwrap() as f64)
            })
            .collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| runs.iter().map(of).sum::<f64>() / seeds as f64;
        let total = mean(&|run| run.0);
        let variance = mean(&|run| (run.0 - total).powi(2));
        let top = mean(&|run| run.1);
        let spread = mean(&|run| (run.1 - top).powi(2)).sqrt();
        (total, variance, top, spread)
    };
    let reference = statistics(Sampling::Traced);
    for sampling in [Sampling::Thinned, Sampling::Expected] {
        let other = statistics(sampling);
        let u = (2.0 * reference.1 / seeds as f64).sqrt();
        assert!(
            (other.0 - reference.0).abs() < 4.0 * u,
            "{sampling:?} mean {other:?} {reference:?}"
        );
        // The ratio of two variances of n normal draws spreads by 2/√n.
        let ratio = (other.1 / reference.1).ln().abs();
        assert!(
            ratio < 4.0 * 2.0 / (seeds as f64).sqrt(),
            "{sampling:?} variance {other:?} {reference:?}"
        );
        let u = reference.3.hypot(other.3) / (seeds as f64).sqrt();
        assert!(
            (other.2 - reference.2).abs() < 4.0 * u,
            "{sampling:?} maximum {other:?} {reference:?}"
        );
    }
    // And the maximum obeys the extreme-value law of the expected counts.
    let unit = direct::expected(&source, &sensor, &map, rays, 1).unwrap().lux_per_ray();
    let law = noise::largest_count(&map.iter().map(|lux| lux / unit).collect::<Vec<_>>());
    assert!((law.lo95..=law.hi95).contains(&reference.2), "{law:?} {reference:?}");
}

#[test]
fn results_do_not_depend_on_threads() {
    let (source, sensor) = scene();
    let map = inverse::solve(&source, &sensor, Accuracy::Reference).illuminance_lx;
    let with = |threads, sampling| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(sampling, 300_001, 3, &map))
    };
    for sampling in [Sampling::Traced, Sampling::Thinned, Sampling::Expected] {
        assert_eq!(with(1, sampling), with(3, sampling));
    }
}

#[test]
fn a_ring_and_leds_emit_as_they_are_integrated() {
    let table = Arc::new(IntensityTable::new(&lobe()));
    let (_, sensor) = scene();
    let ring = LightSource::single(
        Arc::clone(&table),
        Shape::Ring {
            centre: DVec3::ZERO,
            inner: 8.0,
            outer: 12.0,
        },
    );
    let aim = isolux_sim::sensor::rotation(0.0, 6.0, 0.0);
    let leds = LightSource::new(
        [(-12.0, Some(aim)), (12.0, None), (5.0, Some(aim.transpose()))]
            .into_iter()
            .map(|(x, aim)| isolux_sim::source::Part {
                share: 1.0 / 3.0,
                shape: Shape::Point(DVec3::new(x, 0.0, 0.0)),
                table: Arc::clone(&table),
                aim,
            })
            .collect(),
    );
    for source in [ring, leds] {
        let map = inverse::solve(&source, &sensor, Accuracy::Reference).illuminance_lx;
        let counts = direct::thinned(&source, &sensor, 4_000_000, 2).unwrap();
        let chi: f64 = counts
            .count
            .iter()
            .zip(&map)
            .map(|(count, lux)| {
                let expected = lux / counts.lux_per_ray();
                (*count as f64 - expected).powi(2) / expected
            })
            .sum();
        let degrees = map.len() as f64;
        assert!(chi < degrees + 4.5 * (2.0 * degrees).sqrt(), "χ² {chi} over {degrees}");
    }
}

#[test]
fn refuses_what_cannot_be_traced() {
    let (source, sensor) = scene();
    assert_eq!(direct::thinned(&source, &sensor, 0, 1), Err(DirectError::NoRays));
    let dark = IntensityDistribution::new(vec![0.0], vec![0.0, 90.0], vec![0.0, -1.0]).unwrap();
    let dark = LightSource::single(Arc::new(IntensityTable::new(&dark)), Shape::Point(DVec3::ZERO));
    assert!(matches!(
        direct::traced(&dark, &sensor, 10, 1),
        Err(DirectError::Dark { .. })
    ));
}
