//! Many rays at a time in the vector units: numbers, direction, origin and landing of [`LANES`] rays side by side.
//!
//! Every operation is the same IEEE operation on every machine, so that the counts do not depend on the width of the
//! units.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use crate::emission::{Cell, Emission, MOST_STEPS};
use crate::random::{Random, unit32};
use crate::sensor::Sensor;
use crate::sines::{SERIES, sin_versine, small_sin_versine};
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
    /// Pixels along x and y: whole numbers.
    pixels: [f64; 2],
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
            pixels: [sensor.nx as f64, sensor.ny as f64],
        }
    }

    /// Follows rays with the first numbers `u`; `block` numbers their further words.
    pub fn follow(&self, rays: &[(f64, u64)], block: u32) {
        for chunk in rays.chunks(LANES) {
            let mut index = [chunk[0].1; LANES];
            for (lane, ray) in chunk.iter().enumerate() {
                index[lane] = ray.1;
            }
            let mut gathered = Gathered {
                steps: MOST_STEPS,
                ..Gathered::default()
            };
            for (lane, &(u, _)) in chunk.iter().enumerate() {
                // Rays beyond the cone do not come here.
                if let Some(cell) = self.emission.cell_of(u) {
                    gathered.put(lane, cell, self.emission.part(cell));
                }
            }
            self.finish(&mut gathered, &index, chunk.len(), block);
        }
    }

    /// Follows the `count` rays from number `first` that leave through one cell.
    pub fn follow_cell(&self, cell: &Cell, first: u64, count: u64, block: u32) {
        let mut gathered = Gathered {
            steps: cell.newton_steps(),
            ..Gathered::default()
        };
        for lane in 0..LANES {
            gathered.put(lane, cell, self.emission.part(cell));
        }
        let end = first + count;
        let mut from = first;
        while from < end {
            let mut index = [from; LANES];
            for (lane, index) in index.iter_mut().enumerate() {
                *index += lane as u64;
            }
            self.finish(&mut gathered, &index, LANES.min((end - from) as usize), block);
            from += LANES as u64;
        }
    }

    /// Draws the numbers of the first `count` lanes and counts where they land.
    fn finish(&self, gathered: &mut Gathered, index: &[u64; LANES], count: usize, block: u32) {
        gathered.word = words(self.random.key(), index, block, self.random.purpose());
        let mut landed = Landed {
            pixel: [0; LANES],
            path: [0.0; LANES],
        };
        land(self, gathered, &mut landed);
        for (lane, &index) in index.iter().enumerate().take(count) {
            // A ray that misses the sensor has the number of no pixel.
            if let Some(counter) = self.count.get(landed.pixel[lane] as usize)
                && self.survives(landed.path[lane], index, block)
            {
                // Whole numbers add up to the same in any order.
                counter.fetch_add(1, Ordering::Relaxed);
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
    /// Newton's steps that γ takes in every lane.
    steps: usize,
    sin_gamma: Lanes,
    cos_gamma: Lanes,
    width: Lanes,
    low: Lanes,
    high: Lanes,
    slope: Lanes,
    end_sine: Lanes,
    whole: Lanes,
    corner: [Lanes; 4],
    sin_c: Lanes,
    cos_c: Lanes,
    d_c: Lanes,
    /// Four words of random bits: γ, C, and the place on the part.
    word: [[u32; LANES]; 4],
    /// Centre of the part, inner radius², outer radius² less it, sides of a rectangle.
    origin: [Lanes; 3],
    inner: Lanes,
    ring: Lanes,
    sides: [Lanes; 2],
    aim: [[Lanes; 3]; 3],
}

impl Gathered {
    fn put(&mut self, lane: usize, cell: &Cell, part: &(Shape, Option<glam::DMat3>)) {
        self.sin_gamma[lane] = cell.sin_gamma;
        self.cos_gamma[lane] = cell.cos_gamma;
        self.width[lane] = cell.d_gamma;
        self.low[lane] = cell.low;
        self.high[lane] = cell.high;
        self.slope[lane] = (cell.high - cell.low) / cell.d_gamma;
        self.end_sine[lane] = cell.end_sine;
        self.whole[lane] = cell.whole;
        for (lanes, value) in self.corner.iter_mut().zip(cell.corner) {
            lanes[lane] = value;
        }
        self.sin_c[lane] = cell.sin_c;
        self.cos_c[lane] = cell.cos_c;
        self.d_c[lane] = cell.d_c;
        let centre = match part.0 {
            Shape::Point(centre) => centre,
            Shape::Disc { centre, radius } => {
                self.ring[lane] = radius * radius;
                centre
            }
            Shape::Ring { centre, inner, outer } => {
                self.inner[lane] = inner * inner;
                self.ring[lane] = outer * outer - inner * inner;
                centre
            }
            Shape::Rectangle { centre, half } => {
                self.sides[0][lane] = 2.0 * half[0];
                self.sides[1][lane] = 2.0 * half[1];
                centre
            }
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

/// Numbers of pixels, [`NOWHERE`] where a ray does not meet the face, and lengths of path.
struct Landed {
    pixel: [u64; LANES],
    path: Lanes,
}

/// 2⁵².
const WHOLE: f64 = 4_503_599_627_370_496.0;

/// The number of no pixel.
const NOWHERE: u64 = u64::MAX;

/// Sine and cosine of a turn in [0, 1], by quarters.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside the multiversioned loop, or it would not be vectorised"
)]
fn circle(turn: f64) -> (f64, f64) {
    let quarter = (4.0 * turn + 0.5).floor();
    let x = (turn - 0.25 * quarter) * std::f64::consts::TAU;
    let (sin, versine) = sin_versine(x, &SERIES);
    let cos = 1.0 - versine;
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
    let [nx, ny] = tracer.pixels;
    // γ: Newton on the exact integral of (linear × sine), from the inverse of the linear density.
    let mut along = [0.0; LANES];
    for (lane, t) in along.iter_mut().enumerate() {
        let u = unit32(g.word[0][lane]);
        *t = linear(u, g.low[lane] * g.sin_gamma[lane], g.high[lane] * g.end_sine[lane]);
    }
    for _ in 0..g.steps {
        for (lane, along) in along.iter_mut().enumerate() {
            let (t, h, low, high) = (*along, g.width[lane], g.low[lane], g.high[lane]);
            let (s0, c0) = (g.sin_gamma[lane], g.cos_gamma[lane]);
            let aim = unit32(g.word[0][lane]) * g.whole[lane];
            let (sin, versine) = small_sin_versine(t * h);
            let cos = 1.0 - versine;
            let fall = s0 * sin + c0 * versine;
            let rise = c0 * sin - s0 * versine;
            let value = low * fall + g.slope[lane] * (rise - t * h * (c0 * cos - s0 * sin));
            let slope = (low + (high - low) * t) * (s0 * cos + c0 * sin) * h;
            *along = (t - (value - aim) / slope.max(1e-300)).clamp(0.0, 1.0);
        }
    }
    for (lane, &t) in along.iter().enumerate() {
        let h = g.width[lane];
        let (s0, c0) = (g.sin_gamma[lane], g.cos_gamma[lane]);
        let (sin, versine) = small_sin_versine(t * h);
        let cos = 1.0 - versine;
        let (sin_gamma, cos_gamma) = (s0 * cos + c0 * sin, c0 * cos - s0 * sin);
        // C: linear between the values at this γ.
        let [ll, lh, hl, hh] = [
            g.corner[0][lane],
            g.corner[1][lane],
            g.corner[2][lane],
            g.corner[3][lane],
        ];
        let s = linear(unit32(g.word[1][lane]), ll + t * (lh - ll), hl + t * (hh - hl));
        let (sin, versine) = small_sin_versine(s * g.d_c[lane]);
        let cos = 1.0 - versine;
        let (sin_c, cos_c) = (
            g.sin_c[lane] * cos + g.cos_c[lane] * sin,
            g.cos_c[lane] * cos - g.sin_c[lane] * sin,
        );
        let own = [sin_gamma * cos_c, sin_gamma * sin_c, cos_gamma];
        let turned = |k: usize| g.aim[0][k][lane] * own[0] + g.aim[1][k][lane] * own[1] + g.aim[2][k][lane] * own[2];
        let [dx, dy, dz] = [turned(0), turned(1), turned(2)];
        // A disc or ring, or a rectangle: the other's size is zero.
        let (u, w) = (unit32(g.word[2][lane]), unit32(g.word[3][lane]));
        let (sin, cos) = circle(w);
        let radius = (g.inner[lane] + g.ring[lane] * u).sqrt();
        let [ox, oy, oz] = [
            g.origin[0][lane] + radius * cos + (u - 0.5) * g.sides[0][lane],
            g.origin[1][lane] + radius * sin + (w - 0.5) * g.sides[1][lane],
            g.origin[2][lane],
        ];
        let speed = dx * tx + dy * ty + dz * tz;
        let height = (cx - ox) * tx + (cy - oy) * ty + (cz - oz) * tz;
        let path = height / speed;
        let [ex, ey, ez] = [ox + path * dx - cx, oy + path * dy - cy, oz + path * dz - cz];
        let meets = speed > 0.0 && height > 0.0;
        let (x, y) = (ex * ax + ey * ay + ez * az, ex * bx + ey * by + ez * bz);
        let inside = meets && x >= 0.0 && y >= 0.0 && x < nx && y < ny;
        // A whole number below 2⁵² stands in the last bits of its sum with 2⁵².
        let pixel = (y.floor() * nx + x.floor() + WHOLE).to_bits() ^ WHOLE.to_bits();
        out.pixel[lane] = if inside { pixel } else { NOWHERE };
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
    let (mut c0, mut c1) = ([0_u32; LANES], [0_u32; LANES]);
    for lane in 0..LANES {
        c0[lane] = index[lane] as u32;
        c1[lane] = (index[lane] >> 32) as u32;
    }
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
