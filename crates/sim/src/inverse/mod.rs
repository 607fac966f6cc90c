//! Inverse simulation: the irradiance of every pixel by quadrature over pixel and emitter, with a bound on its own
//! error.

mod prepared;
mod route;
mod routes;
mod tiles;
mod tolerance;

use rayon::prelude::*;

use self::prepared::Prepared;
use crate::crossings::Scratch;
use crate::sensor::Sensor;
use crate::source::LightSource;

pub use self::prepared::DIM;
pub use self::routes::Routes;
pub use crate::bound::Bound;
pub use crate::rules::Estimate;
pub use isolux_model::Accuracy;

/// Error that an accuracy allows a pixel, relative to it.
pub fn allowed(accuracy: Accuracy) -> f64 {
    tolerance::Tolerances::of(accuracy).allowed
}

/// A map of illuminance without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Mean over each pixel in lx, `[iy * nx + ix]`.
    pub illuminance_lx: Vec<f64>,
    /// What its errors do not exceed.
    pub bound: Bound,
}

/// The map: quick rules where their bound meets the tolerance, cuts at every kink elsewhere, polynomials over tiles
/// where the light is smooth. Independent of the number of threads.
pub fn solve(source: &LightSource, sensor: &Sensor, accuracy: Accuracy) -> Map {
    let mut illuminance_lx = vec![0.0; sensor.pixels()];
    let bound = solve_into(source, sensor, accuracy, &mut illuminance_lx);
    Map { illuminance_lx, bound }
}

/// The map in the caller's memory (`[iy * nx + ix]`, as many as the sensor has pixels).
///
/// # Panics
/// If `map` has another length.
pub fn solve_into(source: &LightSource, sensor: &Sensor, accuracy: Accuracy, map: &mut [f64]) -> Bound {
    solve_by(source, sensor, accuracy, Routes::ALL, map)
}

/// [`solve_into`] by some of the routes alone: what each of them is for can be measured.
///
/// # Panics
/// If `map` has another length than the sensor has pixels.
pub fn solve_by(source: &LightSource, sensor: &Sensor, accuracy: Accuracy, routes: Routes, map: &mut [f64]) -> Bound {
    assert_eq!(map.len(), sensor.pixels(), "one number a pixel");
    tiles::fill(&Prepared::new(source, sensor, accuracy, routes, 1.0), sensor, map)
}

/// The mean over one pixel in lx with its bound, to errors `share` times those of a map of this accuracy.
pub fn pixel(
    source: &LightSource,
    sensor: &Sensor,
    [ix, iy]: [usize; 2],
    accuracy: Accuracy,
    routes: Routes,
    share: f64,
) -> Estimate {
    let prepared = Prepared::new(source, sensor, accuracy, routes, share);
    prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, &mut Scratch::default())
}

/// Every pixel by itself with cuts at every kink, no quick rules, no interpolation between pixels.
pub fn solve_each(source: &LightSource, sensor: &Sensor) -> Map {
    let prepared = Prepared::new(source, sensor, Accuracy::Reference, Routes::CHORDS, 1.0);
    let mut illuminance_lx = vec![0.0; sensor.pixels()];
    let bound = illuminance_lx
        .par_chunks_mut(sensor.nx)
        .enumerate()
        .map_init(Scratch::default, |scratch, (iy, row)| {
            let mut bound = Bound::default();
            for (ix, value) in row.iter_mut().enumerate() {
                let found = prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, scratch);
                *value = found.value;
                bound.add_one(found, prepared.allowed);
            }
            bound
        })
        .reduce(Bound::default, Bound::joined)
        .over(sensor.pixels());
    Map { illuminance_lx, bound }
}
