//! Rays from the emitter, drawn from the very interpolant that the inverse solver evaluates.
//!
//! The density of directions is I(C, γ)·sin γ dγ dC. The grid is refined (which leaves the interpolant as it is) until its
//! cells are small where the sensor can be reached; a cell is drawn by its flux, γ within it by inverting the exact integral
//! of (linear × sine), C by inverting the linear density at that γ. Cells that no ray can leave towards the sensor stand at
//! the end of the list: a ray's first number says whether it matters, and the flux of the others is the cone of the
//! thinned mode.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3};

use crate::random::{unit32, unit53};
use crate::sensor::Sensor;
use crate::source::{Part, Shape, Source};
use crate::table::Table;

/// Largest width in radians of a cell that reaches the sensor: the Taylor series of sine and cosine are exact to 1e-15.
const WIDTH: f64 = 0.05;
/// Patches along each side that stand for the sensor when cells are sorted.
const PATCHES: usize = 16;

/// A ray: origin in mm and unit direction, luminaire frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it leaves.
    pub origin: DVec3,
    /// Where it goes, unit length.
    pub direction: DVec3,
}

/// One cell of a refined grid.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    part: u32,
    gamma: f64,
    pub(crate) d_gamma: f64,
    pub(crate) sin_gamma: f64,
    pub(crate) cos_gamma: f64,
    pub(crate) sin_c: f64,
    pub(crate) cos_c: f64,
    pub(crate) d_c: f64,
    /// Intensities at (C, γ) corners: low-low, low-high γ, high-low, high-high.
    pub(crate) corner: [f64; 4],
    /// Mean over C at the lower and the upper γ, sine of the upper γ, and the integral of (linear × sine) between them.
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) end_sine: f64,
    pub(crate) whole: f64,
}

/// The emitter's rays, sorted by whether they can reach a given sensor.
#[derive(Debug, Clone)]
pub struct Emission {
    parts: Vec<(Shape, Option<DMat3>)>,
    cells: Vec<Cell>,
    /// Flux up to the end of each reaching cell over the whole flux.
    cumulative: Vec<f64>,
    guide: Vec<u32>,
    flux_lm: f64,
    refused_lm: f64,
}

impl Emission {
    /// The rays of `source`, refined round the directions of `sensor`.
    pub fn new(source: &Source, sensor: &Sensor) -> Self {
        let mut cells = Vec::new();
        let mut fluxes = Vec::new();
        let (mut total, mut refused) = (Sum::default(), Sum::default());
        for (index, part) in source.parts().iter().enumerate() {
            let targets = targets(part, sensor);
            let grid = Grid::of(&part.table, &targets);
            for ic in 0..grid.c.len() - 1 {
                for ig in 0..grid.gamma.len() - 1 {
                    let (cell, flux) = grid.cell(&part.table, index as u32, ic, ig);
                    let flux = flux * part.share;
                    let negative = grid.negative(&part.table, ic, ig) * part.share;
                    refused.add(negative);
                    if flux > 0.0 {
                        total.add(flux);
                        if cell_reaches(&cell, &targets) {
                            cells.push(cell);
                            fluxes.push(flux);
                        }
                    }
                }
            }
        }
        let flux_lm = total.value();
        let mut run = Sum::default();
        let cumulative: Vec<f64> = fluxes
            .iter()
            .map(|flux| {
                run.add(*flux);
                run.value() / flux_lm
            })
            .collect();
        let guide = guide(&cumulative);
        let parts = source.parts().iter().map(|part| (part.shape, part.aim)).collect();
        Self {
            parts,
            cells,
            cumulative,
            guide,
            flux_lm,
            refused_lm: refused.value(),
        }
    }

    /// Flux of the emitter in lm: the exact integral of the interpolant where it is positive.
    pub fn flux_lm(&self) -> f64 {
        self.flux_lm
    }

    /// Negative flux that no ray can carry (readings below zero in the distribution), lm.
    pub fn refused_lm(&self) -> f64 {
        self.refused_lm
    }

    /// Share of the flux that leaves through cells from which the sensor can be reached.
    pub fn cone(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// The ray for a first number `u` below [`Emission::cone`] and four words; `None` for a ray of the other cells.
    #[inline]
    pub fn ray(&self, u: f64, words: [u32; 4]) -> Option<Ray> {
        let cell = self.cell_of(u)?;
        let (shape, aim) = self.parts[cell.part as usize];
        let direction = cell.direction(unit32(words[0]), unit32(words[1]));
        let origin = shape.point(unit32(words[2]), unit32(words[3]));
        Some(Ray {
            origin,
            direction: aim.map_or(direction, |aim| aim * direction),
        })
    }

    /// Shape and aim of the part that a cell belongs to.
    #[inline]
    pub(crate) fn part(&self, cell: &Cell) -> &(Shape, Option<DMat3>) {
        &self.parts[cell.part as usize]
    }

    /// Cells from which the sensor can be reached, each with its share of what the cells from it on emit.
    pub(crate) fn shares(&self) -> impl Iterator<Item = (&Cell, f64)> {
        let last = self.cone();
        let mut before = 0.0;
        self.cells.iter().zip(&self.cumulative).map(move |(cell, &end)| {
            let share = if end >= last {
                1.0
            } else {
                (end - before) / (last - before)
            };
            before = end;
            (cell, share)
        })
    }

    #[inline]
    pub(crate) fn cell_of(&self, u: f64) -> Option<&Cell> {
        let last = *self.cumulative.last()?;
        if u >= last {
            return None;
        }
        let bucket = (u / last * (self.guide.len() - 1) as f64) as usize;
        let mut index = self.guide[bucket.min(self.guide.len() - 1)] as usize;
        while self.cumulative[index] <= u {
            index += 1;
        }
        Some(&self.cells[index])
    }
}

/// First cell of each of equal shares of the cone.
fn guide(cumulative: &[f64]) -> Vec<u32> {
    let Some(&last) = cumulative.last() else { return vec![0] };
    let buckets = (4 * cumulative.len()).next_power_of_two();
    let mut index = 0;
    (0..=buckets)
        .map(|bucket| {
            let start = last * (bucket as f64 / buckets as f64) * (1.0 - 1e-12);
            while index + 1 < cumulative.len() && cumulative[index] <= start {
                index += 1;
            }
            index as u32
        })
        .collect()
}

impl Cell {
    /// Direction for two numbers in (0, 1).
    #[inline]
    fn direction(&self, u: f64, w: f64) -> DVec3 {
        let [ll, lh, hl, hh] = self.corner;
        let (t, sin_gamma, cos_gamma) = self.gamma(u);
        // C: linear between the values at this γ.
        let s = linear(w, ll + t * (lh - ll), hl + t * (hh - hl));
        let (sin, versine) = small_sin_versine(s * self.d_c);
        let cos = 1.0 - versine;
        let (sin_c, cos_c) = (self.sin_c * cos + self.cos_c * sin, self.cos_c * cos - self.sin_c * sin);
        DVec3::new(sin_gamma * cos_c, sin_gamma * sin_c, cos_gamma)
    }

    /// Inverts ∫ (low + (high − low)·t)·sin γ by Newton, kept in [0, 1], from the inverse of the linear density through
    /// its ends. Returns t, sin γ and cos γ.
    #[inline]
    fn gamma(&self, u: f64) -> (f64, f64, f64) {
        let (h, low, high) = (self.d_gamma, self.low, self.high);
        let slope = (high - low) / h;
        let aim = u * self.whole;
        let mut t = linear(u, low * self.sin_gamma, high * self.end_sine);
        for _ in 0..3 {
            let (sin, versine) = small_sin_versine(t * h);
            let cos = 1.0 - versine;
            let sin_gamma = self.sin_gamma * cos + self.cos_gamma * sin;
            let cos_gamma = self.cos_gamma * cos - self.sin_gamma * sin;
            // cos γ0 − cos γ and sin γ − sin γ0 without cancellation.
            let fall = self.sin_gamma * sin + self.cos_gamma * versine;
            let rise = self.cos_gamma * sin - self.sin_gamma * versine;
            let value = low * fall + slope * (rise - t * h * cos_gamma);
            let density = (low + (high - low) * t) * sin_gamma * h;
            t = (t - (value - aim) / density.max(1e-300)).clamp(0.0, 1.0);
        }
        let (sin, versine) = small_sin_versine(t * h);
        let cos = 1.0 - versine;
        (
            t,
            self.sin_gamma * cos + self.cos_gamma * sin,
            self.cos_gamma * cos - self.sin_gamma * sin,
        )
    }
}

/// Inverse CDF on [0, 1] of a density linear from `a` to `b`.
#[inline]
fn linear(u: f64, a: f64, b: f64) -> f64 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    let sum = a + root;
    if sum > 0.0 {
        (u * (a + b) / sum).clamp(0.0, 1.0)
    } else {
        u
    }
}

/// (1 − cos x)/x² and sin x/x as series in x².
pub(crate) const SERIES: [[f64; 9]; 2] = {
    let mut series = [[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0; 9]];
    let mut k = 1;
    while k < 9 {
        let even = 2.0 * k as f64;
        series[0][k] = -series[0][k - 1] / ((even + 1.0) * (even + 2.0));
        series[1][k] = -series[1][k - 1] / (even * (even + 1.0));
        k += 1;
    }
    series
};

/// The same for angles up to 0.11.
const SHORT: [[f64; 5]; 2] = {
    let mut short = [[0.0; 5]; 2];
    let mut k = 0;
    while k < 5 {
        short[0][k] = SERIES[0][k];
        short[1][k] = SERIES[1][k];
        k += 1;
    }
    short
};

/// Sine and versine (1 − cos) by `series`: products alone, so that nothing divides in the vector units.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub(crate) fn sin_versine<const N: usize>(x: f64, series: &[[f64; N]; 2]) -> (f64, f64) {
    let y = x * x;
    let (mut versine, mut sin) = (series[0][N - 1], series[1][N - 1]);
    for k in (0..N - 1).rev() {
        versine = versine * y + series[0][k];
        sin = sin * y + series[1][k];
    }
    (x * sin, y * versine)
}

/// Sine and versine of an angle up to 0.11.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub(crate) fn small_sin_versine(x: f64) -> (f64, f64) {
    sin_versine(x, &SHORT)
}

/// Balls that cover the sensor as directions from a part's middle: direction, and angle that ball and emitter add with its
/// sine and cosine.
struct Targets {
    cap: Vec<(DVec3, f64, [f64; 2])>,
    gamma: [f64; 2],
    /// Middle and half width in C; half width π where the pole is near.
    c: [f64; 2],
}

fn targets(part: &Part, sensor: &Sensor) -> Targets {
    let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
    let centre = part.shape.centre();
    let (px, py) = (PATCHES.min(sensor.nx), PATCHES.min(sensor.ny));
    let step = DVec3::new(sensor.nx as f64 / px as f64, sensor.ny as f64 / py as f64, 0.0);
    let (a, b) = (step.x * sensor.step_x, step.y * sensor.step_y);
    let ball = 0.5 * (a + b).length().max((a - b).length()) + part.shape.radius();
    let mut cap = Vec::with_capacity(px * py);
    let mut gamma = [PI, 0.0];
    let middle = own(sensor.centre() - centre);
    let c0 = middle.y.atan2(middle.x);
    let mut half: f64 = 0.0;
    for iy in 0..py {
        for ix in 0..px {
            let to = own(sensor.point((ix as f64 + 0.5) * step.x, (iy as f64 + 0.5) * step.y) - centre);
            let distance = to.length();
            let angle = if ball < distance {
                (ball / distance).asin() * (1.0 + 1e-9)
            } else {
                PI
            };
            let g = to.x.hypot(to.y).atan2(to.z);
            gamma = [gamma[0].min(g - angle), gamma[1].max(g + angle)];
            let spread = if angle < g && g + angle < PI {
                (angle.sin() / g.sin()).min(1.0).asin()
            } else {
                PI
            };
            let away = (to.y.atan2(to.x) - c0 + PI).rem_euclid(TAU) - PI;
            half = half.max(away.abs() + spread);
            cap.push((to / distance, angle, angle.sin_cos().into()));
        }
    }
    Targets {
        cap,
        gamma: [gamma[0].max(0.0), gamma[1].min(PI)],
        c: [c0, half.min(PI)],
    }
}

fn cell_reaches(cell: &Cell, targets: &Targets) -> bool {
    let middle = {
        let (sin, cos) = (0.5 * cell.d_c).sin_cos();
        let (sin_c, cos_c) = (cell.sin_c * cos + cell.cos_c * sin, cell.cos_c * cos - cell.sin_c * sin);
        let g = cell.gamma + 0.5 * cell.d_gamma;
        DVec3::new(g.sin() * cos_c, g.sin() * sin_c, g.cos())
    };
    let most_sin = cell.sin_gamma.max((cell.gamma + cell.d_gamma).sin()).max(
        if cell.gamma < 0.5 * PI && cell.gamma + cell.d_gamma > 0.5 * PI {
            1.0
        } else {
            0.0
        },
    );
    // Half the diagonal, measured along γ and along the widest parallel: an upper bound on any distance within the cell.
    let radius = 0.5 * (cell.d_gamma + most_sin * cell.d_c) + 1e-12;
    let (sin, cos) = radius.sin_cos();
    targets.cap.iter().any(|&(to, angle, [angle_sin, angle_cos])| {
        angle + radius >= PI || middle.dot(to) >= angle_cos * cos - angle_sin * sin
    })
}

/// A grid with extra lines, none of which changes the interpolant.
struct Grid {
    c: Vec<f64>,
    gamma: Vec<f64>,
}

impl Grid {
    fn of(table: &Table, targets: &Targets) -> Self {
        let [from, to] = targets.gamma;
        // About 24 cells across the sensor, never wider than the series allow.
        let fine = ((to - from) / 24.0).clamp(1e-5, WIDTH);
        let gamma = refined(&refined(&table.gamma_rad, 0.0, PI, WIDTH), from, to, fine);
        let coarse: Vec<f64> = if table.is_rotational() {
            vec![0.0, TAU]
        } else {
            table.c_rad.clone()
        };
        let coarse = refined(&coarse, coarse[0], coarse[0] + TAU, 2.0 * WIDTH);
        let [middle, half] = targets.c;
        let c = if half >= PI {
            coarse
        } else {
            let fine = (2.0 * half / 24.0).clamp(1e-5, 2.0 * WIDTH);
            let from = coarse[0] + (middle - half - coarse[0]).rem_euclid(TAU);
            let to = from + 2.0 * half;
            if to > coarse[0] + TAU {
                let wrapped = refined(&coarse, from, coarse[0] + TAU, fine);
                refined(&wrapped, coarse[0], to - TAU, fine)
            } else {
                refined(&coarse, from, to, fine)
            }
        };
        Self { c, gamma }
    }

    fn cell(&self, table: &Table, part: u32, ic: usize, ig: usize) -> (Cell, f64) {
        let corner = self.corners(table, ic, ig).map(|value| value.max(0.0));
        let (gamma, c) = (self.gamma[ig], self.c[ic]);
        let (d_gamma, d_c) = (self.gamma[ig + 1] - gamma, self.c[ic + 1] - c);
        let flux = flux(gamma, d_gamma, d_c, corner);
        let (sin_gamma, cos_gamma) = gamma.sin_cos();
        let (sin_c, cos_c) = c.sin_cos();
        (
            Cell {
                part,
                gamma,
                d_gamma,
                sin_gamma,
                cos_gamma,
                sin_c,
                cos_c,
                d_c,
                corner,
                low: 0.5 * (corner[0] + corner[2]),
                high: 0.5 * (corner[1] + corner[3]),
                end_sine: (gamma + d_gamma).sin(),
                whole: flux / d_c,
            },
            flux,
        )
    }

    /// Flux of the negative values of the cell's corners.
    fn negative(&self, table: &Table, ic: usize, ig: usize) -> f64 {
        let corner = self.corners(table, ic, ig);
        if corner.iter().all(|value| *value >= 0.0) {
            return 0.0;
        }
        let gamma = self.gamma[ig];
        flux(
            gamma,
            self.gamma[ig + 1] - gamma,
            self.c[ic + 1] - self.c[ic],
            corner.map(|value| value.min(0.0)),
        )
    }

    fn corners(&self, table: &Table, ic: usize, ig: usize) -> [f64; 4] {
        // Values on a line of the grid come from its own side: the end of the γ range is inside.
        let c = [self.c[ic], self.c[ic + 1] - 1e-13];
        [
            table.at_rad(c[0], self.gamma[ig]),
            table.at_rad(c[0], self.gamma[ig + 1]),
            table.at_rad(c[1], self.gamma[ig]),
            table.at_rad(c[1], self.gamma[ig + 1]),
        ]
    }
}

/// Exact flux of a bilinear cell.
fn flux(gamma: f64, d_gamma: f64, d_c: f64, corner: [f64; 4]) -> f64 {
    let (low, high) = (0.5 * (corner[0] + corner[2]), 0.5 * (corner[1] + corner[3]));
    let (sin, cos) = d_gamma.sin_cos();
    let versine = 2.0 * (0.5 * d_gamma).sin().powi(2);
    let (s0, c0) = gamma.sin_cos();
    let (fall, rise) = (s0 * sin + c0 * versine, c0 * sin - s0 * versine);
    let slope = (high - low) / d_gamma;
    d_c * (low * fall + slope * (rise - d_gamma * (c0 * cos - s0 * sin)))
}

/// `grid` with lines at `from`, `to` and every `fine` between them (as far as they lie inside the grid).
fn refined(grid: &[f64], from: f64, to: f64, fine: f64) -> Vec<f64> {
    let mut out = Vec::new();
    for window in grid.windows(2) {
        let (a, b) = (window[0], window[1]);
        out.push(a);
        let (low, high) = (a.max(from), b.min(to));
        if low < high {
            let parts = ((high - low) / fine).ceil().max(1.0) as usize;
            for k in 0..=parts {
                out.push(low + (high - low) * k as f64 / parts as f64);
            }
        }
    }
    out.extend(grid.last());
    out.dedup_by(|b, a| *b - *a < 1e-12);
    out
}

/// Neumaier's compensated sum: exact to rounding, whatever the order of magnitude of the terms.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - next) + term
        } else {
            (term - next) + self.sum
        };
        self.sum = next;
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}

/// The first number of ray: 53 bits of two words.
#[inline]
pub(crate) fn first_number(words: [u32; 4]) -> f64 {
    unit53(words[0], words[1])
}

/// All of a table as an emission without a sensor: every cell, for ray files. Cells are at most 0.05 rad wide.
pub fn whole(source: &Source) -> Emission {
    // A sensor that surrounds nothing would sort every cell away: aim at a ball that holds the emitter instead.
    let sensor = Sensor {
        corner: DVec3::new(-1.0, -1.0, 0.0),
        step_x: DVec3::X * 2.0,
        step_y: DVec3::Y * 2.0,
        toward: DVec3::Z,
        nx: 1,
        ny: 1,
    };
    Emission::new(source, &sensor)
}
