//! Inverse simulation: the irradiance of every pixel by quadrature over pixel and emitter, with a bound on its own error.

use glam::DVec3;
use rayon::prelude::*;

use crate::patch::{self, Light, Patch, Scratch};
use crate::rules::Estimate;
use crate::sensor::Sensor;
use crate::source::{Part, Shape, Source};
use crate::tiles;

/// Relative error that the reference path aims at in every pixel.
pub const RELATIVE_TOLERANCE: f64 = 2e-7;

/// A map of illuminance without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Mean over each pixel in lx, `[iy * nx + ix]`.
    pub illuminance_lx: Vec<f64>,
    /// Mean over the map of the bound on the error of the quadrature, lx.
    pub error_lx: f64,
}

/// The map by the reference path in f64. Independent of the number of threads.
pub fn solve(source: &Source, sensor: &Sensor) -> Map {
    tiles::fill(sensor, |x, y, scratch| pixel(source, sensor, x, y, scratch))
}

/// The map pixel by pixel, no interpolation between pixels: what [`solve`] is tested against.
pub fn solve_each(source: &Source, sensor: &Sensor) -> Map {
    let rows: Vec<(Vec<f64>, f64)> = (0..sensor.ny)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, iy| {
            let mut error = 0.0;
            let row = (0..sensor.nx)
                .map(|ix| {
                    let found = pixel(source, sensor, ix as f64 + 0.5, iy as f64 + 0.5, scratch);
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

/// Mean illuminance in lx over the pixel-sized parallelogram centred at (x, y) in pixels, from the whole emitter.
pub(crate) fn pixel(source: &Source, sensor: &Sensor, x: f64, y: f64, scratch: &mut Scratch) -> Estimate {
    let mut total = Estimate::default();
    let corner = sensor.point(x - 0.5, y - 0.5);
    for part in source.parts() {
        let found = from_part(part, source.extinction_per_mm(), corner, sensor, scratch);
        total.value += part.share * found.value;
        total.error += part.share.abs() * found.error;
    }
    total
}

fn from_part(part: &Part, extinction_per_mm: f64, corner: DVec3, sensor: &Sensor, scratch: &mut Scratch) -> Estimate {
    // In the part's own frame the table stands upright.
    let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
    let light = Light {
        table: &part.table,
        toward: own(sensor.toward),
        extinction_per_mm,
    };
    let pixel = Patch::Parallelogram {
        corner: own(corner),
        first: own(sensor.step_x),
        second: own(sensor.step_y),
    };
    let centre = own(part.shape.centre());
    if matches!(part.shape, Shape::Point(_)) {
        return over_pixel(light, &pixel.shifted(-centre), scratch);
    }
    let mut total = Estimate::default();
    for (emitter, share) in part.shape.patches() {
        let emitter = match emitter {
            Patch::Disc { centre, first, second } => Patch::Disc {
                centre: own(centre),
                first: own(first),
                second: own(second),
            },
            Patch::Parallelogram { corner, first, second } => Patch::Parallelogram {
                corner: own(corner),
                first: own(first),
                second: own(second),
            },
        };
        let found = over_both(light, &pixel, &emitter, scratch);
        total.value += share * found.value;
        total.error += share.abs() * found.error;
    }
    total
}

fn over_both(light: Light<'_>, pixel: &Patch, emitter: &Patch, scratch: &mut Scratch) -> Estimate {
    let sight = pixel.centre() + emitter.centre();
    let reach = pixel.radius() + emitter.radius();
    let nearest = singular_distance(sight).min(sensor_distance(light, sight, emitter));
    if !patch::may_bend(light.table, sight, reach) && reach < 0.4 * nearest {
        // Analytic over pixel and emitter together: one product rule of each, its order from the size.
        return smooth(light, sight, pixel, Some(emitter), reach / nearest);
    }
    if reach < 0.05 * nearest {
        // A kink too weak to matter: its slope over the reach of the patch bounds what a product rule can miss.
        let value = product(light, sight, pixel, Some(emitter), [2, 2]);
        let [bend_c, bend_gamma] = light.table.bend();
        let height = 1e6 * light.toward.dot(sight) / sight.length().powi(3);
        let strength = height * reach * (bend_c / nearest + bend_gamma / sight.length());
        if strength <= 3e-4 * value.abs() {
            let fine = product(light, sight, pixel, Some(emitter), [3, 3]);
            let step = (value - fine).abs();
            if strength <= 1e-5 * fine.abs() || step <= 0.3 * RELATIVE_TOLERANCE * fine.abs() {
                return Estimate {
                    value: fine,
                    error: step.max(1e-3 * strength),
                };
            }
        }
    }
    // Kinks are met exactly over the larger of the two; over the smaller one what is left is smooth enough for a rule
    // that is refined until it settles.
    let (inner, outer) = if pixel.radius() >= emitter.radius() {
        (pixel, emitter)
    } else {
        (emitter, pixel)
    };
    let shift = inner.shifted(outer.centre());
    settle(
        outer,
        |offset, scratch| patch::mean(light, &shift.shifted(offset), RELATIVE_TOLERANCE, scratch),
        scratch,
    )
}

fn over_pixel(light: Light<'_>, pixel: &Patch, scratch: &mut Scratch) -> Estimate {
    let sight = pixel.centre();
    let reach = pixel.radius();
    let nearest = singular_distance(sight);
    if !patch::may_bend(light.table, sight, reach) && reach < 0.4 * nearest {
        return smooth(light, sight, pixel, None, reach / nearest);
    }
    patch::mean(light, pixel, RELATIVE_TOLERANCE, scratch)
}

/// Distance from the end of a line of sight to the nearest singularity of the integrand: the pole axis.
fn singular_distance(sight: DVec3) -> f64 {
    sight.x.hypot(sight.y)
}

/// For a tilted sensor near an extended emitter the projection changes sign in the sensor's plane: no smooth rule across it.
fn sensor_distance(light: Light<'_>, sight: DVec3, emitter: &Patch) -> f64 {
    let height = light.toward.dot(sight);
    if height > 0.0 && height < emitter.radius() {
        height.max(1e-300)
    } else {
        f64::INFINITY
    }
}

/// Product rule over pixel and emitter where no kink is near. `ratio`: reach of both over the distance of the singularity.
fn smooth(light: Light<'_>, sight: DVec3, pixel: &Patch, emitter: Option<&Patch>, ratio: f64) -> Estimate {
    let order = match ratio {
        r if r < 0.001 => 1,
        r if r < 0.012 => 2,
        r if r < 0.05 => 3,
        r if r < 0.12 => 4,
        r if r < 0.2 => 6,
        _ => 8,
    };
    let relative: f64 = if order == 1 {
        ratio * ratio
    } else {
        (ratio / 1.5).powi(2 * order as i32)
    };
    // A patch far smaller than the other needs fewer points.
    let of = |patch: &Patch| {
        let own = ratio * patch.radius() / (pixel.radius() + emitter.map_or(0.0, Patch::radius));
        let mut n = order;
        while n > 1 && own.powi(2 * (n as i32 - 1)) < 1e-9 * if n == 2 { 10.0 } else { 1.0 } {
            n -= 1;
        }
        n
    };
    let sum = product(light, sight, pixel, emitter, [of(pixel), emitter.map_or(1, of)]);
    Estimate {
        value: sum,
        error: sum.abs() * relative.max(1e-14),
    }
}

/// The product of a rule of each order over pixel and emitter.
fn product(light: Light<'_>, sight: DVec3, pixel: &Patch, emitter: Option<&Patch>, order: [usize; 2]) -> f64 {
    let mut nodes = Vec::new();
    let mut spots = Vec::new();
    pixel.nodes(order[0], &mut nodes);
    match emitter {
        Some(emitter) => emitter.nodes(order[1], &mut spots),
        None => spots.push((DVec3::ZERO, 1.0)),
    }
    let mut sum = 0.0;
    for &(at, w) in &nodes {
        for &(spot, ws) in &spots {
            sum += w * ws * light.at(sight + at + spot);
        }
    }
    sum
}

/// Refines the rule over `outer` until two in a row agree.
fn settle(outer: &Patch, mut mean: impl FnMut(DVec3, &mut Scratch) -> Estimate, scratch: &mut Scratch) -> Estimate {
    let mut nodes = Vec::new();
    let mut before: Option<f64> = None;
    let mut last = Estimate::default();
    for order in [1, 2, 3, 5, 8, 12, 16] {
        outer.nodes(order, &mut nodes);
        let mut sum = Estimate::default();
        for &(offset, w) in &nodes {
            let one = mean(offset, scratch);
            sum.value += w * one.value;
            sum.error += w * one.error;
        }
        let step = before.map_or(f64::INFINITY, |before| (sum.value - before).abs());
        last = Estimate {
            value: sum.value,
            error: sum.error + step,
        };
        if step <= 2.0 * RELATIVE_TOLERANCE * sum.value.abs() || sum.value == 0.0 && order > 2 {
            last.error = sum.error + 0.3 * step;
            break;
        }
        before = Some(sum.value);
    }
    last
}
