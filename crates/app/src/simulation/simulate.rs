//! `simulate`: light a sensor, write the map and what it is worth.

use std::panic::resume_unwind;
use std::time::Instant;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::disk::Pending;
use isolux_report::sensor;
use isolux_sim::against;
use isolux_sim::array::Number;
use isolux_sim::direct::DirectError;
use isolux_sim::rays;
use isolux_sim::setup::SetupError;
use isolux_sim::simulation::{self, MapUnit, Simulation, SimulationError};

use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::simulation::scene::{self, Changes};
use crate::simulation::{array_files, memory};
use crate::{Failure, FailureKind};

pub use isolux_model::Accuracy;
pub use isolux_report::sensor::{mean, numeric};
pub use isolux_sim::direct::Sampling;
pub use isolux_sim::simulation::{Facts, Method};
pub use isolux_sim::stop::Stop;

/// A simulation with the map as the solver found it.
pub type Exact = Simulation<f64>;

/// What is simulated, how, and where the result goes.
#[derive(Debug, Clone)]
pub struct SimulateRequest {
    /// Scene or model file, run folder, or photometric file.
    pub input: Utf8PathBuf,
    /// Folder of the results.
    pub out: Utf8PathBuf,
    /// Whether results there may be replaced.
    pub overwrite: Overwrite,
    /// Inverse or direct.
    pub method: Method,
    /// Changes to the scene.
    pub changes: Changes,
    /// Rays that reach the sensor, written to a file: `.json`, or IES TM-25 by any other extension.
    pub rays_out: Option<(Utf8PathBuf, usize)>,
    /// Folder of an earlier simulation that this one is compared with.
    pub against: Option<Utf8PathBuf>,
    /// Also `irradiance.tiff`.
    pub tiff: bool,
    /// Also `irradiance.csv`.
    pub csv: bool,
    /// Also `sensor.html`: map, sections, and the scene in three dimensions.
    pub html: bool,
}

/// Simulates and writes `irradiance.npy`, `irradiance.png`, `result.json`.
///
/// # Errors
/// Exit 2 for a scene that cannot be lit, with the reason; nothing is written then.
pub fn run(request: &SimulateRequest, progress: &dyn Progress) -> Result<Facts, Failure> {
    let scene = scene::load(&request.input, &request.changes)?;
    files::refuse_occupied(&request.out, request.overwrite)?;
    if let Some((path, _)) = &request.rays_out {
        files::refuse_existing(path, request.overwrite)?;
    }
    let earlier = request.against.as_deref().map(earlier_result).transpose()?;
    progress.event(Event::Began {
        step: "simulate",
        total: None,
    });
    let mut simulation = solve(&scene, request.method).map_err(|failure| Failure {
        message: format!("{}: {}", request.input, failure.message),
        ..failure
    })?;
    if let Some(assumption) = scene::assumption(&request.input, &scene, &request.changes) {
        let finding = format!("{assumption}; --distance-mm, --sensor-mm and --pixels change it");
        simulation.facts.findings.insert(0, finding);
    }
    if let Some((earlier, folder)) = earlier.as_ref().zip(request.against.as_deref()) {
        simulation.facts.against = Some(
            against::compare(&simulation.facts, earlier, folder.as_str())
                .map_err(|error| Failure::bad_input(error).help("give both a spectrum or ler_lm_per_w, or neither"))?,
        );
    }
    for finding in &simulation.facts.findings {
        progress.event(Event::Note(finding));
    }
    let rays = match &request.rays_out {
        Some((path, wanted)) => Some((path, ray_file(&scene, &simulation, path, *wanted)?)),
        None => None,
    };
    let folder = files::output_folder(&request.out, request.overwrite)?;
    if request.overwrite == Overwrite::Force {
        remove_old(&folder)?;
    }
    let files = prepared(&folder, &simulation, None, request.overwrite)?;
    let (map, facts) = (&simulation.map, &simulation.facts);
    let [nx, ny] = facts.pixels;
    if request.tiff {
        files::write(
            &folder.join("irradiance.tiff"),
            &array_files::tiff(map, nx, ny)?,
            request.overwrite,
        )?;
    }
    if request.csv {
        let column = match facts.unit {
            MapUnit::Lux => "illuminance_lx",
            MapUnit::WattPerSquareMetre => "irradiance_w_m2",
        };
        let bytes = array_files::csv(map, nx, ny, facts.size_mm, column);
        files::write(&folder.join("irradiance.csv"), &bytes, request.overwrite)?;
    }
    if request.html {
        let page = sensor::page(&scene, &simulation)?;
        files::write(&folder.join("sensor.html"), page.as_bytes(), request.overwrite)?;
    }
    if let Some(signal) = &simulation.signal_dn {
        let bytes = array_files::tiff16(signal, nx, ny)?;
        files::write(&folder.join("signal_dn.tiff"), &bytes, request.overwrite)?;
    }
    if let Some((path, bytes)) = rays {
        files::write(path, &bytes, request.overwrite)?;
    }
    files::publish(files)?;
    progress.event(Event::Ended(&format!(
        "{} × {} pixels in {:.3} s",
        nx,
        ny,
        facts.elapsed_s.unwrap_or_default()
    )));
    Ok(simulation.facts)
}

/// What the `result.json` of an earlier simulation in `folder` says.
fn earlier_result(folder: &Utf8Path) -> Result<Facts, Failure> {
    files::read_json(&folder.join("result.json"))
        .map_err(|failure| failure.help("give the folder of an earlier `isolux simulate`"))
}

/// Refuses a scene that cannot be lit, without lighting it.
///
/// # Errors
/// Exit 2 with what is impossible and what to do.
pub fn can_be_lit(scene: &isolux_model::Scene) -> Result<(), Failure> {
    match isolux_sim::setup::Setup::new(scene) {
        Ok(_) => Ok(()),
        Err(error) => Err(refused(&SimulationError::Setup(error))),
    }
}

/// Refuses a scene that could not be simulated to the end, by simulating it with a few pixels in place of its own.
///
/// # Errors
/// As [`solve`], and exit 2 when the map of the whole scene would not fit into the memory that is free.
pub(crate) fn check_feasibility(scene: &isolux_model::Scene) -> Result<(), Failure> {
    const SIDE: usize = 3;
    memory::refuse_too_many(scene.sensor.pixels)?;
    let mut few = scene.clone();
    few.sensor.pixels = few.sensor.pixels.map(|pixels| pixels.min(SIDE));
    solve(&few, Method::Inverse).map(|_| ())
}

/// Solves a scene; the clock of `elapsed_s` is the machine's.
///
/// # Errors
/// Exit 2 with what is impossible and what to do.
pub fn solve(scene: &isolux_model::Scene, method: Method) -> Result<Simulation, Failure> {
    memory::refuse_too_many(scene.sensor.pixels)?;
    let start = Instant::now();
    let simulation =
        simulation::simulate(scene, method, &|| start.elapsed().as_secs_f64()).map_err(|error| refused(&error))?;
    finite(simulation)
}

/// As [`solve`], with the map as the solver found it, before it is rounded for a file; ends early where `stop` is
/// requested.
///
/// # Errors
/// As [`solve`]; [`FailureKind::Interrupted`] where `stop` was requested.
pub fn solve_exact(scene: &isolux_model::Scene, method: Method, stop: &Stop) -> Result<Exact, Failure> {
    memory::refuse_too_many(scene.sensor.pixels)?;
    let start = Instant::now();
    let simulation =
        simulation::exact(scene, method, &|| start.elapsed().as_secs_f64(), stop).map_err(|error| refused(&error))?;
    finite(simulation)
}

/// A simulation whose map holds light alone.
///
/// # Errors
/// Exit 2 with the first pixel that is no number.
fn finite<T: Number + Into<f64> + std::fmt::Display>(simulation: Simulation<T>) -> Result<Simulation<T>, Failure> {
    let facts = &simulation.facts;
    // A sum that is finite has only finite terms; they are stored as f32.
    if facts.mean.is_finite() && facts.min.abs().max(facts.max.abs()) < f64::from(f32::MAX) {
        return Ok(simulation);
    }
    match simulation.map.iter().position(|value| !(*value).into().is_finite()) {
        None => Ok(simulation),
        Some(pixel) => {
            let [nx, _] = facts.pixels;
            Err(Failure::bad_input(format!(
                "pixel ({}, {}) comes out as {}: no light is that",
                pixel % nx,
                pixel / nx,
                simulation.map[pixel]
            ))
            .help("one of the numbers of the scene or of its model is far beyond what a lamp or a sensor has"))
        }
    }
}

fn refused(error: &SimulationError) -> Failure {
    let help = match error {
        SimulationError::Direct(DirectError::TooMany { .. }) => {
            "use --sampling expected: its cost does not grow with the rays"
        }
        SimulationError::Direct(DirectError::NoRays) => "give --rays 2e9, or leave --method direct out",
        SimulationError::Direct(DirectError::Dark { .. }) => "check the distribution's flux with `isolux inspect`",
        SimulationError::Responsivity { .. } => "the file has the columns wavelength_nm,qe",
        SimulationError::Setup(SetupError::Behind { .. }) => {
            "sensor.tilt_x_deg, sensor.tilt_y_deg and sensor.offset_mm say how it stands; 0° faces the luminaire"
        }
        SimulationError::Stopped => {
            return Failure {
                kind: FailureKind::Interrupted,
                message: error.to_string(),
                help: None,
            };
        }
        SimulationError::Setup(_) => "check the [sensor] table of the scene: distance_mm, offset_mm and tilts",
    };
    Failure::bad_input(error).help(help)
}

/// The bytes of a ray file: JSON for `.json`, IES TM-25 for any other extension.
fn ray_file(
    scene: &isolux_model::Scene,
    simulation: &Simulation,
    path: &Utf8Path,
    wanted: usize,
) -> Result<Vec<u8>, Failure> {
    if path.extension() != Some("json") {
        let name = path.file_stem().unwrap_or("luminaire");
        return rays::tm25(scene, simulation, wanted, name).map_err(Failure::bad_input);
    }
    let rays = rays::file(scene, simulation, wanted).map_err(Failure::bad_input)?;
    let mut text = serde_json::to_string(&rays).map_err(Failure::instrument)?;
    text.push('\n');
    Ok(text.into_bytes())
}

/// Writes the three result files of a simulation; `result.json` last, so that it stands for a whole result. The picture
/// marks what is below `u_rel`, the uncertainty of single directions.
///
/// # Errors
/// Exit 2 when a file exists and may not be replaced, exit 3 when the disk refuses.
pub fn write(
    folder: &Utf8Path,
    simulation: &Simulation,
    u_rel: Option<f64>,
    overwrite: Overwrite,
) -> Result<(), Failure> {
    files::publish(prepared(folder, simulation, u_rel, overwrite)?)
}

/// The map as a picture: PNG with a colour bar, as in `irradiance.png`.
pub fn picture(simulation: &Simulation) -> Vec<u8> {
    sensor::marked(simulation, None).png()
}

/// The result files on the disk, without their names yet; `result.json` last.
fn prepared(
    folder: &Utf8Path,
    simulation: &Simulation,
    u_rel: Option<f64>,
    overwrite: Overwrite,
) -> Result<Vec<Pending>, Failure> {
    let [nx, ny] = simulation.facts.pixels;
    let prepare = |name: &str, bytes: &[u8]| files::prepare(&folder.join(name), bytes, overwrite);
    let mut text = serde_json::to_string_pretty(&simulation.facts).map_err(Failure::instrument)?;
    text.push('\n');
    // The disk takes its time with the one file while the other is made.
    std::thread::scope(|scope| {
        let map = scope.spawn(|| prepare("irradiance.npy", &array_files::npy(&simulation.map, nx, ny)));
        let facts = scope.spawn(|| prepare("result.json", text.as_bytes()));
        let picture = prepare("irradiance.png", &sensor::marked(simulation, u_rel).png());
        let [map, facts] = [map, facts].map(|file| file.join().unwrap_or_else(|panic| resume_unwind(panic)));
        Ok(vec![map?, picture?, facts?])
    })
}

/// Takes the files of an earlier simulation out of `folder`, `result.json` first: what this one does not write would
/// pass for its own. The map stays until it is replaced and marks the folder as one of a simulation.
fn remove_old(folder: &Utf8Path) -> Result<(), Failure> {
    if !folder.join("irradiance.npy").is_file() {
        return Ok(());
    }
    for name in [
        "result.json",
        "irradiance.tiff",
        "irradiance.csv",
        "sensor.html",
        "signal_dn.tiff",
    ] {
        let path = folder.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Failure::instrument(format!("{path}: cannot take it away: {error}")));
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_result_is_read_from_its_own_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8Path::from_path(folder.path()).unwrap();
        assert_eq!(earlier_result(path).unwrap_err().kind, crate::FailureKind::BadInput);
        // A whole one is read in tests/suite/results_are_types.rs.
        std::fs::write(path.join("result.json"), r#"{"unit": "lx", "mean": 2.0}"#).unwrap();
        let failure = earlier_result(path).unwrap_err();
        assert!(failure.message.contains("result.json: missing field"), "{failure}");
    }
}
