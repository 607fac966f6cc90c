//! The sensor of a run in another pose, with other pixels and another exposure: quick enough for a slider.

use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::{Model, Scene};
use isolux_report::sensor;
use isolux_report::viewer::explorer::Explored;
use isolux_sim::direct::Sampling;
use isolux_sim::simulation::{Facts, Method, Simulation};
use isolux_units::digits::{significant, stated};
use serde::{Deserialize, Serialize};

use super::{StatedNumber, diagnosed, reduced_model};
use crate::Failure;
use crate::simulation::{scene, simulate};

/// Pixels of the map along its longer edge.
const PIXELS: usize = 48;
/// Significant digits of a pixel: differences between two poses are taken of them.
const DIGITS: usize = 5;

/// What is asked; what is left out is as in the scene of the run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Variation {
    /// Distance of the sensor in mm.
    pub distance_mm: Option<f64>,
    /// Tilt about the sensor's x axis in degrees.
    pub tilt_x_deg: Option<f64>,
    /// Pitch of the pixels in µm; their number stays, so the sensor grows with it.
    pub pitch_um: Option<f64>,
    /// Exposure time in s.
    pub exposure_s: Option<f64>,
}

/// The light on the sensor there.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorLight {
    /// The pose and pixels that were lit.
    pub requested: Stand,
    /// `W/m²`, or `lx` without a spectrum.
    pub unit: &'static str,
    /// Edges of the sensor in mm.
    pub size_mm: [f64; 2],
    /// Means of blocks of pixels.
    pub map: Explored,
    /// The mean in `unit`.
    pub mean: f64,
    /// The numbers.
    pub numbers: Vec<StatedNumber>,
    /// What was lit, by which model.
    pub by: String,
    /// What a person should know.
    pub findings: Vec<String>,
    /// Time of the solver in ms.
    pub solver_ms: f64,
}

/// Where the sensor stands, every value known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stand {
    /// Distance in mm.
    pub distance_mm: f64,
    /// Tilt in degrees.
    pub tilt_x_deg: f64,
    /// Pitch in µm.
    pub pitch_um: f64,
    /// Exposure in s.
    pub exposure_s: f64,
}

/// The scene of a run, and what it is lit by.
struct Base {
    scene: Scene,
    by: String,
    /// Pixels of the scene itself, along x and y.
    pixels: [usize; 2],
}

/// Exposure where the scene names no camera, in s.
const EXPOSURE_S: f64 = 0.01;

/// Files that a scene is made of, with the time of their last change: another one makes another scene.
type Stamp = Vec<(Utf8PathBuf, Option<SystemTime>)>;

/// What is kept from one question to the next.
struct Kept {
    stamp: Stamp,
    base: Base,
    /// The last pose that was solved, the exposure left out, and its light.
    solved: Option<(Stand, Simulation)>,
}

/// Sensors in other poses: while sliders move, the model stays loaded, and a map is solved once a pose.
#[derive(Default)]
pub struct WhatIf {
    kept: Mutex<Option<Kept>>,
}

impl WhatIf {
    /// The sensor of the run directory `run` as asked.
    ///
    /// # Errors
    /// Bad input (exit 2) for a run without a model, a value out of its range, or a pose that cannot be lit.
    pub fn illuminated(&self, run: &Utf8Path, requested: &Variation) -> Result<SensorLight, Failure> {
        // One answer at a time: what is kept is whole, whatever a thread before did.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let stamp = stamp(run);
        let Kept { base, solved, .. } = match kept.take() {
            Some(same) if same.stamp == stamp => kept.insert(same),
            _ => kept.insert(Kept {
                stamp,
                base: Base::of(run)?,
                solved: None,
            }),
        };
        let (scene, stand) = base.posed(requested)?;
        let pose = Stand {
            exposure_s: 0.0,
            ..stand
        };
        let solved = match solved.take() {
            Some(same) if same.0 == pose => solved.insert(same),
            _ => solved.insert((pose, simulate::solve(&scene, Method::Inverse)?)),
        };
        let pixel = simulate::solve(&base.pixel(&scene, &stand), Method::Inverse)?;
        Ok(described(&solved.1, &pixel.facts, stand, &base.by))
    }
}

fn stamp(run: &Utf8Path) -> Stamp {
    [lit_by(run), own_scene(run)]
        .map(|file| {
            let changed = file.metadata().and_then(|facts| facts.modified()).ok();
            (file, changed)
        })
        .into()
}

fn own_scene(run: &Utf8Path) -> Utf8PathBuf {
    run.join("job/scene.toml")
}

impl Base {
    fn of(run: &Utf8Path) -> Result<Self, Failure> {
        let file = lit_by(run);
        if !file.is_file() {
            return Err(Failure::bad_input(format!("{run} has no model yet"))
                .help("it is made when the run is reduced: isolux reduce RUN, or at the end of the day"));
        }
        let model = Model::load(&file).map_err(Failure::bad_input)?;
        let own = own_scene(run);
        let (scene, sensor) = if own.is_file() {
            (scene::lit_by(&own, &model)?, "the sensor of the job's scene")
        } else {
            (
                scene::of_the_published_case(&model)?,
                "the sensor of the published case, because the run names none",
            )
        };
        let pixels = scene.sensor.pixels;
        let name = file.file_name().unwrap_or_default().to_owned();
        let by = format!("{sensor}, lit by {name}");
        Ok(Self { scene, by, pixels })
    }

    /// The scene as asked, with few pixels.
    fn posed(&self, requested: &Variation) -> Result<(Scene, Stand), Failure> {
        let mut scene = self.scene.clone();
        let sensor = &mut scene.sensor;
        let exposure_s = scene
            .optics
            .camera
            .as_ref()
            .map_or(EXPOSURE_S, |camera| camera.exposure_s);
        let stand = Stand {
            distance_mm: requested.distance_mm.unwrap_or(sensor.pose.distance_mm),
            tilt_x_deg: requested.tilt_x_deg.unwrap_or(sensor.pose.tilt_x_deg),
            pitch_um: requested
                .pitch_um
                .unwrap_or(1000.0 * sensor.size_mm[0] / self.pixels[0] as f64),
            exposure_s: requested.exposure_s.unwrap_or(exposure_s),
        };
        for (name, value, low, high) in [
            ("distance_mm", stand.distance_mm, 1.0, 1e6),
            ("tilt_x_deg", stand.tilt_x_deg, -89.0, 89.0),
            ("pitch_um", stand.pitch_um, 0.1, 1e4),
            ("exposure_s", stand.exposure_s, 1e-7, 1e4),
        ] {
            if !(low..=high).contains(&value) {
                return Err(Failure::bad_input(format!(
                    "{name} = {value} is not within {low} … {high}"
                )));
            }
        }
        sensor.pose.distance_mm = stand.distance_mm;
        sensor.pose.tilt_x_deg = stand.tilt_x_deg;
        if requested.pitch_um.is_some() {
            sensor.size_mm = self.pixels.map(|pixels| pixels as f64 * stand.pitch_um / 1000.0);
        }
        // The statistics of single pixels are those of one pixel of the true pitch, computed apart.
        scene.optics.camera = None;
        let longest = self.pixels[0].max(self.pixels[1]);
        if longest > PIXELS {
            sensor.pixels = self.pixels.map(|pixels| (pixels * PIXELS / longest).max(1));
        }
        Ok((scene, stand))
    }

    /// One pixel of the true pitch in the middle, with the scene's camera.
    fn pixel(&self, illuminated: &Scene, stand: &Stand) -> Scene {
        let mut scene = illuminated.clone();
        scene.sensor.pixels = [1, 1];
        scene.sensor.size_mm = [stand.pitch_um / 1000.0; 2];
        scene.optics.camera = self.scene.optics.camera;
        if let Some(camera) = &mut scene.optics.camera {
            camera.exposure_s = stand.exposure_s;
        }
        scene
    }
}

/// The newest model of a run: with the effects of its diagnosis, where they were added.
fn lit_by(run: &Utf8Path) -> Utf8PathBuf {
    diagnosed::added(run).unwrap_or_else(|| reduced_model(run))
}

fn described(solved: &Simulation, pixel: &Facts, stand: Stand, by: &str) -> SensorLight {
    let facts = &solved.facts;
    let unit = facts.unit.symbol();
    SensorLight {
        requested: stand,
        unit,
        size_mm: facts.size_mm,
        mean: facts.mean,
        numbers: numbers(facts, pixel, &stand, unit),
        by: by.to_owned(),
        findings: facts.findings.clone(),
        solver_ms: [facts, pixel]
            .map(|one| 1000.0 * one.elapsed_s.unwrap_or_default())
            .iter()
            .sum(),
        map: Explored::of(&sensor::picture(solved), DIGITS),
    }
}

fn numbers(facts: &Facts, pixel: &Facts, stand: &Stand, unit: &str) -> Vec<StatedNumber> {
    let number = |name: &str, value: String| StatedNumber {
        name: name.to_owned(),
        value,
        reported: None,
    };
    let dose_unit = if unit == "lx" { "lx·s" } else { "J/m²" };
    let dose = stand.exposure_s * facts.mean;
    let mut numbers = vec![
        number("mean", simulate::mean(facts)),
        number("smallest ÷ mean", format!("{:.4}", facts.uniformity_min_over_mean)),
        number(
            "exposure",
            facts.u_mean.map_or_else(
                || format!("{} {dose_unit}, no uncertainty", significant(dose, 5)),
                |u| stated(dose, stand.exposure_s * u, dose_unit),
            ),
        ),
    ];
    // The number of photons is as uncertain as the irradiance that they are counted from.
    if let Some(photons) = pixel.photon_irradiance_per_m2_s {
        let area_m2 = (stand.pitch_um * 1e-6).powi(2);
        let count = photons * area_m2 * stand.exposure_s;
        let u_rel = facts.u_mean.map(|u| u / facts.mean);
        numbers.push(number(
            "photons a pixel, middle",
            u_rel.map_or_else(
                || format!("{}, no uncertainty", significant(count, 4)),
                |u_rel| stated(count, count * u_rel, "").replace("  ", " "),
            ),
        ));
    }
    if let Some(camera) = &pixel.camera {
        numbers.push(number(
            "signal of the middle pixel",
            format!(
                "{} electrons, {} DN",
                significant(camera.mean_electrons, 4),
                significant(camera.mean_dn, 4)
            ),
        ));
        if let Some(ratio) = camera.signal_to_noise {
            numbers.push(number("signal to noise, middle pixel", significant(ratio, 3)));
        }
    }
    numbers
}

/// What a number of rays would say of the same sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Convergence {
    /// `W/m²` or `lx`.
    pub unit: &'static str,
    /// Pixels of the map.
    pub pixels: [usize; 2],
    /// Mean and largest pixel without ray noise.
    pub noise_free: [f64; 2],
    /// By the number of rays, rising.
    pub rays: Vec<Rays>,
}

/// One number of rays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rays {
    /// Rays over the whole sphere.
    pub rays: f64,
    /// The mean.
    pub mean: f64,
    /// Its standard error by ray counting.
    pub standard_error: f64,
    /// The largest pixel.
    pub largest: f64,
}

/// Counted rays against the noise-free solution for the sensor as asked. The counts are drawn from their expectation
/// (`expected`), so that the cost does not grow with the rays.
///
/// # Errors
/// As [`WhatIf::illuminated`].
pub fn convergence(run: &Utf8Path, requested: &Variation) -> Result<Convergence, Failure> {
    let (scene, _) = Base::of(run)?.posed(requested)?;
    let exact = simulate::solve(&scene, Method::Inverse)?.facts;
    let rays = (5..=12).map(|exponent| {
        let method = Method::Direct {
            sampling: Sampling::Expected,
            rays: 10_u64.pow(exponent),
            seed: 1,
        };
        let facts = simulate::solve(&scene, method)?.facts;
        Ok(Rays {
            rays: 10_f64.powi(exponent.cast_signed()),
            mean: facts.mean,
            standard_error: facts.u_mean_numeric,
            largest: facts.max,
        })
    });
    Ok(Convergence {
        unit: exact.unit.symbol(),
        pixels: exact.pixels,
        noise_free: [exact.mean, exact.max],
        rays: rays.collect::<Result<_, Failure>>()?,
    })
}
