//! Large maps: where the light is smooth over many pixels, a polynomial through Chebyshev points replaces the quadrature
//! of each pixel.
//!
//! The function that is interpolated is the mean over a pixel-sized window centred anywhere, so that nothing is lost by the
//! pixels' own integration. A tile is taken when the last Chebyshev coefficients are below the tolerance and five points
//! between the nodes confirm it; else it is quartered, down to single pixels.

use rayon::prelude::*;

use crate::inverse::Bound;
use crate::number::{self, Care, Fit, Number, TERMS};
use crate::patch::Scratch;
use crate::rules::Estimate;
use crate::sensor::Sensor;

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

/// What fills a map.
struct Filler<'a, F, S> {
    at: &'a F,
    smooth: &'a S,
    fit: Fit,
    nx: usize,
}

/// Fills `map` (`[iy * nx + ix]`) from `at(x, y)`, the value centred at (x, y) in pixels; `smooth(x, y, half)` tells whether no
/// sharp kink crosses the square of `half` pixels round (x, y).
pub(crate) fn fill<N, F, S>(sensor: &Sensor, map: &mut [N], at: F, smooth: S) -> Bound
where
    N: Number,
    F: Fn(f64, f64, Care, &mut Scratch) -> Estimate + Sync,
    S: Fn(f64, f64, f64) -> bool + Sync,
{
    let longest = sensor.nx.max(sensor.ny);
    let side = if longest > 2 * SMALL { TILE } else { SMALL };
    let side = side.min(longest.div_ceil(4));
    let filler = Filler {
        at: &at,
        smooth: &smooth,
        fit: Fit::new(),
        nx: sensor.nx,
    };
    // Bands of tiles: each thread writes into rows of its own.
    let bound = map
        .par_chunks_mut(side * sensor.nx)
        .enumerate()
        .map_init(Scratch::default, |scratch, (band, rows)| {
            let height = rows.len() / sensor.nx;
            let mut found = Bound::default();
            for x in (0..sensor.nx).step_by(side) {
                let tile = Tile {
                    x,
                    y: 0,
                    width: side.min(sensor.nx - x),
                    height,
                };
                filler.solve(tile, (band * side) as f64, rows, scratch, &mut found);
            }
            found
        })
        .reduce(Bound::default, Bound::joined);
    Bound {
        mean_lx: bound.mean_lx / sensor.pixels() as f64,
        ..bound
    }
}

impl<F, S> Filler<'_, F, S>
where
    F: Fn(f64, f64, Care, &mut Scratch) -> Estimate,
    S: Fn(f64, f64, f64) -> bool,
{
    /// Fills a tile of the band that begins at row `top`; adds to the sum of bounds and the largest relative one.
    fn solve<N: Number>(&self, tile: Tile, top: f64, rows: &mut [N], scratch: &mut Scratch, found: &mut Bound) {
        if tile.width <= SMALL || tile.height <= SMALL {
            for iy in tile.y..tile.y + tile.height {
                for ix in tile.x..tile.x + tile.width {
                    let one = (self.at)(ix as f64 + 0.5, top + iy as f64 + 0.5, Care::Itself, scratch);
                    rows[iy * self.nx + ix] = N::of(one.value);
                    found.add_one(Estimate {
                        error: one.error + N::ROUNDING * one.value.abs(),
                        ..one
                    });
                }
            }
            return;
        }
        let half = 0.5 * tile.width.max(tile.height) as f64;
        let middle = [
            tile.x as f64 + 0.5 * tile.width as f64,
            top + tile.y as f64 + 0.5 * tile.height as f64,
        ];
        if (self.smooth)(middle[0], middle[1], half) && self.interpolate(tile, top, rows, scratch, found) {
            return;
        }
        let (left, upper) = (tile.width / 2, tile.height / 2);
        for (x, width) in [(0, left), (left, tile.width - left)] {
            for (y, height) in [(0, upper), (upper, tile.height - upper)] {
                let quarter = Tile {
                    x: tile.x + x,
                    y: tile.y + y,
                    width,
                    height,
                };
                self.solve(quarter, top, rows, scratch, found);
            }
        }
    }

    /// Fills a tile with one polynomial, if it is good enough.
    fn interpolate<N: Number>(
        &self,
        tile: Tile,
        top: f64,
        rows: &mut [N],
        scratch: &mut Scratch,
        found: &mut Bound,
    ) -> bool {
        let nodes = number::nodes();
        let mut at = |s: f64, t: f64| {
            let place = |origin: f64, extent: usize, s: f64| origin + 0.5 * extent as f64 * (1.0 + s);
            let (x, y) = (
                place(tile.x as f64, tile.width, s),
                place(top + tile.y as f64, tile.height, t),
            );
            (self.at)(x, y, N::NODE, scratch)
        };
        let mut values = [[0.0; TERMS]; TERMS];
        let (mut error, mut scale, mut least) = (0.0, 0.0_f64, f64::INFINITY);
        for (row, t) in values.iter_mut().zip(nodes) {
            for (value, s) in row.iter_mut().zip(nodes) {
                let one = at(s, t);
                *value = one.value;
                error += one.error / (TERMS * TERMS) as f64;
                scale = scale.max(one.value.abs());
                least = least.min(one.value.abs());
            }
        }
        let tolerance = 2.0 * N::AIM * least.max(1e-6 * scale);
        // Rows, then columns: [power of t][power of s].
        let mut worst = 0.0_f64;
        let mut along = [[0.0; TERMS]; TERMS];
        for (coefficients, row) in along.iter_mut().zip(&values) {
            let (found, tail) = self.fit.polynomial(row);
            *coefficients = found;
            worst = worst.max(tail);
        }
        let mut powers = [[0.0; TERMS]; TERMS];
        for k in 0..TERMS {
            let (_, tail) = self.fit.polynomial(&values.map(|row| row[k]));
            worst = worst.max(tail);
            let (found, _) = self.fit.polynomial(&along.map(|row| row[k]));
            for (row, value) in powers.iter_mut().zip(found) {
                row[k] = value;
            }
        }
        if worst > tolerance {
            return false;
        }
        let row_at = |t: f64| {
            let mut row = powers[TERMS - 1];
            for power in powers.iter().rev().skip(1) {
                for k in 0..TERMS {
                    row[k] = row[k] * t + power[k];
                }
            }
            row
        };
        // A bend that lies between the nodes shows at other points only.
        for (s, t) in [(0.11, 0.13), (-0.57, 0.61), (0.63, -0.59), (-0.93, -0.91), (0.92, 0.94)] {
            let truth = at(s, t);
            let polynomial = row_at(t).iter().rev().fold(0.0, |sum, c| sum * s + c);
            worst = worst.max((polynomial - truth.value).abs());
            if worst > tolerance {
                return false;
            }
        }
        let (width, height) = (tile.width as f64, tile.height as f64);
        for iy in 0..tile.height {
            let row = row_at((2.0 * iy as f64 + 1.0) / height - 1.0);
            let start = (tile.y + iy) * self.nx + tile.x;
            N::fill(
                &row,
                width.recip() - 1.0,
                2.0 / width,
                &mut rows[start..start + tile.width],
            );
        }
        // What lies between the points looked at.
        let error = error + 2.0 * worst;
        found.add(
            width * height,
            error + N::ROUNDING * powers[0][0].abs(),
            error + N::ROUNDING * scale,
            if least > 0.0 { error / least } else { 0.0 } + N::ROUNDING,
        );
        true
    }
}
