//! Large maps: where the light is smooth over many pixels, a polynomial through Chebyshev points replaces the
//! quadrature of each pixel.
//!
//! The function that is interpolated is the mean over a pixel-sized window centred anywhere, so that nothing is lost by
//! the pixels' own integration. A tile is taken when the last Chebyshev coefficients are below the tolerance and eight
//! points between the nodes confirm it; else it is quartered, down to single pixels.

use rayon::prelude::*;

use super::Bound;
use super::prepared::Prepared;
use crate::angles::{LANES, Lanes};
use crate::crossings::Scratch;
use crate::polynomial::{self, Fit, ROUNDING, TERMS};
use crate::product::Rule;
use crate::rules::Estimate;
use crate::sensor::Sensor;

/// Sides of the first tiles, in pixels.
const TILE: usize = 512;
/// Below this side, each pixel is computed by itself.
const SMALL: usize = 12;

/// Places between the nodes at which a polynomial is looked at: along s and along t.
const BETWEEN: [Lanes; 2] = [
    [0.11, -0.57, 0.63, -0.93, 0.92, -0.28, 0.35, -0.97],
    [0.13, 0.61, -0.59, -0.91, 0.94, -0.22, 0.97, 0.31],
];

#[derive(Clone, Copy)]
struct Tile {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

/// What fills a map.
struct Filler<'a> {
    prepared: &'a Prepared<'a>,
    fit: Fit,
    nx: usize,
}

/// Fills `map` (`[iy * nx + ix]`).
pub(super) fn fill(prepared: &Prepared<'_>, sensor: &Sensor, map: &mut [f64]) -> Bound {
    let longest = sensor.nx.max(sensor.ny);
    let side = if longest > 2 * SMALL { TILE } else { SMALL };
    let side = side.min(longest.div_ceil(4));
    let filler = Filler {
        prepared,
        fit: Fit::new(),
        nx: sensor.nx,
    };
    // Bands of tiles: each thread writes into rows of its own.
    map.par_chunks_mut(side * sensor.nx)
        .enumerate()
        .map_init(Scratch::default, |scratch, (band, rows)| {
            let height = rows.len() / sensor.nx;
            let mut found = Bound::default();
            for x in (0..sensor.nx).step_by(side) {
                if prepared.source.is_stopped() {
                    break;
                }
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
        .reduce(Bound::default, Bound::joined)
        .over(sensor.pixels())
}

impl Filler<'_> {
    /// Fills a tile of the band that begins at row `top`; adds to the sum of bounds and the largest ones.
    fn solve(&self, tile: Tile, top: f64, rows: &mut [f64], scratch: &mut Scratch, found: &mut Bound) {
        let half = 0.5 * tile.width.max(tile.height) as f64;
        let middle = [
            tile.x as f64 + 0.5 * tile.width as f64,
            top + tile.y as f64 + 0.5 * tile.height as f64,
        ];
        let small = tile.width <= SMALL || tile.height <= SMALL;
        let smooth = !small && self.prepared.routes.polynomials && self.prepared.is_smooth(middle[0], middle[1], half);
        let common = if small || smooth {
            self.prepared.common(middle[0], middle[1], half)
        } else {
            None
        };
        if smooth && self.interpolate(tile, top, common.as_ref(), rows, scratch, found) {
            return;
        }
        if small {
            self.each(tile, top, common.as_ref(), rows, scratch, found);
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

    /// Fills a tile pixel by pixel.
    fn each(
        &self,
        tile: Tile,
        top: f64,
        common: Option<&(Vec<&Rule>, f64)>,
        rows: &mut [f64],
        scratch: &mut Scratch,
        found: &mut Bound,
    ) {
        let allowed = self.prepared.allowed;
        for iy in tile.y..tile.y + tile.height {
            let y = top + iy as f64 + 0.5;
            let row = &mut rows[iy * self.nx + tile.x..][..tile.width];
            if let Some((rules, error)) = common {
                for (run, values) in row.chunks_mut(LANES).enumerate() {
                    let x = std::array::from_fn(|lane| (tile.x + run * LANES + lane) as f64 + 0.5);
                    let several = self.prepared.several(rules, &x, &[y; LANES]);
                    values.copy_from_slice(&several[..values.len()]);
                }
                for &value in &*row {
                    found.add_one(Estimate { value, error: *error }, allowed);
                }
                continue;
            }
            for (ix, value) in row.iter_mut().enumerate() {
                let one = self.prepared.pixel((tile.x + ix) as f64 + 0.5, y, scratch);
                *value = one.value;
                found.add_one(one, allowed);
            }
        }
    }

    /// Fills a tile with one polynomial, if it is good enough.
    fn interpolate(
        &self,
        tile: Tile,
        top: f64,
        common: Option<&(Vec<&Rule>, f64)>,
        rows: &mut [f64],
        scratch: &mut Scratch,
        found: &mut Bound,
    ) -> bool {
        let nodes = polynomial::nodes();
        let place = |origin: f64, extent: usize, s: f64| origin + 0.5 * extent as f64 * (1.0 + s);
        let (left, upper) = (tile.x as f64, top + tile.y as f64);
        // The light at eight places of the tile, and the mean of the bounds.
        let mut eight = |s: &Lanes, t: &Lanes| -> (Lanes, f64) {
            let (x, y) = (
                s.map(|s| place(left, tile.width, s)),
                t.map(|t| place(upper, tile.height, t)),
            );
            if let Some((rules, error)) = common {
                return (self.prepared.several(rules, &x, &y), *error);
            }
            let mut error = 0.0;
            let values = std::array::from_fn(|lane| {
                let one = self.prepared.pixel(x[lane], y[lane], scratch);
                error += one.error / LANES as f64;
                one.value
            });
            (values, error)
        };
        let mut values = [[0.0; TERMS]; TERMS];
        let mut error = 0.0;
        for (row, t) in values.iter_mut().zip(nodes) {
            let (found, bound) = eight(&nodes, &[t; LANES]);
            *row = found;
            error += bound / TERMS as f64;
        }
        let size = || values.iter().flatten().map(|value| value.abs());
        let (scale, least) = (size().fold(0.0, f64::max), size().fold(f64::INFINITY, f64::min));
        let tolerance = self.prepared.tolerances.polynomial * least.max(self.prepared.allowed.dim_lx);
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
        let (truth, _) = eight(&BETWEEN[0], &BETWEEN[1]);
        for (lane, truth) in truth.into_iter().enumerate() {
            let polynomial = row_at(BETWEEN[1][lane])
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * BETWEEN[0][lane] + c);
            worst = worst.max((polynomial - truth).abs());
        }
        if worst > tolerance {
            return false;
        }
        let (width, height) = (tile.width as f64, tile.height as f64);
        for iy in 0..tile.height {
            let row = row_at((2.0 * iy as f64 + 1.0) / height - 1.0);
            let start = (tile.y + iy) * self.nx + tile.x;
            polynomial::fill(
                &row,
                width.recip() - 1.0,
                2.0 / width,
                &mut rows[start..start + tile.width],
            );
        }
        // What lies between the points looked at.
        let error = error + 2.0 * worst + ROUNDING * scale;
        found.add(width * height, error, least, self.prepared.allowed);
        true
    }
}
