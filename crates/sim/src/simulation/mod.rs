//! One simulation of one scene: solver, effects, unit, and what the result is worth.

mod exposure;
mod facts;
mod rays;
mod worth;

use isolux_model::{Accuracy, Scene, Spectral};
use rayon::prelude::*;

use self::exposure::Exposure;
pub use self::facts::{AccuracyFacts, Against, Band, CameraFacts, ColourAt, ColourFacts, Facts, PixelBound};
use self::rays::Rays;
use self::worth::Worth;
use crate::direct::{self, Counts, DirectError, Sampling};
use crate::inverse::Bound;
use crate::noise;
use crate::setup::{Setup, SetupError};
use crate::{blur, camera, inverse, station};

/// How the light is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Quadrature, no noise.
    Inverse,
    /// Rays.
    Direct {
        /// Which of the equal laws.
        sampling: Sampling,
        /// Rays over the whole sphere.
        rays: u64,
        /// Seed of every random number.
        seed: u64,
    },
}

/// Why a simulation fails.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The scene.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The rays.
    #[error(transparent)]
    Direct(#[from] DirectError),
    /// The camera's responsivity.
    #[error("sensor.responsivity: {message}")]
    Responsivity {
        /// What is wrong, with file and line.
        message: String,
    },
}

/// A map and what it is worth.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// Mean of each pixel, `[iy * nx + ix]`, in [`Facts::unit`].
    pub map: Vec<f32>,
    /// Digital numbers of one exposure, where the scene has a camera.
    pub signal_dn: Option<Vec<u16>>,
    /// Rays of each pixel, direct only.
    pub counts: Option<Counts>,
    /// The facts of `result.json`.
    pub facts: Facts,
    /// The scene as it was solved.
    pub setup: Setup,
}

/// Simulates `scene` with `method`. `now` is the caller's clock in seconds, read round the solver.
///
/// # Errors
/// [`SimulationError`] for an impossible scene or impossible rays.
pub fn simulate(scene: &Scene, method: Method, now: &dyn Fn() -> f64) -> Result<Simulation, SimulationError> {
    let setup = Setup::new(scene)?;
    let started = now();
    let per_unit = setup.ler_lm_per_w.unwrap_or(1.0).recip();
    let mut findings = setup.findings.clone();
    let noise_free = |accuracy| noise_free(&setup, accuracy, per_unit);
    let (map, bound, counts) = match method {
        Method::Inverse => {
            let (map, bound) = noise_free(scene.accuracy);
            (map, bound, None)
        }
        Method::Direct { sampling, rays, seed } => {
            let (source, sensor) = (&setup.source, &setup.sensor);
            let counts = match sampling {
                Sampling::Traced => direct::traced(source, sensor, rays, seed)?,
                Sampling::Thinned => direct::thinned(source, sensor, rays, seed)?,
                Sampling::Expected => {
                    let expected = inverse::solve(source, sensor, Accuracy::Standard).illuminance_lx;
                    direct::expected(source, sensor, &expected, rays, seed)?
                }
            };
            let mut map = counts.illuminance_lx();
            finish(&setup, &mut map, per_unit);
            (map, Bound::default(), Some(counts))
        }
    };
    let elapsed_s = now() - started;
    // A map has at least one pixel.
    let moments = noise::moments(&map).unwrap_or(noise::Moments {
        mean: 0.0,
        min: 0.0,
        max: 0.0,
        std: 0.0,
    });
    if moments.max == 0.0 && moments.min == 0.0 {
        findings.push(match &counts {
            Some(counts) => format!(
                "none of the {} rays reached the sensor: the map is empty, not dark",
                counts.rays
            ),
            None => "the distribution is zero in every direction of the sensor: the map is dark".to_owned(),
        });
    }
    let ray = counts
        .as_ref()
        .map(|counts| Rays::of(counts, &setup, noise_free(Accuracy::Standard).0, per_unit));
    let u_mean_numeric = ray.as_ref().map_or(bound.mean_lx, |ray| {
        moments.mean.abs().max(ray.value / setup.sensor.pixels() as f64) * ray.relative_of_mean
    });
    let distance_mm = scene.model.placement(scene.sensor.pose).pose.centre_mm().length();
    let worth = Worth::of(
        scene,
        moments.mean,
        u_mean_numeric,
        setup.ler_lm_per_w.is_some(),
        distance_mm,
    );
    if counts.is_none() && bound.of_allowed > 1.0 {
        findings.push(format!(
            "accuracy {}: the bound of a pixel's error is {:.1} times what is allowed",
            scene.accuracy.word(),
            bound.of_allowed
        ));
    }
    let effects = scene.model.in_simulation();
    let (sampling, rays, seed) = match method {
        Method::Inverse => (None, None, None),
        Method::Direct { sampling, rays, seed } => (Some(sampling.word()), Some(rays), Some(seed)),
    };
    let lamp = match scene.model.luminaire().spectral() {
        Spectral::Spectrum(spectrum) => Some(spectrum),
        _ => None,
    };
    // What arrives: the lamp's spectrum behind all that stands before the sensor.
    let arriving = setup
        .station
        .as_ref()
        .and_then(|station| station.spectrum_at_centre(&setup.sensor));
    let spectrum = arriving.as_ref().or(lamp);
    let efficacy = match spectrum {
        Some(spectrum) => spectrum.ler_lm_per_w().map(isolux_units::LumenPerWatt::value),
        None => setup.ler_lm_per_w,
    };
    let bands = spectrum.map_or_else(Vec::new, |spectrum| {
        (0..10)
            .filter_map(|k| {
                let (from_nm, to_nm) = (350.0 + 50.0 * f64::from(k), 400.0 + 50.0 * f64::from(k));
                let irradiance_w_m2 = camera::band_irradiance(moments.mean, spectrum, from_nm, to_nm)?;
                Some(Band {
                    from_nm,
                    to_nm,
                    irradiance_w_m2,
                })
            })
            .collect()
    });
    // In the image of a lens a pixel is as much smaller as the image.
    let magnification = scene.optics.lens.map_or(1.0, |lens| station::magnification(&lens));
    let pixel_m2 = setup.sensor.pixel_area_m2() * magnification * magnification;
    let mut per_unit_photons = None;
    let electrons = match (spectrum, &scene.sensor.responsivity) {
        (Some(spectrum), Some(path)) => {
            let curve = isolux_model::read_spectrum(path).map_err(|error| SimulationError::Responsivity {
                message: error.to_string(),
            })?;
            per_unit_photons = camera::photon_irradiance(1.0, spectrum, |nm| curve.at_nm(nm));
            per_unit_photons.map(|photons| photons * moments.mean * pixel_m2)
        }
        (None, Some(_)) => {
            findings.push("responsivity needs the model's spectrum; electrons are not computed".to_owned());
            None
        }
        _ => None,
    };
    let exposure = scene
        .optics
        .camera
        .as_ref()
        .zip(per_unit_photons)
        .map(|(sheet, photons)| Exposure::of(sheet, &map, photons, pixel_m2));
    if scene.optics.camera.is_some() && exposure.is_none() {
        return Err(SimulationError::Responsivity {
            message: "sensor.camera needs the model's spectrum, to count electrons".to_owned(),
        });
    }
    let facts = Facts {
        method: if rays.is_some() { "direct" } else { "inverse" },
        sampling,
        rays,
        seed,
        unit: if setup.ler_lm_per_w.is_some() { "W/m2" } else { "lx" },
        mean: moments.mean,
        u_mean_numeric,
        accuracy: rays.is_none().then(|| AccuracyFacts::of(scene.accuracy, &bound)),
        pixel_error_bound: rays.is_none().then_some(PixelBound {
            absolute: bound.largest_lx,
            relative: bound.largest,
        }),
        u_mean: worth.u,
        u_mean_missing: worth.missing,
        min: moments.min,
        max: moments.max,
        std: moments.std,
        uniformity_min_over_mean: if moments.mean == 0.0 {
            0.0
        } else {
            moments.min / moments.mean
        },
        rays_on_sensor: counts.as_ref().map(Counts::on_sensor),
        relative_error_per_pixel: ray.as_ref().map(|ray| ray.relative_per_pixel),
        max_ray_noise: ray.as_ref().map(|ray| ray.maximum),
        max_noise_free: ray.as_ref().map(|ray| ray.max_noise_free),
        effects_applied: effects.applied,
        effects_not_applicable: effects.not_applicable,
        elapsed_s,
        std_without_ray_noise: ray.as_ref().map(|ray| noise::std_without_noise(&moments, ray.value)),
        rays_for_1_percent_per_pixel: ray.as_ref().map(|ray| ray.needed),
        empty_pixels: counts
            .as_ref()
            .map(|counts| counts.count.iter().filter(|count| **count == 0).count()),
        one_ray_in_a_pixel: ray.as_ref().map(|ray| ray.value),
        flux_lm: scene
            .model
            .distribution()
            .map_or(f64::NAN, |distribution| distribution.flux().value()),
        ler_lm_per_w: setup.ler_lm_per_w,
        pixels: scene.sensor.pixels,
        size_mm: scene.sensor.size_mm,
        photon_irradiance_per_m2_s: spectrum
            .and_then(|spectrum| camera::photon_irradiance(moments.mean, spectrum, |_| 1.0)),
        illuminance_lx: moments.mean * efficacy.filter(|_| setup.ler_lm_per_w.is_some()).unwrap_or(1.0),
        camera: exposure.as_ref().map(|exposure| exposure.facts),
        colour: colour(scene, &setup),
        bands,
        electrons_per_s_per_pixel: electrons,
        uniformity_without_ray_noise: ray.as_ref().map(|ray| ray.uniformity),
        against: None,
        findings,
    };
    let map = map.par_iter().map(|value| *value as f32).collect();
    Ok(Simulation {
        map,
        signal_dn: exposure.map(|exposure| exposure.signal_dn),
        counts,
        facts,
        setup,
    })
}

/// Colour at the middle and at the corner that differs most, where the scene has spectra over angle.
fn colour(scene: &Scene, setup: &Setup) -> Option<ColourFacts> {
    let station = setup.station.as_ref().filter(|_| !scene.optics.colour.is_empty())?;
    let (nx, ny) = (setup.sensor.nx as f64, setup.sensor.ny as f64);
    let at = |x: f64, y: f64| {
        let gamma_deg = station::gamma_deg(setup.sensor.point(x, y));
        let of = isolux_spectrum::quantities(&station.colour_at(gamma_deg)?);
        Some(ColourAt {
            gamma_deg,
            cct_k: of.cct_k,
            u_prime: of.u_prime?,
            v_prime: of.v_prime?,
        })
    };
    let centre = at(0.5 * nx, 0.5 * ny)?;
    let apart = |other: &ColourAt| (other.u_prime - centre.u_prime).hypot(other.v_prime - centre.v_prime);
    let corner = [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]]
        .into_iter()
        .filter_map(|[x, y]| at(x, y))
        .max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    Some(ColourFacts {
        delta_u_prime_v_prime: apart(&corner),
        centre,
        corner,
    })
}

/// The finished map of the inverse method, and its bound in the map's unit.
fn noise_free(setup: &Setup, accuracy: Accuracy, per_unit: f64) -> (Vec<f64>, Bound) {
    let mut map = vec![0.0; setup.sensor.pixels()];
    let bound = inverse::solve_into(&setup.source, &setup.sensor, accuracy, &mut map);
    finish(setup, &mut map, per_unit);
    let strongest = setup.pixel_factor.as_ref().map_or(1.0, |factors| {
        factors.iter().fold(0.0_f64, |most, factor| most.max(factor.abs()))
    });
    (map, bound.scaled((setup.lamp * per_unit * strongest).abs()))
}

/// Lamp, sensor effects, blur, background and unit: everything after the solver, the same for both methods.
fn finish(setup: &Setup, map: &mut Vec<f64>, per_unit: f64) {
    const RUN: usize = 1 << 14;
    map.par_chunks_mut(RUN).enumerate().for_each(|(run, values)| {
        let factors = setup.pixel_factor.as_ref().map(|factors| &factors[run * RUN..]);
        for (index, value) in values.iter_mut().enumerate() {
            let lit = *value * setup.lamp * factors.map_or(1.0, |factors| factors[index]);
            *value = (lit + setup.background_lx) * per_unit;
        }
    });
    if setup.blur_px > 0.0 {
        *map = blur::gaussian(map, setup.sensor.nx, setup.sensor.ny, setup.blur_px);
    }
}
