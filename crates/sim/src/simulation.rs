//! One simulation of one scene: solver, effects, unit, and what the result is worth.

use isolux_model::optics::CameraSheet;
use isolux_model::{Precision, Scene, Spectral};
use rayon::prelude::*;
use serde::Serialize;

use crate::camera::Camera;
use crate::direct::{self, Counts, DirectError, Sampling};
use crate::inverse::{Bound, Number};
use crate::noise::{self, Interval};
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

/// `result.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// `inverse` or `direct`.
    pub method: &'static str,
    /// `traced`, `thinned`, `expected`; null for inverse.
    pub sampling: Option<&'static str>,
    /// Rays over the whole sphere.
    pub rays: Option<u64>,
    /// Seed.
    pub seed: Option<u64>,
    /// `W/m2` or `lx`.
    pub unit: &'static str,
    /// Mean over the sensor.
    pub mean: f64,
    /// Inverse: bound on the error of the quadrature; direct: standard error by ray counting.
    pub u_mean_numeric: f64,
    /// Number format of the inverse method, `f64` or `f32`; null for direct.
    pub precision: Option<&'static str>,
    /// What the error of no pixel exceeds; null for direct.
    pub pixel_error_bound: Option<PixelBound>,
    /// Standard uncertainty with what the model knows of its measurement; null if it knows nothing.
    pub u_mean: Option<f64>,
    /// Smallest pixel.
    pub min: f64,
    /// Largest pixel.
    pub max: f64,
    /// Standard deviation over the pixels, divided by n.
    pub std: f64,
    /// Smallest pixel over mean.
    pub uniformity_min_over_mean: f64,
    /// Rays that reached the sensor.
    pub rays_on_sensor: Option<u64>,
    /// Standard error of a mean pixel by ray counting, relative; from the upper limit of 3 rays where none arrived.
    pub relative_error_per_pixel: Option<f64>,
    /// Largest pixel that ray noise alone would give on the noise-free map.
    pub max_ray_noise: Option<Interval>,
    /// Largest pixel of the noise-free map.
    pub max_noise_free: Option<f64>,
    /// Effects of the model that the map contains.
    pub effects_applied: Vec<&'static str>,
    /// Effects of the model that belong elsewhere.
    pub effects_not_applicable: Vec<&'static str>,
    /// Seconds of the solver alone.
    pub elapsed_s: f64,
    /// Standard deviation without the part that ray counting adds.
    pub std_without_ray_noise: Option<f64>,
    /// Rays over the whole sphere that would bring a mean pixel to 1 %.
    pub rays_for_1_percent_per_pixel: Option<f64>,
    /// Pixels that no ray reached; each is known to be below 3.0 rays at 95 %.
    pub empty_pixels: Option<usize>,
    /// What one ray adds to a pixel.
    pub one_ray_in_a_pixel: Option<f64>,
    /// Flux of the luminaire, lm.
    pub flux_lm: f64,
    /// Luminous efficacy of radiation that links lx and W/m².
    pub ler_lm_per_w: Option<f64>,
    /// Pixels along x and y.
    pub pixels: [usize; 2],
    /// Width and height of the sensor, mm.
    pub size_mm: [f64; 2],
    /// Mean photon irradiance, 1/(m²·s), 360–830 nm; null without a spectrum.
    pub photon_irradiance_per_m2_s: Option<f64>,
    /// Mean illuminance, lx.
    pub illuminance_lx: f64,
    /// Mean irradiance in bands of 50 nm, W/m²; empty without a spectrum.
    pub bands: Vec<Band>,
    /// Mean electrons per second and pixel, with the scene's responsivity; null without one.
    pub electrons_per_s_per_pixel: Option<f64>,
    /// One exposure of the scene's camera; null without one.
    pub camera: Option<CameraFacts>,
    /// Colour over the sensor, where the scene has spectra over angle.
    pub colour: Option<ColourFacts>,
    /// Smallest pixel over mean without the part that ray counting adds: that of the noise-free map.
    pub uniformity_without_ray_noise: Option<f64>,
    /// The verdict beside an earlier simulation, where one was given.
    pub against: Option<Against>,
    /// What the operator should know.
    pub findings: Vec<String>,
}

/// Bounds on the error of the inverse method that hold in every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelBound {
    /// In the map's unit.
    pub absolute: f64,
    /// Relative to the pixel itself.
    pub relative: f64,
}

/// Whether a simulation differs from an earlier one by more than their noise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Against {
    /// Where the earlier one lies.
    pub folder: String,
    /// Its mean.
    pub mean: f64,
    /// This mean less that.
    pub difference: f64,
    /// Standard uncertainty of the difference, by quadrature and counted rays.
    pub u_difference: f64,
    /// Difference over its uncertainty.
    pub sigma: f64,
    /// Probability of such a difference or a larger one without any real one.
    pub p_value: f64,
    /// Whether that probability is below 1 %.
    pub differs: bool,
    /// Whether both drew the same random numbers: they are not independent then, and the probability does not hold.
    pub same_rays: bool,
}

/// What one exposure holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CameraFacts {
    /// Mean electrons of a pixel, dark current included, full well applied.
    pub mean_electrons: f64,
    /// Mean digital number.
    pub mean_dn: f64,
    /// Pixels whose expected electrons fill the well.
    pub full_well_pixels: usize,
    /// Pixels at the converter's last number.
    pub clipped_pixels: usize,
    /// Mean signal over its noise in one pixel: read noise, shot noise, fixed patterns, quantisation (EMVA 1288).
    pub signal_to_noise: Option<f64>,
    /// Seed of the exposure.
    pub seed: u64,
}

/// Colour over the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColourFacts {
    /// The middle.
    pub centre: ColourAt,
    /// The corner that differs most.
    pub corner: ColourAt,
    /// Their distance in u′v′.
    pub delta_u_prime_v_prime: f64,
}

/// Colour of the light in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ColourAt {
    /// Where.
    pub gamma_deg: f64,
    /// Correlated colour temperature, where it is defined.
    pub cct_k: Option<f64>,
    /// CIE 1976.
    pub u_prime: f64,
    /// CIE 1976.
    pub v_prime: f64,
}

/// Irradiance within a band of wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Band {
    /// First wavelength.
    pub from_nm: f64,
    /// First wavelength beyond.
    pub to_nm: f64,
    /// Mean over the sensor.
    pub irradiance_w_m2: f64,
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
    let noise_free = |setup: &Setup| filled::<f64>(setup, per_unit);
    let (map, bound, counts) = match (method, scene.precision) {
        (Method::Inverse, Precision::F64) => {
            let (map, bound) = noise_free(&setup);
            (Computed::Wide(map), bound, None)
        }
        (Method::Inverse, Precision::F32) => {
            let (map, bound) = filled::<f32>(&setup, per_unit);
            (Computed::Single(map), bound, None)
        }
        (Method::Direct { sampling, rays, seed }, _) => {
            let (source, sensor) = (&setup.source, &setup.sensor);
            let counts = match sampling {
                Sampling::Traced => direct::traced(source, sensor, rays, seed)?,
                Sampling::Thinned => direct::thinned(source, sensor, rays, seed)?,
                Sampling::Expected => {
                    let expected = inverse::solve(source, sensor).illuminance_lx;
                    direct::expected(source, sensor, &expected, rays, seed)?
                }
            };
            let mut map = counts.illuminance_lx();
            finish(&setup, &mut map, per_unit);
            (Computed::Wide(map), Bound::default(), Some(counts))
        }
    };
    let elapsed_s = now() - started;
    let map = match map {
        Computed::Wide(map) => map,
        Computed::Single(map) => map.into_iter().map(f64::from).collect(),
    };
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
        .map(|counts| Rays::of(counts, &setup, &noise_free(&setup).0, per_unit));
    let u_mean_numeric = ray.as_ref().map_or(bound.mean_lx, |ray| {
        moments.mean.abs().max(ray.value / setup.sensor.pixels() as f64) * ray.relative_of_mean
    });
    let known = scene.model.uncertainty().map(|u| {
        let of = |share: Option<f64>| share.unwrap_or(0.0) * moments.mean;
        let level = u.intensity_rel.or(u.flux_rel);
        let efficacy = if setup.ler_lm_per_w.is_some() {
            of(u.ler_rel)
        } else {
            0.0
        };
        (u_mean_numeric.powi(2) + of(level).powi(2) + efficacy.powi(2)).sqrt()
    });
    if counts.is_some() && scene.precision == Precision::F32 {
        findings.push("precision = \"f32\" is the inverse method's; rays are counted whole".to_owned());
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
        precision: rays.is_none().then(|| scene.precision.word()),
        pixel_error_bound: rays.is_none().then_some(PixelBound {
            absolute: bound.largest_lx,
            relative: bound.largest,
        }),
        u_mean: known,
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
    let map = map.into_iter().map(|value| value as f32).collect();
    Ok(Simulation {
        map,
        signal_dn: exposure.map(|exposure| exposure.signal_dn),
        counts,
        facts,
        setup,
    })
}

/// One exposure of the scene's camera.
struct Exposure {
    signal_dn: Vec<u16>,
    facts: CameraFacts,
}

impl Exposure {
    /// `photons` per (m²·s) and unit of the map, weighted by the quantum efficiency.
    fn of(sheet: &CameraSheet, map: &[f64], photons: f64, pixel_m2: f64) -> Self {
        let camera = Camera {
            exposure_s: sheet.exposure_s,
            dark_electrons_per_s: sheet.dark_electrons_per_s,
            read_noise_electrons: sheet.read_noise_electrons,
            dsnu_electrons: sheet.dsnu_electrons,
            prnu_rel: sheet.prnu_rel,
            full_well_electrons: sheet.full_well_electrons,
            gain_dn_per_electron: sheet.gain_dn_per_electron,
            offset_dn: sheet.offset_dn,
            bits: sheet.bits,
        };
        let light: Vec<f64> = map.iter().map(|value| value.max(0.0) * photons).collect();
        let top = (1_u32 << sheet.bits.min(16)) - 1;
        // Pixels differ from camera to camera, not from exposure to exposure: one camera, seed 1.
        let signal_dn: Vec<u16> = camera
            .expose(&light, pixel_m2, 1, sheet.seed)
            .into_iter()
            .map(|dn| dn as u16)
            .collect();
        let n = map.len() as f64;
        let mean_electrons = noise::sum(light.iter().map(|photons| camera.electrons(*photons, pixel_m2))) / n;
        let caught = noise::sum(
            light
                .iter()
                .map(|photons| (photons * pixel_m2 * sheet.exposure_s).min(sheet.full_well_electrons)),
        ) / n;
        let full = light
            .iter()
            .filter(|photons| camera.electrons(**photons, pixel_m2) >= sheet.full_well_electrons)
            .count();
        let variance = sheet.read_noise_electrons.powi(2)
            + mean_electrons
            + (sheet.prnu_rel * caught).powi(2)
            + sheet.dsnu_electrons.powi(2)
            + (12.0 * sheet.gain_dn_per_electron.powi(2)).recip();
        Self {
            facts: CameraFacts {
                mean_electrons,
                mean_dn: noise::sum(signal_dn.iter().map(|dn| f64::from(*dn))) / n,
                full_well_pixels: full,
                clipped_pixels: signal_dn.iter().filter(|dn| u32::from(**dn) == top).count(),
                signal_to_noise: (variance > 0.0).then(|| caught / variance.sqrt()),
                seed: sheet.seed,
            },
            signal_dn,
        }
    }
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

/// A map as its solver left it.
enum Computed {
    Wide(Vec<f64>),
    Single(Vec<f32>),
}

/// The finished map of the inverse method, and its bound in the map's unit.
fn filled<N: Number>(setup: &Setup, per_unit: f64) -> (Vec<N>, Bound) {
    let mut map = vec![N::default(); setup.sensor.pixels()];
    let bound = inverse::solve_into(&setup.source, &setup.sensor, &mut map);
    finish(setup, &mut map, per_unit);
    let factors = setup.pixel_factor.iter().flatten();
    let strongest = if setup.pixel_factor.is_some() {
        factors.fold(0.0_f64, |most, factor| most.max(factor.abs()))
    } else {
        1.0
    };
    (map, bound.scaled((setup.lamp * per_unit * strongest).abs()))
}

/// Lamp, sensor effects, blur, background and unit: everything after the solver, the same for both methods.
fn finish<N: Number>(setup: &Setup, map: &mut Vec<N>, per_unit: f64) {
    const RUN: usize = 1 << 14;
    map.par_chunks_mut(RUN).enumerate().for_each(|(run, values)| {
        let factors = setup.pixel_factor.as_ref().map(|factors| &factors[run * RUN..]);
        for (index, value) in values.iter_mut().enumerate() {
            let lit = value.wide() * setup.lamp * factors.map_or(1.0, |factors| factors[index]);
            *value = N::of((lit + setup.background_lx) * per_unit);
        }
    });
    if setup.blur_px > 0.0 {
        let wide: Vec<f64> = map.iter().map(|value| value.wide()).collect();
        let spread = blur::gaussian(&wide, setup.sensor.nx, setup.sensor.ny, setup.blur_px);
        *map = spread.into_iter().map(N::of).collect();
    }
}

/// What counting rays does to the result.
struct Rays {
    value: f64,
    relative_of_mean: f64,
    relative_per_pixel: f64,
    maximum: Interval,
    max_noise_free: f64,
    uniformity: f64,
    needed: f64,
}

impl Rays {
    fn of(counts: &Counts, setup: &Setup, noise_free: &[f64], per_unit: f64) -> Self {
        let pixels = setup.sensor.pixels();
        let value = counts.lux_per_ray() * setup.lamp * per_unit;
        let background = setup.background_lx * per_unit;
        let expected: Vec<f64> = noise_free
            .iter()
            .map(|light| ((light - background) / value).max(0.0))
            .collect();
        let law = noise::largest_count(&expected);
        let scaled = |count: f64| count * value + background;
        // Where no ray arrived, the upper limit of three rays at 95 % stands in for the mean.
        let caught = counts.on_sensor() as f64;
        let known = if caught > 0.0 { caught } else { noise::upper_limit_95(0) };
        let share = noise::sum(expected.iter().copied()) / counts.rays as f64;
        Self {
            value,
            relative_of_mean: if caught > 0.0 { caught.sqrt().recip() } else { known },
            relative_per_pixel: (known / pixels as f64).sqrt().recip(),
            maximum: Interval {
                median: scaled(law.median),
                lo95: scaled(law.lo95),
                hi95: scaled(law.hi95),
            },
            max_noise_free: noise_free.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            uniformity: noise::moments(noise_free)
                .filter(|light| light.mean != 0.0)
                .map_or(0.0, |light| light.min / light.mean),
            needed: noise::rays_needed(0.01, share, pixels),
        }
    }
}
