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

/// Intervals along each side of the sensor at which polar angles are looked at.
const SIDE: usize = 16;

/// What a map's errors do not exceed, as far as the rules can tell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bound {
    /// Mean over the map, lx.
    pub mean_lx: f64,
    /// Of any pixel, relative to itself.
    pub largest: f64,
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
    /// Sine and cosine of each azimuth with a kink, and whether the kink matters within a pixel.
    planes: Vec<([f64; 2], bool)>,
    /// Cosine of each polar angle with a kink, and whether it matters within a pixel.
    cones: Vec<(f64, bool)>,
    /// Distance from the pole axis in mm below which a pixel's centre does not stand for it.
    axis: f64,
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
        let (sum, largest) = map
            .par_chunks_mut(BLOCK * self.nx)
            .enumerate()
            .map_init(Work::default, |work, (index, rows)| {
                let mut bound = (0.0, 0.0);
                self.rows(index * BLOCK, rows, work, &exact, &mut bound);
                bound
            })
            .reduce(|| (0.0, 0.0), |a, b| (a.0 + b.0, f64::max(a.1, b.1)));
        Bound {
            mean_lx: sum / (self.nx * self.ny) as f64,
            largest: largest + self.neglected + N::ROUNDING,
        }
    }

    /// Fills a block of rows, or its halves where kinks cross each other within it.
    fn rows<N: Number>(
        &self,
        first: usize,
        rows: &mut [N],
        work: &mut Work,
        exact: &impl Fn(usize, usize) -> Estimate,
        bound: &mut (f64, f64),
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
            for (plane, _) in &lamp.planes {
                add(lamp.plane_crossing(a, *plane));
            }
            for (cosine, _) in &lamp.cones {
                for u in lamp.cone_crossings(a, *cosine) {
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

    /// Fills one row; adds the bounds of its pixels and the largest relative one, without what is the same everywhere.
    fn row<N: Number>(
        &self,
        iy: usize,
        line: &mut [N],
        block: Option<&Block>,
        work: &mut Work,
        exact: &impl Fn(usize, usize) -> Estimate,
        bound: &mut (f64, f64),
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
                    bound.0 += (to - from) as f64 * (piece.tail + always * coefficients[0].abs());
                    bound.1 = bound.1.max(piece.tail / piece.least);
                } else {
                    self.span(y, from, to, line, bound);
                }
                from = to;
            }
            low = high;
        }
        self.own_pixels(iy, work);
        for range in &work.own {
            for ix in range[0]..range[1] {
                let found = exact(ix, iy);
                line[ix] = N::of(found.value);
                bound.0 += found.error;
                if found.value != 0.0 {
                    bound.1 = f64::max(bound.1, found.error / found.value.abs());
                }
            }
        }
    }

    /// Fills the pixels from..to, between which no kink passes.
    fn span<N: Number>(&self, y: f64, from: usize, to: usize, line: &mut [N], bound: &mut (f64, f64)) {
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
                    bound.0 += always * found.abs();
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
            bound.0 += count as f64 * (tail + always * coefficients[0].abs());
            if tail > 0.0 {
                bound.1 = bound.1.max(tail / least);
            }
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

    /// Pixels of a row that centres do not stand for: near the pole axis, and across kinks that matter.
    fn own_pixels(&self, iy: usize, work: &mut Work) {
        work.own.clear();
        let end = self.nx as f64;
        let edges = [iy as f64, iy as f64 + 0.5, iy as f64 + 1.0];
        let mut add = |low: f64, high: f64, more: f64| {
            let (low, high) = ((low - more).max(0.0), (high + more).min(end));
            if low < high {
                work.own
                    .push([low.floor() as usize, (high.ceil() as usize).min(self.nx)]);
            }
        };
        for lamp in &self.lamps {
            if let Some([low, high]) = lamp.near_axis(edges[1]) {
                add(low, high, 0.0);
            }
            for (kink, _) in lamp.planes.iter().filter(|plane| plane.1) {
                let found = edges.map(|y| lamp.plane_crossing(lamp.corner + y * lamp.step_y, *kink));
                let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
                for u in found.into_iter().flatten() {
                    hull = [hull[0].min(u), hull[1].max(u)];
                }
                // A half-plane that begins within the row, or runs along it.
                let some = found.iter().flatten().count();
                if some == 1 || some == 2 || some == 0 && lamp.side_changes(edges, *kink) {
                    hull = if some == 0 {
                        [0.0, end]
                    } else {
                        lamp.widened(hull, edges[1])
                    };
                }
                add(hull[0], hull[1], 1.0);
            }
            for (cosine, _) in lamp.cones.iter().filter(|cone| cone.1) {
                let found = edges.map(|y| lamp.cone_crossings(lamp.corner + y * lamp.step_y, *cosine));
                let whole = found.iter().all(|pair| pair[0].is_some() && pair[1].is_some());
                if whole {
                    for k in 0..2 {
                        let at = found.map(|pair| pair[k].unwrap_or(0.0));
                        add(at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]), 1.0);
                    }
                } else {
                    let all = found.iter().flatten().flatten();
                    let hull = all.fold([f64::INFINITY, f64::NEG_INFINITY], |hull, &u| {
                        [hull[0].min(u), hull[1].max(u)]
                    });
                    add(hull[0], hull[1], 1.0);
                }
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
        // A kink through the middle of a rectangle bends its mean by at most an eighth of the longer side.
        let side = self.step_x.length().max(self.step_y.length());
        // A pixel may hold a cone and a plane.
        let mut soft = [0.0_f64; 2];
        let mut matters = |kind: usize, jump: f64| {
            let error = 0.125 * side * near * jump;
            if error <= kink {
                soft[kind] = soft[kind].max(error);
            }
            error > kink
        };
        for (gamma, jump) in slopes.cones {
            self.cones.push((gamma.cos(), matters(0, jump)));
        }
        for (c, jump) in slopes.planes {
            self.planes.push((c.sin_cos().into(), matters(1, jump)));
        }
        neglected += soft[0] + soft[1];
        Some(neglected)
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
    /// Angle of each kink and its change of slope, 1/rad; infinite at an end of the range.
    cones: Vec<(f64, f64)>,
    /// Azimuth of each kink and its change of slope over sin γ.
    planes: Vec<(f64, f64)>,
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
                out.cones.push((grid[ig], jump / dim(ig)));
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
                .map(|(ic, jump)| (table.c_rad[ic], jump))
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
