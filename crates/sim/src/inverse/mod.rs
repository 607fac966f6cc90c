//! Inverse simulation: the irradiance of every pixel by quadrature over pixel and emitter, with a bound on its own error.

mod prepared;
mod route;
mod trust;

use rayon::prelude::*;

use self::prepared::Prepared;
use crate::number::Care;
use crate::patch::Scratch;
use crate::rows::Rows;
use crate::sensor::Sensor;
use crate::source::Source;
use crate::tiles;

pub use crate::bound::Bound;
pub use crate::number::Number;
pub use crate::rules::Estimate;

/// A map of illuminance without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Mean over each pixel in lx, `[iy * nx + ix]`.
    pub illuminance_lx: Vec<f64>,
    /// Mean over the map of the bound on the error of the quadrature, lx.
    pub error_lx: f64,
}

/// The map: quick rules where their bound meets the tolerance, cuts at every kink elsewhere, polynomials over tiles where
/// the light is smooth. Independent of the number of threads.
pub fn solve(source: &Source, sensor: &Sensor) -> Map {
    let mut illuminance_lx = vec![0.0; sensor.pixels()];
    let bound = solve_into(source, sensor, &mut illuminance_lx);
    Map {
        illuminance_lx,
        error_lx: bound.mean_lx,
    }
}

/// The map in the caller's memory (`[iy * nx + ix]`, as many as the sensor has pixels), in f64 or, for half the memory
/// and time, in f32.
///
/// # Panics
/// If `map` has another length.
pub fn solve_into<N: Number>(source: &Source, sensor: &Sensor, map: &mut [N]) -> Bound {
    assert_eq!(map.len(), sensor.pixels(), "one number a pixel");
    if let Some(bound) = rows(source, sensor, map) {
        return bound;
    }
    let prepared = Prepared::new(source, sensor, true);
    tiles::fill(
        sensor,
        map,
        |x, y, care, scratch| prepared.pixel(x, y, care, scratch),
        |x, y, half| prepared.is_smooth(x, y, half, N::AIM),
    )
}

/// Row by row, where the source and the sensor allow it.
fn rows<N: Number>(source: &Source, sensor: &Sensor, map: &mut [N]) -> Option<Bound> {
    let rows = Rows::new::<N>(source, sensor)?;
    // Few maps have pixels for which their centres do not stand.
    let prepared = std::sync::OnceLock::new();
    Some(rows.fill(map, |ix, iy| {
        prepared.get_or_init(|| Prepared::new(source, sensor, true)).pixel(
            ix as f64 + 0.5,
            iy as f64 + 0.5,
            Care::Itself,
            &mut Scratch::default(),
        )
    }))
}

/// How a single pixel is computed, where that is to be checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// As in a map whose pixels are computed by themselves.
    Chosen,
    /// Flat emitters along their outline wherever that applies, no product rules.
    Outlines,
    /// Chords of pixel and emitter, or lines across the pixel for points.
    Chords,
}

/// The mean over one pixel in lx with its bound, to errors `share` times those of a map (1 is a map's own).
pub fn pixel(source: &Source, sensor: &Sensor, [ix, iy]: [usize; 2], route: Route, share: f64) -> Estimate {
    let prepared = Prepared::by(source, sensor, route, share);
    prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, Care::Itself, &mut Scratch::default())
}

/// The reference: every pixel by itself with cuts at every kink, no quick rules, no interpolation between pixels.
pub fn solve_each(source: &Source, sensor: &Sensor) -> Map {
    let prepared = Prepared::new(source, sensor, false);
    let rows: Vec<(Vec<f64>, f64)> = (0..sensor.ny)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, iy| {
            let mut error = 0.0;
            let row = (0..sensor.nx)
                .map(|ix| {
                    let found = prepared.pixel(ix as f64 + 0.5, iy as f64 + 0.5, Care::Itself, scratch);
                    error += found.error;
                    found.value
                })
                .collect();
            (row, error)
        })
        .collect();
    let error_lx = rows.iter().map(|row| row.1).sum::<f64>() / sensor.pixels() as f64;
    Map {
        illuminance_lx: rows.into_iter().flat_map(|row| row.0).collect(),
        error_lx,
    }
}
