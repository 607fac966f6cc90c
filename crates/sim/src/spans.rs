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

use glam::DVec3;
use rayon::prelude::*;

use crate::angles::{self, LANES, Lanes, Sights};
use crate::number::{self, Fit, Number, RUN, TERMS};
use crate::patch::Light;
use crate::rules::Estimate;
use crate::sensor::Sensor;
use crate::source::{Shape, Source};
use crate::table::{Bilinear, Table};

/// Rows shorter than this are left to the other ways.
const SHORTEST: usize = 48;
/// Pixels a cut below which rows are no longer worth cutting.
const SPARSE: usize = 4;

/// Rows that share polynomials.
const BLOCK: usize = 64;
/// Rows below which each makes its own.
const FEW: usize = 12;

/// What all coefficients beyond the last two of a polynomial add, in terms of these two, with a margin: they fall at least by
/// half from one to the next on pieces that are accepted.
const BEYOND: f64 = 2.0;

/// Intervals along each side of the sensor at which polar angles are looked at.
const SIDE: usize = 16;

/// What a map's errors do not exceed, as far as the rules can tell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bound {
    /// Mean over the map, lx.
    pub mean_lx: f64,
    /// Of any pixel, relative to itself.
    pub largest: f64,
    /// Of any pixel, lx.
    pub largest_lx: f64,
}

impl Bound {
    /// The bound of a map that was multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            mean_lx: factor * self.mean_lx,
            largest: self.largest,
            largest_lx: factor * self.largest_lx,
        }
    }
}

/// Bounds of pixels as they are filled: `mean_lx` holds their sum.
impl Bound {
    /// `pixels` that are off by `error` lx on the mean, by no more than `most` lx, and by no more than `relative` of themselves.
    pub(crate) fn add(&mut self, pixels: f64, error: f64, most: f64, relative: f64) {
        self.mean_lx += pixels * error;
        self.largest_lx = self.largest_lx.max(most);
        self.largest = self.largest.max(relative);
    }

    /// One pixel.
    pub(crate) fn add_one(&mut self, one: Estimate) {
        let relative = if one.value == 0.0 {
            0.0
        } else {
            one.error / one.value.abs()
        };
        self.add(1.0, one.error, one.error, relative);
    }

    pub(crate) fn joined(self, other: Self) -> Self {
        Self {
            mean_lx: self.mean_lx + other.mean_lx,
            largest: self.largest.max(other.largest),
            largest_lx: self.largest_lx.max(other.largest_lx),
        }
    }
}

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

/// One point and its table, in the frame in which the table stands upright. Places in pixels.
struct Lamp<'a> {
    light: Light<'a>,
    share: f64,
    corner: DVec3,
    step_x: DVec3,
    step_y: DVec3,
    planes: Vec<Plane>,
    cones: Vec<Cone>,
    /// Distance from the pole axis in mm below which a pixel's centre does not stand for it.
    axis: f64,
}

/// A half-plane of a grid line.
#[derive(Debug, Clone, Copy)]
struct Plane {
    line: usize,
    /// Sine and cosine of its azimuth.
    turn: [f64; 2],
    within: Within,
}

/// A cone of a grid line.
#[derive(Debug, Clone, Copy)]
struct Cone {
    line: usize,
    cosine: f64,
    within: Within,
}

/// What a kink asks of the pixels that it crosses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Within {
    /// Nothing: it bends too little.
    Soft,
    /// What a straight ramp over the pixel adds to the value at its centre.
    Ramp,
    /// Their own integral.
    Own,
}

/// Working memory of one thread.
#[derive(Default)]
struct Work {
    /// Place of each cut and the number of its kink.
    cuts: Vec<(f64, u32)>,
    own: Vec<[usize; 2]>,
}

/// Rows between which the same kinks follow each other.
struct Block {
    /// Row in the middle, and one over half the rows.
    middle: f64,
    per: f64,
    kinks: Vec<u32>,
    /// For each run between two cuts; `None` where the polynomials do not converge.
    pieces: Vec<Option<Piece>>,
}

/// A run of pixels through all rows of a block: `[power of the row][power of the place between its cuts]`.
struct Piece {
    powers: [[f64; TERMS]; TERMS],
    tail: f64,
    least: f64,
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
            let Shape::Point(centre) = part.shape else { return None };
            let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
            let mut lamp = Lamp {
                light: Light {
                    table: &part.table,
                    toward: own(sensor.toward),
                    extinction_per_mm: source.extinction_per_mm(),
                },
                share: part.share,
                corner: own(sensor.corner - centre),
                step_x: own(sensor.step_x),
                step_y: own(sensor.step_y),
                planes: Vec::new(),
                cones: Vec::new(),
                axis: 0.0,
            };
            // The parts' relative bounds hold for their sum where no part is negative.
            if part.share < 0.0 {
                return None;
            }
            neglected = neglected.max(lamp.prepare(sensor, share, N::KINK)?);
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

    /// The polynomials of a block of rows; `None` where kinks change their order within it.
    fn block(&self, first: usize, rows: usize, work: &mut Work) -> Option<Block> {
        if rows < FEW {
            return None;
        }
        let half = 0.5 * (rows - 1) as f64;
        let middle = first as f64 + 0.5 + half;
        let mut kinks: Vec<u32> = Vec::new();
        let mut places: [Vec<f64>; TERMS] = std::array::from_fn(|_| vec![0.0]);
        for (row, t) in places.iter_mut().zip(self.nodes) {
            self.cut(middle + half * t, &mut work.cuts);
            if kinks.is_empty() {
                kinks.extend(work.cuts.iter().map(|cut| cut.1));
            } else if !kinks.iter().eq(work.cuts.iter().map(|cut| &cut.1)) {
                return None;
            }
            row.extend(work.cuts.iter().map(|cut| cut.0));
        }
        let pieces = (0..kinks.len()).map(|k| self.piece(middle, half, k, &places)).collect();
        Some(Block {
            middle,
            per: half.recip(),
            kinks,
            pieces,
        })
    }

    fn piece(&self, middle: f64, half: f64, k: usize, places: &[Vec<f64>; TERMS]) -> Option<Piece> {
        let mut along = [[0.0; TERMS]; TERMS];
        let (mut tail, mut least) = (0.0_f64, f64::INFINITY);
        for ((coefficients, row), t) in along.iter_mut().zip(places).zip(self.nodes) {
            let (from, to) = (row[k], row[k + 1]);
            let mut u = self.nodes;
            for u in &mut u {
                *u = from + 0.5 * (to - from) * (1.0 + *u);
            }
            let values = self.values(middle + half * t, &u, LANES / 2);
            let (found, rest) = self.fit.polynomial(&values);
            *coefficients = found;
            tail = tail.max(rest);
            for value in values {
                least = if value.abs() < least { value.abs() } else { least };
            }
        }
        let mut powers = [[0.0; TERMS]; TERMS];
        for power in 0..TERMS {
            let mut column = [0.0; TERMS];
            for (value, row) in column.iter_mut().zip(&along) {
                *value = row[power];
            }
            let (found, rest) = self.fit.polynomial(&column);
            tail += rest;
            for (row, value) in powers.iter_mut().zip(found) {
                row[power] = value;
            }
        }
        (tail <= self.tail * least).then_some(Piece { powers, tail, least })
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

    /// Pixels of a row that centres do not stand for: near the pole axis, and across kinks that no ramp describes.
    fn own_pixels(&self, iy: usize, work: &mut Work) {
        work.own.clear();
        let edges = [iy as f64, iy as f64 + 0.5, iy as f64 + 1.0];
        for lamp in &self.lamps {
            if let Some([low, high]) = lamp.near_axis(edges[1]) {
                work.own.extend(self.whole(low, high));
            }
            for plane in lamp.planes.iter().filter(|plane| plane.within == Within::Own) {
                work.own.extend(self.by_plane(lamp, plane, edges));
            }
            for cone in lamp.cones.iter().filter(|cone| cone.within == Within::Own) {
                work.own.extend(self.by_cone(lamp, cone, edges).into_iter().flatten());
            }
        }
        // Each pixel once.
        work.own.sort_unstable();
        let mut kept: usize = 0;
        for k in 0..work.own.len() {
            let range = work.own[k];
            if kept > 0 && range[0] <= work.own[kept - 1][1] {
                work.own[kept - 1][1] = work.own[kept - 1][1].max(range[1]);
            } else {
                work.own[kept] = range;
                kept += 1;
            }
        }
        work.own.truncate(kept);
    }

    /// Adds to pixels of a row what a kink across them adds to the values at their centres.
    fn bend<N: Number>(&self, iy: usize, line: &mut [N]) {
        let y = iy as f64 + 0.5;
        let edges = [iy as f64, y, iy as f64 + 1.0];
        for lamp in &self.lamps {
            let table = lamp.light.table;
            let origin = lamp.corner + y * lamp.step_y + 0.5 * lamp.step_x;
            for cone in lamp.cones.iter().filter(|cone| cone.within == Within::Ramp) {
                let kink = table.gamma_rad[cone.line];
                for [from, to] in self.by_cone(lamp, cone, edges).into_iter().flatten() {
                    for (ix, value) in line.iter_mut().enumerate().take(to).skip(from) {
                        let v = origin + ix as f64 * lamp.step_x;
                        let (axis, square) = (v.x.hypot(v.y), v.length_squared());
                        let slope = |step: DVec3| (v.z * (v.x * step.x + v.y * step.y) / axis - axis * step.z) / square;
                        let added = ramp(angles::atan2(axis, v.z) - kink, slope(lamp.step_x), slope(lamp.step_y));
                        if added > 0.0 {
                            let c = angles::atan2(v.y, v.x);
                            *value = N::of(value.wide() + lamp.per_cd(v) * table.gamma_jump(cone.line, c) * added);
                        }
                    }
                }
            }
            for plane in lamp.planes.iter().filter(|plane| plane.within == Within::Ramp) {
                let [sin, cos] = plane.turn;
                let Some([from, to]) = self.by_plane(lamp, plane, edges) else {
                    continue;
                };
                for (ix, value) in line.iter_mut().enumerate().take(to).skip(from) {
                    let v = origin + ix as f64 * lamp.step_x;
                    let square = v.x * v.x + v.y * v.y;
                    let ahead = v.x * cos + v.y * sin;
                    if ahead <= 0.0 {
                        continue;
                    }
                    let slope = |step: DVec3| (v.x * step.y - v.y * step.x) / square;
                    let away = angles::atan2(v.y * cos - v.x * sin, ahead);
                    let added = ramp(away, slope(lamp.step_x), slope(lamp.step_y));
                    if added > 0.0 {
                        let gamma = angles::atan2(square.sqrt(), v.z);
                        *value = N::of(value.wide() + lamp.per_cd(v) * table.c_jump(plane.line, gamma) * added);
                    }
                }
            }
        }
    }

    /// Pixels between two places.
    fn whole(&self, low: f64, high: f64) -> Option<[usize; 2]> {
        let (low, high) = (low.max(0.0), high.min(self.nx as f64));
        (low < high).then(|| [low.floor() as usize, (high.ceil() as usize).min(self.nx)])
    }

    /// Pixels of a row that a half-plane may cross, from the places where it crosses the row's edges and middle.
    fn by_plane(&self, lamp: &Lamp<'_>, plane: &Plane, edges: [f64; 3]) -> Option<[usize; 2]> {
        let found = edges.map(|y| lamp.plane_crossing(lamp.corner + y * lamp.step_y, plane.turn));
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        for u in found.into_iter().flatten() {
            hull = [hull[0].min(u), hull[1].max(u)];
        }
        // A half-plane that begins within the row, or runs along it.
        let some = found.iter().flatten().count();
        if some == 1 || some == 2 || some == 0 && lamp.side_changes(edges, plane.turn) {
            hull = if some == 0 {
                [0.0, self.nx as f64]
            } else {
                lamp.widened(hull, edges[1])
            };
        }
        self.whole(hull[0] - 1.0, hull[1] + 1.0)
    }

    /// Pixels of a row that a cone may cross, in one run or two.
    fn by_cone(&self, lamp: &Lamp<'_>, cone: &Cone, edges: [f64; 3]) -> [Option<[usize; 2]>; 2] {
        let found = edges.map(|y| lamp.cone_crossings(lamp.corner + y * lamp.step_y, cone.cosine));
        let hull = |of: &mut dyn Iterator<Item = f64>| {
            let [low, high] = of.fold([f64::INFINITY, f64::NEG_INFINITY], |hull, u| {
                [hull[0].min(u), hull[1].max(u)]
            });
            self.whole(low - 1.0, high + 1.0)
        };
        if found.iter().all(|pair| pair[0].is_some() && pair[1].is_some()) {
            let runs = [0, 1].map(|k: usize| hull(&mut found.iter().filter_map(|pair| pair[k])));
            let apart = runs[0].zip(runs[1]).is_none_or(|(a, b)| a[1] <= b[0] || b[1] <= a[0]);
            if apart {
                return runs;
            }
        }
        [hull(&mut found.iter().flatten().copied().flatten()), None]
    }
}

/// What a polynomial does not exceed on [−1, 1].
fn most(coefficients: &[f64; TERMS]) -> f64 {
    coefficients.iter().map(|c| c.abs()).sum()
}

/// Mean of the ramp (s + gx·x + gy·y)₊ over the unit square round 0, less s₊.
fn ramp(s: f64, gx: f64, gy: f64) -> f64 {
    let (a, b) = (gx.abs().max(gy.abs()), gx.abs().min(gy.abs()));
    let s = s.abs();
    if s >= 0.5 * (a + b) {
        0.0
    } else if s >= 0.5 * (a - b) {
        (0.5 * (a + b) - s).powi(3) / (6.0 * a * b)
    } else {
        (s * s + 0.25 * a * a + b * b / 12.0) / (2.0 * a) - 0.5 * s
    }
}

impl Lamp<'_> {
    /// Lists the kinks, and returns the relative bound of what pixel centres neglect elsewhere; `None` where the light may
    /// vanish, or comes from behind.
    fn prepare(&mut self, sensor: &Sensor, aim: f64, kink: f64) -> Option<f64> {
        let table = self.light.table;
        let place = |x: f64, y: f64| self.corner + x * self.step_x + y * self.step_y;
        let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
        let corners = [place(0.0, 0.0), place(nx, 0.0), place(nx, ny), place(0.0, ny)];
        let height = corners
            .iter()
            .map(|v| self.light.toward.dot(*v))
            .fold(f64::INFINITY, f64::min);
        let farthest = corners.iter().map(|v| v.length()).fold(0.0, f64::max);
        if height <= 1e-3 * farthest {
            return None;
        }
        // The nearest point of the whole plane is not farther than that of the sensor.
        let distance = self.light.toward.dot(corners[0]);
        let [mut low, mut high] = [f64::INFINITY, 0.0_f64];
        for i in 0..=SIDE {
            for j in 0..=SIDE {
                let v = place(nx * i as f64 / SIDE as f64, ny * j as f64 / SIDE as f64);
                let gamma = v.x.hypot(v.y).atan2(v.z);
                (low, high) = (low.min(gamma), high.max(gamma));
            }
        }
        let step = (nx * self.step_x.length()).hypot(ny * self.step_y.length()) / (SIDE as f64 * distance);
        let slopes = Slopes::over(table, (low - step).max(0.0), high + step)?;
        // Curvature over a pixel.
        let square = (self.step_x.length_squared() + self.step_y.length_squared()) / 24.0;
        let (near, face) = (distance.recip(), (3.0 / distance + 1.0 / height));
        let curvature = |axis: f64| {
            let (turn_g, turn_c) = (near, axis.recip());
            // γ turns with the distance from the axis, least far from it.
            let round = near * (slopes.tip / axis + slopes.gamma_per_sine * near);
            let bend_c = 2.0 * axis.powi(-2);
            // In C, the slope falls towards the pole like the distance from it.
            let c = slopes.c_per_sine * (axis * near).min(1.0);
            square
                * (round
                    + 2.0 * slopes.gamma * turn_g * (near + face)
                    + c * (bend_c + 2.0 * turn_c * face)
                    + 2.0 * slopes.both * turn_g * turn_c
                    + 15.0 * near * near
                    + 6.0 * near / height)
        };
        let reach = farthest.max(1e-9);
        if curvature(reach) > aim {
            return None;
        }
        let (mut least, mut most) = (1e-9 * reach, reach);
        for _ in 0..60 {
            let middle = (least * most).sqrt();
            if curvature(middle) > aim {
                least = middle;
            } else {
                most = middle;
            }
        }
        let diagonal = (self.step_x + self.step_y)
            .length()
            .max((self.step_x - self.step_y).length());
        self.axis = most + 0.75 * diagonal;
        let mut neglected = curvature(most);
        // A kink through the middle of a rectangle bends its mean by at most an eighth of the longer side; a straight ramp of an even
        // slope describes it but for how the angle and all else turn over the pixel.
        let side = self.step_x.length().max(self.step_y.length());
        // A pixel may hold a cone and a plane.
        let mut soft = [0.0_f64; 2];
        let mut within = |kind: usize, jump: f64, axis: f64| {
            let error = 0.125 * side * near * jump;
            let bent = 2.0 * square * near * (jump * (axis.recip() + near + face) + 2.0 * slopes.both / axis);
            let (within, left) = match () {
                () if error <= kink => (Within::Soft, error),
                () if bent <= kink => (Within::Ramp, bent),
                () => (Within::Own, 0.0),
            };
            soft[kind] = soft[kind].max(left);
            within
        };
        for &(line, jump) in &slopes.cones {
            let gamma = table.gamma_rad[line];
            let axis = most.max(distance * gamma.sin());
            self.cones.push(Cone {
                line,
                cosine: gamma.cos(),
                within: within(0, jump, axis),
            });
        }
        for &(line, jump) in &slopes.planes {
            self.planes.push(Plane {
                line,
                turn: table.c_rad[line].sin_cos().into(),
                within: within(1, jump, most),
            });
        }
        neglected += soft[0] + soft[1];
        Some(neglected)
    }

    /// Light of this part per candela along `v`, lx.
    fn per_cd(&self, v: DVec3) -> f64 {
        let square = v.length_squared();
        let length = square.sqrt();
        let light = 1e6 * self.share * self.light.toward.dot(v) / (square * length);
        if self.light.extinction_per_mm > 0.0 {
            light * (-self.light.extinction_per_mm * length).exp()
        } else {
            light
        }
    }

    /// The place along the row at `a` of a half-plane of azimuth.
    fn plane_crossing(&self, a: DVec3, [sin, cos]: [f64; 2]) -> Option<f64> {
        let b = self.step_x;
        let slope = b.x * sin - b.y * cos;
        let u = -(a.x * sin - a.y * cos) / slope;
        (slope != 0.0 && (a.x + u * b.x) * cos + (a.y + u * b.y) * sin > 0.0).then_some(u)
    }

    /// Whether a plane of azimuth passes between the first and the last of three rows although it crosses none of them.
    fn side_changes(&self, edges: [f64; 3], [sin, cos]: [f64; 2]) -> bool {
        let at = |y: f64, x: f64| {
            let v = self.corner + y * self.step_y + x * self.step_x;
            (v.x * sin - v.y * cos, v.x * cos + v.y * sin)
        };
        let b = self.step_x;
        let parallel = (b.x * sin - b.y * cos).abs() < 1e-12 * b.length();
        let ends = [at(edges[0], 0.0), at(edges[2], 0.0), at(edges[1], 1e6)];
        parallel && ends[0].0 * ends[1].0 <= 0.0 && (ends[0].1 > 0.0 || ends[2].1 > 0.0)
    }

    /// A hull with the place nearest to the axis, where half-planes begin.
    fn widened(&self, hull: [f64; 2], y: f64) -> [f64; 2] {
        let near = self.nearest_to_axis(y);
        [hull[0].min(near), hull[1].max(near)]
    }

    /// The places along the row at `a` of a cone of polar angle, rising.
    fn cone_crossings(&self, a: DVec3, cosine: f64) -> [Option<f64>; 2] {
        let b = self.step_x;
        if cosine.abs() < 1e-12 {
            let u = -a.z / b.z;
            return [u.is_finite().then_some(u), None];
        }
        let square = cosine * cosine;
        let p = b.z * b.z - square * b.length_squared();
        let q = a.z * b.z - square * a.dot(b);
        let r = a.z * a.z - square * a.length_squared();
        let root = q * q - p * r;
        if root < 0.0 {
            return [None; 2];
        }
        let sum = -(q + root.sqrt().copysign(q));
        let (first, second) = (sum / p, r / sum);
        let on = |u: f64| (u.is_finite() && (a.z + u * b.z) * cosine > 0.0).then_some(u);
        if first < second {
            [on(first), on(second)]
        } else {
            [on(second), on(first)]
        }
    }

    /// The place of row `y` nearest to the pole axis.
    fn nearest_to_axis(&self, y: f64) -> f64 {
        let (a, b) = ((self.corner + y * self.step_y).truncate(), self.step_x.truncate());
        -a.dot(b) / b.length_squared().max(1e-300)
    }

    /// From where to where row `y` is within `axis` of the pole axis.
    fn near_axis(&self, y: f64) -> Option<[f64; 2]> {
        let (a, b) = ((self.corner + y * self.step_y).truncate(), self.step_x.truncate());
        let middle = self.nearest_to_axis(y);
        let away = (a + middle * b).length_squared();
        let square = self.axis * self.axis - away;
        (square > 0.0).then(|| {
            let half = (square / b.length_squared().max(1e-300)).sqrt();
            [middle - half, middle + half]
        })
    }
}

/// How steep a table is relative to its light, over a range of polar angles.
struct Slopes {
    /// 1/rad.
    gamma: f64,
    /// The same in the cells at the pole, and elsewhere over sin γ.
    tip: f64,
    gamma_per_sine: f64,
    /// Slope in C over sin γ, 1/rad.
    c_per_sine: f64,
    /// 1/rad².
    both: f64,
    /// Line of each kink and its change of slope, 1/rad.
    cones: Vec<(usize, f64)>,
    /// Line of each kink and its change of slope over sin γ.
    planes: Vec<(usize, f64)>,
}

impl Slopes {
    /// `None` where the light may be zero, or differs at the pole from plane to plane.
    fn over(table: &Table, low: f64, high: f64) -> Option<Self> {
        let grid = &table.gamma_rad;
        let n = grid.len();
        if n < 2 || low < grid[0] - 1e-9 || high > grid[n - 1] + 1e-9 {
            return None;
        }
        let first = grid.partition_point(|line| *line <= low).max(1) - 1;
        let last = grid.partition_point(|line| *line < high).min(n - 1);
        let planes = if table.is_rotational() {
            1
        } else {
            table.c_rad.len() - 1
        };
        let at = |ic: usize, ig: usize| table.intensity_cd[ic % planes * n + ig];
        let least = (0..planes)
            .flat_map(|ic| (first..=last).map(move |ig| at(ic, ig)))
            .fold(f64::INFINITY, f64::min);
        if least <= 1e-6 * table.peak_cd() {
            return None;
        }
        let slope = |ic: usize, ig: usize| (at(ic, ig + 1) - at(ic, ig)) / (grid[ig + 1] - grid[ig]);
        // Relative to the dimmest plane of the two lines round a cell.
        let dim = |ig: usize| (0..planes).map(|ic| at(ic, ig)).fold(f64::INFINITY, f64::min);
        let mut out = Self {
            gamma: 0.0,
            tip: 0.0,
            gamma_per_sine: 0.0,
            c_per_sine: 0.0,
            both: 0.0,
            cones: Vec::new(),
            planes: Vec::new(),
        };
        for ig in first..last {
            let per = dim(ig).min(dim(ig + 1)).recip();
            for ic in 0..planes {
                let steep = per * slope(ic, ig).abs();
                out.gamma = out.gamma.max(steep);
                if grid[ig] < 1e-9 {
                    out.tip = out.tip.max(steep);
                } else {
                    let sine = grid[ig].sin().min(grid[ig + 1].sin()).max(1e-300);
                    out.gamma_per_sine = out.gamma_per_sine.max(steep / sine);
                }
            }
        }
        for ig in first.max(1)..=last.min(n - 2) {
            let jump = (0..planes)
                .map(|ic| (slope(ic, ig) - slope(ic, ig - 1)).abs())
                .fold(0.0, f64::max);
            if table.gamma_kinks().contains(&grid[ig]) {
                out.cones.push((ig, jump / dim(ig)));
            }
        }
        if planes > 1 {
            let width = |ic: usize| table.c_rad[ic % planes + 1] - table.c_rad[ic % planes];
            let across = |ic: usize, ig: usize| (at(ic + 1, ig) - at(ic, ig)) / width(ic);
            let mut jumps = vec![0.0_f64; planes];
            for ig in first..=last {
                let sine = grid[ig].sin();
                let per = dim(ig).recip();
                for ic in 0..planes {
                    let here = across(ic, ig);
                    let jump = (here - across(ic + planes - 1, ig)).abs() * per;
                    if sine < 1e-9 {
                        if here.abs() * per > 1e-12 {
                            return None;
                        }
                        continue;
                    }
                    out.c_per_sine = out.c_per_sine.max(here.abs() * per / sine);
                    jumps[ic] = jumps[ic].max(jump / sine);
                    if ig < last {
                        let next = across(ic, ig + 1);
                        out.both = out.both.max((next - here).abs() * per / (grid[ig + 1] - grid[ig]));
                    }
                }
            }
            if first == 0 {
                let sine = grid[1].sin();
                for ic in 0..planes {
                    out.both = out.both.max(across(ic, 1).abs() / (dim(1) * sine));
                }
            }
            out.planes = jumps
                .into_iter()
                .enumerate()
                .filter(|(_, jump)| *jump > 1e-13)
                .collect();
        }
        Some(out)
    }
}

/// The polynomial of one row of a block, `t` from −1 to 1.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn at_row(powers: &[[f64; TERMS]; TERMS], t: f64) -> [f64; TERMS] {
    let mut row = powers[TERMS - 1];
    for power in powers.iter().rev().skip(1) {
        for k in 0..TERMS {
            row[k] = row[k] * t + power[k];
        }
    }
    row
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_over_a_pixel_is_its_mean_less_its_middle() {
        let parts = 400;
        for (gx, gy) in [(1.0, 0.0), (0.3, -0.8), (-0.5, 0.5), (0.0, 2.0)] {
            for s in [-2.0, -0.6, -0.3, -0.1, 0.0, 0.05, 0.25, 0.5, 0.9] {
                let place = |k: i32| (f64::from(k) + 0.5) / f64::from(parts) - 0.5;
                let mut sum = 0.0;
                for i in 0..parts {
                    for j in 0..parts {
                        sum += f64::max(s + gx * place(i) + gy * place(j), 0.0);
                    }
                }
                let brute = sum / f64::from(parts * parts) - s.max(0.0);
                let found = ramp(s, gx, gy);
                assert!((found - brute).abs() < 3e-6, "{s} {gx} {gy}: {found} {brute}");
            }
        }
    }
}
