//! Point emitters before many small pixels: a row of pixels is a straight line of sight, cut where it crosses a kink of the
//! interpolant. Between two cuts the light is analytic, and one polynomial through eight exact values fills the pixels. Where
//! the same kinks follow each other along all rows of a block, its coefficients are polynomials of the row as well.
//!
//! The value at a pixel's centre stands for its mean where the bound of what that neglects (the light's curvature over the
//! pixel; a kink across it) is below the aim; pixels where it is not are computed by themselves.

#![expect(
    clippy::needless_range_loop,
    reason = "lanes and planes index several arrays at once"
)]

mod bend;
mod block;
mod crossings;
mod lamp;
mod slopes;

use rayon::prelude::*;

use self::block::{Block, FEW, at_row};
use self::lamp::Lamp;
use crate::angles::{self, LANES, Lanes, Sights};
use crate::bound::Bound;
use crate::number::{self, Fit, Number, RUN, TERMS};
use crate::rules::Estimate;
use crate::sensor::Sensor;
use crate::source::Source;
use crate::table::Bilinear;

/// Rows shorter than this are left to the other ways.
const SHORTEST: usize = 48;
/// Pixels a cut below which rows are no longer worth cutting.
const SPARSE: usize = 4;

/// Rows that share polynomials.
const BLOCK: usize = 64;

/// What all coefficients beyond the last two of a polynomial add, in terms of these two, with a margin: they fall at least by
/// half from one to the next on pieces that are accepted.
const BEYOND: f64 = 2.0;

/// A source of points before a sensor whose pixels are small.
pub(crate) struct Rows<'a> {
    nx: usize,
    ny: usize,
    lamps: Vec<Lamp<'a>>,
    fit: Fit,
    nodes: Lanes,
    /// Relative: share of the aim of a polynomial, and bound of what centres neglect.
    tail: f64,
    neglected: f64,
}

/// Working memory of one thread.
#[derive(Default)]
struct Work {
    /// Place of each cut and the number of its kink.
    cuts: Vec<(f64, u32)>,
    own: Vec<[usize; 2]>,
}

impl<'a> Rows<'a> {
    /// `None` where rows are short, the emitter is no set of points, or centres stand for too few pixels.
    pub fn new<N: Number>(source: &'a Source, sensor: &Sensor) -> Option<Self> {
        if sensor.nx < SHORTEST {
            return None;
        }
        let share = 0.3 * N::AIM;
        let mut neglected = 0.0_f64;
        let mut lamps = Vec::new();
        let mut cuts = 0;
        for part in source.parts() {
            // The parts' relative bounds hold for their sum where no part is negative.
            if part.share < 0.0 {
                return None;
            }
            let (lamp, missed) = Lamp::new(part, source.extinction_per_mm(), sensor, share, N::KINK)?;
            neglected = neglected.max(missed);
            cuts += lamp.planes.len() + 2 * lamp.cones.len();
            lamps.push(lamp);
        }
        (cuts * SPARSE < sensor.nx).then(|| Self {
            nx: sensor.nx,
            ny: sensor.ny,
            lamps,
            fit: Fit::new(),
            nodes: number::nodes(),
            tail: share,
            neglected,
        })
    }

    /// Fills `map`, `[iy * nx + ix]`, in lx; `exact(ix, iy)` is the mean over a pixel for which its centre does not stand.
    pub fn fill<N: Number>(&self, map: &mut [N], exact: impl Fn(usize, usize) -> Estimate + Sync) -> Bound {
        let bound = map
            .par_chunks_mut(BLOCK * self.nx)
            .enumerate()
            .map_init(Work::default, |work, (index, rows)| {
                let mut bound = Bound::default();
                self.rows(index * BLOCK, rows, work, &exact, &mut bound);
                bound
            })
            .reduce(Bound::default, Bound::joined);
        Bound {
            mean_lx: bound.mean_lx / (self.nx * self.ny) as f64,
            ..bound
        }
    }

    /// Fills a block of rows, or its halves where kinks cross each other within it.
    fn rows<N: Number>(
        &self,
        first: usize,
        rows: &mut [N],
        work: &mut Work,
        exact: &impl Fn(usize, usize) -> Estimate,
        bound: &mut Bound,
    ) {
        let count = rows.len() / self.nx;
        let block = self.block(first, count, work);
        if block.is_none() && count >= 2 * FEW {
            let (upper, lower) = rows.split_at_mut(count / 2 * self.nx);
            self.rows(first, upper, work, exact, bound);
            self.rows(first + count / 2, lower, work, exact, bound);
            return;
        }
        for (row, line) in rows.chunks_exact_mut(self.nx).enumerate() {
            self.row(first + row, line, block.as_ref(), work, exact, bound);
        }
    }

    /// Places along row `y` at which a kink passes, rising, and the row's end.
    fn cut(&self, y: f64, cuts: &mut Vec<(f64, u32)>) {
        let end = self.nx as f64;
        cuts.clear();
        let mut kink = 0;
        let mut add = |u: Option<f64>| {
            kink += 1;
            cuts.extend(u.filter(|u| *u > 0.0 && *u < end).map(|u| (u, kink)));
        };
        for lamp in &self.lamps {
            let a = lamp.corner + y * lamp.step_y;
            for plane in &lamp.planes {
                add(lamp.plane_crossing(a, plane.turn));
            }
            for cone in &lamp.cones {
                for u in lamp.cone_crossings(a, cone.cosine) {
                    add(u);
                }
            }
        }
        cuts.push((end, 0));
        cuts.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Fills one row; adds the bounds of its pixels.
    fn row<N: Number>(
        &self,
        iy: usize,
        line: &mut [N],
        block: Option<&Block>,
        work: &mut Work,
        exact: &impl Fn(usize, usize) -> Estimate,
        bound: &mut Bound,
    ) {
        let y = iy as f64 + 0.5;
        self.cut(y, &mut work.cuts);
        let block = block.filter(|block| block.kinks.iter().eq(work.cuts.iter().map(|cut| &cut.1)));
        let always = self.neglected + N::ROUNDING;
        let (mut from, mut low) = (0, 0.0);
        for (k, &(high, _)) in work.cuts.iter().enumerate() {
            let to = ((high - 0.5).ceil() as usize).min(self.nx);
            if to > from {
                if let Some((block, piece)) = block.and_then(|block| Some((block, block.pieces[k].as_ref()?))) {
                    let coefficients = at_row(&piece.powers, (y - block.middle) * block.per);
                    let per = 2.0 / (high - low);
                    let first = (from as f64 + 0.5 - low) * per - 1.0;
                    let end = (from + (to - from).next_multiple_of(RUN)).min(self.nx);
                    N::fill(&coefficients, first, per, &mut line[from..end]);
                    bound.add(
                        (to - from) as f64,
                        BEYOND * piece.tail + always * coefficients[0].abs(),
                        BEYOND * piece.tail + always * most(&coefficients),
                        BEYOND * piece.tail / piece.least + always,
                    );
                } else {
                    self.span(y, from, to, line, bound);
                }
                from = to;
            }
            low = high;
        }
        self.bend(iy, line);
        self.own_pixels(iy, work);
        for range in &work.own {
            for ix in range[0]..range[1] {
                let found = exact(ix, iy);
                line[ix] = N::of(found.value);
                bound.add_one(Estimate {
                    error: found.error + N::ROUNDING * found.value.abs(),
                    ..found
                });
            }
        }
    }

    /// Fills the pixels from..to, between which no kink passes.
    fn span<N: Number>(&self, y: f64, from: usize, to: usize, line: &mut [N], bound: &mut Bound) {
        let count = to - from;
        let middle = 0.5 * (from + to) as f64;
        let always = self.neglected + N::ROUNDING;
        if count <= RUN {
            for start in (from..to).step_by(LANES) {
                let last = to - 1;
                let mut u = [0.0; LANES];
                for (lane, u) in u.iter_mut().enumerate() {
                    *u = (start + lane).min(last) as f64 + 0.5;
                }
                let inner = if start == from {
                    (last - start).min(LANES - 1)
                } else {
                    0
                };
                let inner = if count <= LANES { inner / 2 } else { inner };
                let values = self.values(y, &u, inner);
                for (value, found) in line[start..to].iter_mut().zip(values) {
                    *value = N::of(found);
                    let error = always * found.abs();
                    bound.add(1.0, error, error, always);
                }
            }
            return;
        }
        let half = 0.5 * (count - 1) as f64;
        let mut u = self.nodes;
        for u in &mut u {
            *u = middle + half * *u;
        }
        let values = self.values(y, &u, LANES / 2);
        let (coefficients, tail) = self.fit.polynomial(&values);
        let mut least = f64::INFINITY;
        for value in values {
            least = if value.abs() < least { value.abs() } else { least };
        }
        if tail <= self.tail * least {
            let end = (from + count.next_multiple_of(RUN)).min(self.nx);
            N::fill(&coefficients, -1.0, half.recip(), &mut line[from..end]);
            bound.add(
                count as f64,
                BEYOND * tail + always * coefficients[0].abs(),
                BEYOND * tail + always * most(&coefficients),
                if least > 0.0 { BEYOND * tail / least } else { 0.0 } + always,
            );
            return;
        }
        // What resists is the neighbourhood of the axis.
        let near = self.lamps[0].nearest_to_axis(y);
        let cut = if (near - middle).abs() < 0.9 * half {
            near.round() as usize
        } else {
            usize::midpoint(from, to)
        };
        let cut = cut.clamp(from + 1, to - 1);
        self.span(y, from, cut, line, bound);
        self.span(y, cut, to, line, bound);
    }

    /// Light at the places `u` of row `y`, all in the cells that hold the place `inner`, lx.
    fn values(&self, y: f64, u: &Lanes, inner: usize) -> Lanes {
        let mut sum = [0.0; LANES];
        for lamp in &self.lamps {
            let light = lamp.light;
            let sights = angles::along(lamp.corner + y * lamp.step_y, lamp.step_x, light.toward, u);
            let Some(cell) = light.table.bilinear(sights.c[inner], sights.gamma[inner]) else {
                continue;
            };
            shine(&cell, &sights, lamp.share, light.extinction_per_mm, &mut sum);
        }
        sum
    }
}

/// What a polynomial does not exceed on [−1, 1].
fn most(coefficients: &[f64; TERMS]) -> f64 {
    coefficients.iter().map(|c| c.abs()).sum()
}

/// Adds the light of a bilinear cell along the lines of sight.
fn shine(cell: &Bilinear, sights: &Sights, share: f64, extinction_per_mm: f64, sum: &mut [f64; TERMS]) {
    let mut light = [0.0; LANES];
    cell_light(cell, sights, share, &mut light);
    if extinction_per_mm > 0.0 {
        for (value, length) in light.iter_mut().zip(sights.length) {
            *value *= (-extinction_per_mm * length).exp();
        }
    }
    for (sum, value) in sum.iter_mut().zip(light) {
        *sum += value;
    }
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn cell_light(cell: &Bilinear, sights: &Sights, share: f64, out: &mut Lanes) {
    let [ll, lh, hl, hh] = cell.corner;
    for lane in 0..LANES {
        let t = (sights.gamma[lane] - cell.gamma) * cell.per_gamma;
        let s = (sights.c[lane] - cell.c) * cell.per_c;
        let low = ll + t * (lh - ll);
        let high = hl + t * (hh - hl);
        out[lane] = share * sights.per_cd[lane] * (low + s * (high - low));
    }
}
