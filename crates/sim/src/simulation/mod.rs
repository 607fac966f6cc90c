//! One simulation of one scene: solver, effects, unit, and what the result is worth.

mod error;
mod exposure;
mod facts;
mod mean_uncertainty;
mod rays;
mod receiver;
mod stated;

use isolux_model::{Accuracy, Scene};
use rayon::prelude::*;

pub use self::error::SimulationError;
pub use self::facts::{AccuracyFacts, Against, Band, CameraFacts, ColourAt, ColourFacts, Facts, MapUnit, PixelBound};
use self::receiver::Receiver;
use crate::array::{Array, Number, RUN};
use crate::direct::{self, Counts, Sampling};
use crate::inverse::Bound;
use crate::setup::Setup;
use crate::stop::Stop;
use crate::{blur, inverse};

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

/// A map and its facts. The map holds `f32`, as files do, or what the solver found.
#[derive(Debug, Clone)]
pub struct Simulation<T: Number = f32> {
    /// Mean of each pixel, `[iy * nx + ix]`, in [`Facts::unit`].
    pub map: Array<T>,
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
/// [`SimulationError`] for an impossible scene, camera or number of rays, before the map is computed.
pub fn simulate(scene: &Scene, method: Method, now: &dyn Fn() -> f64) -> Result<Simulation, SimulationError> {
    Ok(exact(scene, method, now, &Stop::default())?.rounded())
}

impl Simulation<f64> {
    /// With the map as files hold it.
    pub fn rounded(self) -> Simulation {
        Simulation {
            map: rounded(&self.map),
            signal_dn: self.signal_dn,
            counts: self.counts,
            facts: self.facts,
            setup: self.setup,
        }
    }
}

/// As [`simulate`], with the map as the solver found it, and ended early where `stop` is requested.
///
/// # Errors
/// As [`simulate`]; [`SimulationError::Stopped`] where `stop` was requested before the map was whole.
pub fn exact(
    scene: &Scene,
    method: Method,
    now: &dyn Fn() -> f64,
    stop: &Stop,
) -> Result<Simulation<f64>, SimulationError> {
    let mut setup = Setup::new(scene)?;
    setup.source = setup.source.until(stop.clone());
    let receiver = Receiver::of(scene, &setup)?;
    let started = now();
    let solved = Solved::of(&setup, method, scene.accuracy)?;
    if stop.is_requested() {
        return Err(SimulationError::Stopped);
    }
    let elapsed_s = now() - started;
    let receiver = receiver.lit_by(&setup, &solved.map);
    let exposure = receiver.exposure(&solved.map);
    let facts = stated::facts(scene, &setup, &receiver, method, &solved);
    Ok(Simulation {
        facts: Facts {
            elapsed_s: Some(elapsed_s),
            camera: exposure.as_ref().map(|exposure| exposure.facts),
            ..facts
        },
        signal_dn: exposure.map(|exposure| exposure.signal_dn),
        counts: solved.counts,
        map: solved.map,
        setup,
    })
}

/// A map as it is stored.
fn rounded(map: &[f64]) -> Array<f32> {
    let mut stored = Array::zeros(map.len());
    let runs = stored.par_chunks_mut(RUN).zip(map.par_chunks(RUN));
    runs.for_each(|(stored, values)| {
        for (stored, value) in stored.iter_mut().zip(values) {
            *stored = *value as f32;
        }
    });
    stored
}

/// A finished map in the unit of the result.
struct Solved {
    map: Array<f64>,
    /// Of the inverse method.
    bound: Bound,
    counts: Option<Counts>,
}

impl Solved {
    fn of(setup: &Setup, method: Method, accuracy: Accuracy) -> Result<Self, SimulationError> {
        let Method::Direct { sampling, rays, seed } = method else {
            let (map, bound) = noise_free(setup, accuracy);
            return Ok(Self {
                map,
                bound,
                counts: None,
            });
        };
        let (source, sensor) = (&setup.source, &setup.sensor);
        let counts = match sampling {
            Sampling::Traced => direct::traced(source, sensor, rays, seed)?,
            Sampling::Thinned => direct::thinned(source, sensor, rays, seed)?,
            Sampling::Expected => {
                let mut expected = Array::zeros(sensor.pixels());
                inverse::solve_into(source, sensor, Accuracy::Standard, &mut expected);
                direct::expected(source, sensor, &expected, rays, seed)?
            }
        };
        let mut map = counts.illuminance_lx();
        finish(setup, &mut map);
        Ok(Self {
            map,
            bound: Bound::default(),
            counts: Some(counts),
        })
    }
}

/// The finished map of the inverse method, and its bound in the map's unit.
fn noise_free(setup: &Setup, accuracy: Accuracy) -> (Array<f64>, Bound) {
    let mut map = Array::zeros(setup.sensor.pixels());
    let bound = inverse::solve_into(&setup.source, &setup.sensor, accuracy, &mut map);
    finish(setup, &mut map);
    let strongest = setup.pixel_factor.as_ref().map_or(1.0, |factors| {
        factors.iter().fold(0.0_f64, |most, factor| most.max(factor.abs()))
    });
    (map, bound.scaled((setup.lamp * setup.per_unit() * strongest).abs()))
}

/// Lamp, sensor effects, blur, background and unit: everything after the solver, the same for both methods.
fn finish(setup: &Setup, map: &mut Array<f64>) {
    let per_unit = setup.per_unit();
    map.par_chunks_mut(RUN).enumerate().for_each(|(run, values)| {
        let factors = setup.pixel_factor.as_ref().map(|factors| &factors[run * RUN..]);
        for (index, value) in values.iter_mut().enumerate() {
            let illuminated = *value * setup.lamp * factors.map_or(1.0, |factors| factors[index]);
            *value = (illuminated + setup.background_lx) * per_unit;
        }
    });
    if setup.blur_px > 0.0 {
        *map = blur::gaussian(map, setup.sensor.nx, setup.sensor.ny, setup.blur_px).into();
    }
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use isolux_model::{Emitter, Luminaire, Model, Spectral};
    use isolux_photometry::IntensityDistribution;

    use super::*;

    #[test]
    fn what_is_asked_to_stop_has_no_result_and_traces_no_ray() {
        let even = IntensityDistribution::new(vec![0.0], vec![0.0, 180.0], vec![1.0; 2]).unwrap();
        let model = Model::of(Luminaire::new(even, Emitter::Point {}, Spectral::None));
        let text = "format = \"isolux-scene/1\"\n[sensor]\nsize_mm = 10.0\npixels = 8\ndistance_mm = 500.0\n";
        let scene = Scene::parse_with(Utf8Path::new("scene.toml"), text, &model).unwrap();
        let stop = Stop::default();
        assert!(exact(&scene, Method::Inverse, &|| 0.0, &stop).is_ok());
        stop.request();
        let direct = |sampling| Method::Direct {
            sampling,
            rays: 1_000_000_000_000,
            seed: 1,
        };
        for method in [Method::Inverse, direct(Sampling::Traced), direct(Sampling::Thinned)] {
            let ended = exact(&scene, method, &|| 0.0, &stop);
            assert_eq!(ended.unwrap_err(), SimulationError::Stopped, "{method:?}");
        }
    }
}
