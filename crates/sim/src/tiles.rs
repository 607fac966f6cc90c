//! Large maps: where the light is smooth over many pixels, a polynomial through Chebyshev points replaces the quadrature
//! of each pixel.
//!
//! The function that is interpolated is the mean over a pixel-sized window centred anywhere, so that nothing is lost by the
//! pixels' own integration. A tile is taken when the last Chebyshev coefficients are below the tolerance and four points
//! between the nodes confirm it; else it is quartered, down to single pixels.

use rayon::prelude::*;

use crate::inverse::{Care, Map, RELATIVE_TOLERANCE};
use crate::patch::Scratch;
use crate::rules::Estimate;
use crate::sensor::Sensor;

/// Points along each side of a tile.
const NODES: usize = 7;
/// Sides of the first tiles, in pixels.
const TILE: usize = 256;
/// Below this side, each pixel is computed by itself.
const SMALL: usize = 12;

#[derive(Clone, Copy)]
struct Tile {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

/// Fills a map from `at(x, y)`, the value centred at (x, y) in pixels; `smooth(x, y, half)` tells whether no sharp kink crosses
/// the square of `half` pixels round (x, y).
pub(crate) fn fill<F, S>(sensor: &Sensor, at: F, smooth: S) -> Map
where
    F: Fn(f64, f64, Care, &mut Scratch) -> Estimate + Sync,
    S: Fn(f64, f64, f64) -> bool + Sync,
{
    let side = if sensor.nx.max(sensor.ny) > 2 * SMALL {
        TILE
    } else {
        SMALL
    };
    let side = side.min(sensor.nx.max(sensor.ny).div_ceil(4));
    let mut todo = Vec::new();
    for y in (0..sensor.ny).step_by(side) {
        for x in (0..sensor.nx).step_by(side) {
            todo.push(Tile {
                x,
                y,
                width: side.min(sensor.nx - x),
                height: side.min(sensor.ny - y),
            });
        }
    }
    let done: Vec<Vec<(Tile, Vec<f64>, f64)>> = todo
        .into_par_iter()
        .map_init(Scratch::default, |scratch, tile| {
            let mut filled = Vec::new();
            solve(tile, &at, &smooth, scratch, &mut filled);
            filled
        })
        .collect();
    let mut illuminance_lx = vec![0.0; sensor.pixels()];
    let mut error = 0.0;
    for (tile, values, part) in done.into_iter().flatten() {
        for (row, line) in values.chunks_exact(tile.width).enumerate() {
            let start = (tile.y + row) * sensor.nx + tile.x;
            illuminance_lx[start..start + tile.width].copy_from_slice(line);
        }
        error += part;
    }
    Map {
        illuminance_lx,
        error_lx: error / sensor.pixels() as f64,
    }
}

fn solve<F, S>(tile: Tile, at: &F, smooth: &S, scratch: &mut Scratch, out: &mut Vec<(Tile, Vec<f64>, f64)>)
where
    F: Fn(f64, f64, Care, &mut Scratch) -> Estimate,
    S: Fn(f64, f64, f64) -> bool,
{
    if tile.width <= SMALL || tile.height <= SMALL {
        let mut error = 0.0;
        let mut values = Vec::with_capacity(tile.width * tile.height);
        for iy in 0..tile.height {
            for ix in 0..tile.width {
                let one = at(
                    (tile.x + ix) as f64 + 0.5,
                    (tile.y + iy) as f64 + 0.5,
                    Care::Itself,
                    scratch,
                );
                error += one.error;
                values.push(one.value);
            }
        }
        out.push((tile, values, error));
        return;
    }
    let half = 0.5 * tile.width.max(tile.height) as f64;
    let middle = [
        tile.x as f64 + 0.5 * tile.width as f64,
        tile.y as f64 + 0.5 * tile.height as f64,
    ];
    let found = smooth(middle[0], middle[1], half).then(|| interpolate(tile, at, scratch));
    if let Some((values, error)) = found.flatten() {
        out.push((tile, values, error));
        return;
    }
    let (left, top) = (tile.width / 2, tile.height / 2);
    for (x, width) in [(0, left), (left, tile.width - left)] {
        for (y, height) in [(0, top), (top, tile.height - top)] {
            solve(
                Tile {
                    x: tile.x + x,
                    y: tile.y + y,
                    width,
                    height,
                },
                at,
                smooth,
                scratch,
                out,
            );
        }
    }
}

fn interpolate<F>(tile: Tile, at: &F, scratch: &mut Scratch) -> Option<(Vec<f64>, f64)>
where
    F: Fn(f64, f64, Care, &mut Scratch) -> Estimate,
{
    let nodes: [f64; NODES] = std::array::from_fn(chebyshev_node);
    let place = |origin: usize, extent: usize, s: f64| origin as f64 + 0.5 * extent as f64 * (1.0 + s);
    let mut values = [[0.0; NODES]; NODES];
    let (mut error, mut scale) = (0.0, 0.0_f64);
    for (j, row) in values.iter_mut().enumerate() {
        for (i, value) in row.iter_mut().enumerate() {
            let one = at(
                place(tile.x, tile.width, nodes[i]),
                place(tile.y, tile.height, nodes[j]),
                Care::Node,
                scratch,
            );
            *value = one.value;
            error += one.error / (NODES * NODES) as f64;
            scale = scale.max(one.value.abs());
        }
    }
    let coefficients = coefficients(&values);
    let least = values
        .iter()
        .flatten()
        .fold(f64::INFINITY, |least, value| least.min(value.abs()));
    let tolerance = 2.0 * RELATIVE_TOLERANCE * least.max(1e-6 * scale);
    let tail: f64 = (0..NODES)
        .flat_map(|j| (0..NODES).map(move |i| (j, i)))
        .filter(|&(j, i)| j + 1 >= NODES || i + 1 >= NODES)
        .map(|(j, i)| coefficients[j][i].abs())
        .sum();
    if tail > tolerance {
        return None;
    }
    // A bend that lies between the nodes shows at other points only.
    let mut worst = tail;
    for (s, t) in [(0.11, 0.13), (-0.57, 0.61), (0.63, -0.59), (-0.93, -0.91), (0.92, 0.94)] {
        let truth = at(
            place(tile.x, tile.width, s),
            place(tile.y, tile.height, t),
            Care::Node,
            scratch,
        );
        let (ts, tt) = (polynomials(s), polynomials(t));
        let found: f64 = (0..NODES)
            .map(|j| tt[j] * (0..NODES).map(|i| ts[i] * coefficients[j][i]).sum::<f64>())
            .sum();
        worst = worst.max((found - truth.value).abs());
        if worst > tolerance {
            return None;
        }
    }
    let local = |extent: usize| -> Vec<[f64; NODES]> {
        (0..extent)
            .map(|k| polynomials((2.0 * k as f64 + 1.0) / extent as f64 - 1.0))
            .collect()
    };
    // One row of each polynomial, so that neighbours stand side by side in the vector units.
    let along_x = local(tile.width);
    let columns: [Vec<f64>; NODES] = std::array::from_fn(|i| along_x.iter().map(|t| t[i]).collect());
    let mut out = vec![0.0; tile.width * tile.height];
    for (ty, line) in local(tile.height).iter().zip(out.chunks_exact_mut(tile.width)) {
        let row: [f64; NODES] = std::array::from_fn(|i| (0..NODES).map(|j| ty[j] * coefficients[j][i]).sum());
        evaluate(&row, &columns, line);
    }
    Some((out, (error + worst) * (tile.width * tile.height) as f64))
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn evaluate(row: &[f64; NODES], columns: &[Vec<f64>; NODES], line: &mut [f64]) {
    let [c0, c1, c2, c3, c4, c5, c6] = columns;
    let terms = c0.iter().zip(c1).zip(c2).zip(c3).zip(c4).zip(c5).zip(c6);
    for (value, ((((((t0, t1), t2), t3), t4), t5), t6)) in line.iter_mut().zip(terms) {
        *value = row[0] * t0 + row[1] * t1 + row[2] * t2 + row[3] * t3 + row[4] * t4 + row[5] * t5 + row[6] * t6;
    }
}

fn chebyshev_node(k: usize) -> f64 {
    -(std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64).cos()
}

fn polynomials(x: f64) -> [f64; NODES] {
    let mut t = [1.0; NODES];
    t[1] = x;
    for k in 2..NODES {
        t[k] = 2.0 * x * t[k - 1] - t[k - 2];
    }
    t
}

fn coefficients(values: &[[f64; NODES]; NODES]) -> [[f64; NODES]; NODES] {
    let basis: [[f64; NODES]; NODES] = std::array::from_fn(|k| polynomials(chebyshev_node(k)));
    let weight = |order: usize| if order == 0 { 1.0 } else { 2.0 } / NODES as f64;
    std::array::from_fn(|b| {
        std::array::from_fn(|a| {
            let mut sum = 0.0;
            for (j, row) in values.iter().enumerate() {
                for (i, value) in row.iter().enumerate() {
                    sum += value * basis[i][a] * basis[j][b];
                }
            }
            sum * weight(a) * weight(b)
        })
    })
}
