//! Many rays at a time in the vector units: numbers, direction, origin and landing of [`LANES`] rays side by side.
//!
//! Every operation is the same IEEE operation on every machine, so that the counts do not depend on the width of the units.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::emission::{Cell, Emission};
use crate::random::{Random, unit32};
use crate::sensor::Sensor;
use crate::source::Shape;

/// Rays side by side.
pub(crate) const LANES: usize = 16;

type Lanes = [f64; LANES];

/// Where rays of an emission land on a sensor, and who counts them.
pub(crate) struct Tracer<'a> {
    pub emission: &'a Emission,
    pub count: &'a [AtomicU64],
    pub random: Random,
    pub extinction_per_mm: f64,
    corner: DVec3,
    toward: DVec3,
    /// Vectors whose product with a point on the sensor, less the corner, is its place in pixels.
    across: [DVec3; 2],
    nx: usize,
    ny: usize,
}

impl<'a> Tracer<'a> {
    pub fn new(
        emission: &'a Emission,
        sensor: &Sensor,
        count: &'a [AtomicU64],
        random: Random,
        extinction_per_mm: f64,
    ) -> Self {
        Self {
            emission,
            count,
            random,
            extinction_per_mm,
            corner: sensor.corner,
            toward: sensor.toward,
            across: [
                sensor.step_x / sensor.step_x.length_squared(),
                sensor.step_y / sensor.step_y.length_squared(),
            ],
            nx: sensor.nx,
            ny: sensor.ny,
        }
    }

    /// Follows rays with the first numbers `u`; `block` numbers their further words.
    pub fn follow(&self, rays: &[(f64, u64)], block: u32) {
        for chunk in rays.chunks(LANES) {
            let mut index = [chunk[0].1; LANES];
            for (lane, ray) in chunk.iter().enumerate() {
                index[lane] = ray.1;
            }
            let words = words(self.random.key(), &index, block, self.random.purpose());
            let mut gathered = Gathered::default();
            for (lane, &(u, _)) in chunk.iter().enumerate() {
                // Rays beyond the cone do not come here.
                if let Some(cell) = self.emission.cell_of(u) {
                    gathered.put(lane, cell, self.emission.part(cell), words.map(|word| word[lane]));
                }
            }
            let mut landed = Landed {
                x: [-1.0; LANES],
                y: [-1.0; LANES],
                path: [0.0; LANES],
            };
            land(self, &gathered, &mut landed);
            for (lane, &(_, index)) in chunk.iter().enumerate() {
                let (x, y) = (landed.x[lane], landed.y[lane]);
                let inside = x >= 0.0 && y >= 0.0 && x < self.nx as f64 && y < self.ny as f64;
                if inside && self.survives(landed.path[lane], index, block) {
                    // Whole numbers add up to the same in any order.
                    self.count[y as usize * self.nx + x as usize].fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }

    /// Whether the medium lets the ray through.
    fn survives(&self, path_mm: f64, index: u64, block: u32) -> bool {
        self.extinction_per_mm == 0.0
            || unit32(self.random.words(index, block + 16)[0]) < (-self.extinction_per_mm * path_mm).exp()
    }
}

/// What each lane needs to know of its cell and its part.
#[derive(Default)]
struct Gathered {
    sin_gamma: Lanes,
    cos_gamma: Lanes,
    width: Lanes,
    low: Lanes,
    high: Lanes,
    end_sine: Lanes,
    whole: Lanes,
    corner: [Lanes; 4],
    sin_c: Lanes,
    cos_c: Lanes,
    d_c: Lanes,
    u: [Lanes; 2],
    /// Origin of the part, radius², inner radius², half sides; turned to where the lane's numbers say.
    origin: [Lanes; 3],
    inner: Lanes,
    ring: Lanes,
    turn: Lanes,
    aim: [[Lanes; 3]; 3],
}

impl Gathered {
    fn put(&mut self, lane: usize, cell: &Cell, part: &(Shape, Option<glam::DMat3>), words: [u32; 4]) {
        self.sin_gamma[lane] = cell.sin_gamma;
        self.cos_gamma[lane] = cell.cos_gamma;
        self.width[lane] = cell.d_gamma;
        self.low[lane] = cell.low;
        self.high[lane] = cell.high;
        self.end_sine[lane] = cell.end_sine;
        self.whole[lane] = cell.whole;
        for (lanes, value) in self.corner.iter_mut().zip(cell.corner) {
            lanes[lane] = value;
        }
        self.sin_c[lane] = cell.sin_c;
        self.cos_c[lane] = cell.cos_c;
        self.d_c[lane] = cell.d_c;
        self.u[0][lane] = unit32(words[0]);
        self.u[1][lane] = unit32(words[1]);
        let (u, w) = (unit32(words[2]), unit32(words[3]));
        let centre = match part.0 {
            Shape::Point(centre) => centre,
            Shape::Disc { centre, radius } => {
                self.ring[lane] = radius * radius * u;
                self.turn[lane] = w;
                centre
            }
            Shape::Ring { centre, inner, outer } => {
                self.inner[lane] = inner * inner;
                self.ring[lane] = (outer * outer - inner * inner) * u;
                self.turn[lane] = w;
                centre
            }
            Shape::Rectangle { .. } => part.0.point(u, w),
        };
        for (lanes, value) in self.origin.iter_mut().zip(centre.to_array()) {
            lanes[lane] = value;
        }
        let aim = part.1.unwrap_or(glam::DMat3::IDENTITY).to_cols_array_2d();
        for (columns, values) in self.aim.iter_mut().zip(aim) {
            for (lanes, value) in columns.iter_mut().zip(values) {
                lanes[lane] = value;
            }
        }
    }
}

/// Places in pixels and lengths of path; −1 where a ray does not meet the face.
struct Landed {
    x: Lanes,
    y: Lanes,
    path: Lanes,
}

/// Sine and cosine of an angle up to 0.11.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside the multiversioned loop, or it would not be vectorised"
)]
fn small(x: f64) -> (f64, f64) {
    let y = x * x;
    let sin = x * (1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0))));
    let cos = 1.0 - 0.5 * y * (1.0 - y / 12.0 * (1.0 - y / 30.0 * (1.0 - y / 56.0)));
    (sin, cos)
}

/// Sine and cosine of a turn in [0, 1], by quarters.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside the multiversioned loop, or it would not be vectorised"
)]
fn circle(turn: f64) -> (f64, f64) {
    let quarter = (4.0 * turn + 0.5).floor();
    let x = (turn - 0.25 * quarter) * std::f64::consts::TAU;
    let y = x * x;
    let sin = x
        * (1.0
            - y / 6.0
                * (1.0
                    - y / 20.0
                        * (1.0
                            - y / 42.0
                                * (1.0 - y / 72.0 * (1.0 - y / 110.0 * (1.0 - y / 156.0 * (1.0 - y / 210.0)))))));
    let cos = 1.0
        - 0.5
            * y
            * (1.0
                - y / 12.0
                    * (1.0
                        - y / 30.0
                            * (1.0
                                - y / 56.0
                                    * (1.0 - y / 90.0 * (1.0 - y / 132.0 * (1.0 - y / 182.0 * (1.0 - y / 240.0)))))));
    let odd = quarter == 1.0 || quarter == 3.0;
    let (s, c) = if odd { (cos, sin) } else { (sin, cos) };
    let s = if quarter == 2.0 || quarter == 3.0 { -s } else { s };
    let c = if quarter == 1.0 || quarter == 2.0 { -c } else { c };
    (s, c)
}

/// Inverse CDF on [0, 1] of a density linear from `a` to `b`; 2a + … stays above zero for a cell that emits.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside the multiversioned loop, or it would not be vectorised"
)]
fn linear(u: f64, a: f64, b: f64) -> f64 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    (u * (a + b) / (a + root).max(1e-300)).min(1.0)
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn land(tracer: &Tracer<'_>, g: &Gathered, out: &mut Landed) {
    let [tx, ty, tz] = tracer.toward.to_array();
    let [cx, cy, cz] = tracer.corner.to_array();
    let [[ax, ay, az], [bx, by, bz]] = tracer.across.map(|v| v.to_array());
    for lane in 0..LANES {
        // γ: Newton on the exact integral of (linear × sine), three steps from the inverse of the linear density.
        let (h, low, high) = (g.width[lane], g.low[lane], g.high[lane]);
        let (s0, c0) = (g.sin_gamma[lane], g.cos_gamma[lane]);
        let rise_per = (high - low) / h.max(1e-300);
        let aim = g.u[0][lane] * g.whole[lane];
        let mut t = linear(g.u[0][lane], low * s0, high * g.end_sine[lane]);
        for _ in 0..3 {
            let (sin, cos) = small(t * h);
            let versine = sin * sin / (1.0 + cos);
            let fall = s0 * sin + c0 * versine;
            let rise = c0 * sin - s0 * versine;
            let value = low * fall + rise_per * (rise - t * h * (c0 * cos - s0 * sin));
            let slope = (low + (high - low) * t) * (s0 * cos + c0 * sin) * h;
            t = (t - (value - aim) / slope.max(1e-300)).clamp(0.0, 1.0);
        }
        let (sin, cos) = small(t * h);
        let (sin_gamma, cos_gamma) = (s0 * cos + c0 * sin, c0 * cos - s0 * sin);
        // C: linear between the values at this γ.
        let [ll, lh, hl, hh] = [
            g.corner[0][lane],
            g.corner[1][lane],
            g.corner[2][lane],
            g.corner[3][lane],
        ];
        let s = linear(g.u[1][lane], ll + t * (lh - ll), hl + t * (hh - hl));
        let (sin, cos) = small(s * g.d_c[lane]);
        let (sin_c, cos_c) = (
            g.sin_c[lane] * cos + g.cos_c[lane] * sin,
            g.cos_c[lane] * cos - g.sin_c[lane] * sin,
        );
        let own = [sin_gamma * cos_c, sin_gamma * sin_c, cos_gamma];
        let turned = |k: usize| g.aim[0][k][lane] * own[0] + g.aim[1][k][lane] * own[1] + g.aim[2][k][lane] * own[2];
        let [dx, dy, dz] = [turned(0), turned(1), turned(2)];
        let (sin, cos) = circle(g.turn[lane]);
        let radius = (g.inner[lane] + g.ring[lane]).sqrt();
        let [ox, oy, oz] = [
            g.origin[0][lane] + radius * cos,
            g.origin[1][lane] + radius * sin,
            g.origin[2][lane],
        ];
        let speed = dx * tx + dy * ty + dz * tz;
        let height = (cx - ox) * tx + (cy - oy) * ty + (cz - oz) * tz;
        let path = height / speed;
        let [ex, ey, ez] = [ox + path * dx - cx, oy + path * dy - cy, oz + path * dz - cz];
        let meets = speed > 0.0 && height > 0.0;
        out.x[lane] = if meets { ex * ax + ey * ay + ez * az } else { -1.0 };
        out.y[lane] = if meets { ex * bx + ey * by + ez * bz } else { -1.0 };
        out.path[lane] = path;
    }
}

/// Four words of [`LANES`] rays.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn words(key: [u32; 2], index: &[u64; LANES], block: u32, purpose: u32) -> [[u32; LANES]; 4] {
    let mut c0: [u32; LANES] = std::array::from_fn(|lane| index[lane] as u32);
    let mut c1: [u32; LANES] = std::array::from_fn(|lane| (index[lane] >> 32) as u32);
    let mut c2 = [block; LANES];
    let mut c3 = [purpose; LANES];
    let mut key = key;
    for round in 0..10 {
        if round > 0 {
            key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
        }
        for lane in 0..LANES {
            let p0 = u64::from(c0[lane]) * 0xD251_1F53;
            let p1 = u64::from(c2[lane]) * 0xCD9E_8D57;
            c0[lane] = (p1 >> 32) as u32 ^ c1[lane] ^ key[0];
            c1[lane] = p1 as u32;
            c2[lane] = (p0 >> 32) as u32 ^ c3[lane] ^ key[1];
            c3[lane] = p0 as u32;
        }
    }
    [c0, c1, c2, c3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    #[test]
    fn lanes_hold_the_numbers_of_the_stream() {
        let random = Random::new(77, Purpose::Ray);
        let index: [u64; LANES] = std::array::from_fn(|k| 0xffff_fff8 + k as u64);
        let lanes = words(random.key(), &index, 3, Purpose::Ray as u32);
        for (lane, index) in index.iter().enumerate() {
            assert_eq!(lanes.map(|word| word[lane]), random.words(*index, 3));
        }
    }

    #[test]
    fn the_circle_is_round() {
        for k in 0..=1000 {
            let turn = f64::from(k) / 1000.0;
            let (sin, cos) = circle(turn);
            let (s, c) = (std::f64::consts::TAU * turn).sin_cos();
            assert!(
                (sin - s).abs() < 1e-13 && (cos - c).abs() < 1e-13,
                "{turn}: {sin} {s} {cos} {c}"
            );
        }
    }
}
