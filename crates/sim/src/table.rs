//! The intensity distribution as the solvers read it: radians, one look-up, and the list of its kinks.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use isolux_photometry::IntensityDistribution;

/// Bilinear interpolant of an intensity distribution in candela, periodic in C, dark outside its γ range.
#[derive(Debug, Clone)]
pub struct Table {
    /// Rising azimuths in radians; the first plane is repeated a turn later unless the table is rotational.
    pub(crate) c_rad: Vec<f64>,
    /// Rising polar angles in radians.
    pub(crate) gamma_rad: Vec<f64>,
    /// `[ic * gamma.len() + ig]`, candela, one row per entry of `c_rad`.
    pub(crate) intensity_cd: Vec<f64>,
    /// Azimuths, in [0, 2π), at which the slope in C changes.
    c_kinks: Vec<f64>,
    /// Polar angles at which the slope in γ changes or the distribution ends.
    gamma_kinks: Vec<f64>,
    /// At each polar angle, over all planes.
    rough: Vec<Rough>,
    peak_cd: f64,
    c_search: Search,
    gamma_search: Search,
}

/// One bilinear cell: the interpolant between four of its grid's lines.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bilinear {
    /// First line in C (of the turn that was asked for), and one over the width.
    pub c: f64,
    pub per_c: f64,
    /// First line in γ, and one over the width.
    pub gamma: f64,
    pub per_gamma: f64,
    /// Intensities at (C, γ): low-low, low-high γ, high-low, high-high, cd.
    pub corner: [f64; 4],
}

/// How the interpolant runs at one line of constant γ and in the cells above it, the worst over C.
#[derive(Debug, Clone, Copy, Default)]
struct Rough {
    /// Change of slope in γ, cd/rad.
    jump: f64,
    /// Slope in γ above the line, cd/rad.
    steep: f64,
    /// Slope in C over sin γ, cd/rad.
    turn: f64,
    /// Largest change of slope in C, and their sum round the circle, cd/rad.
    jump_c: f64,
    round: f64,
}

/// What may lead a rule astray within reach of a direction, candela.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bends {
    /// Changes of slope times the reach.
    pub lines: f64,
    /// Slopes about the pole axis times the reach: the tip of a cone where the axis is in reach, a smooth bend beside it.
    pub pole: f64,
}

/// Buckets of equal width over a rising grid: the interval of an abscissa in constant time.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    origin: f64,
    per_bucket: f64,
    first: Vec<u32>,
}

impl Search {
    pub(crate) fn over(grid: &[f64]) -> Self {
        let (Some(&origin), Some(&end)) = (grid.first(), grid.last()) else {
            return Self {
                origin: 0.0,
                per_bucket: 0.0,
                first: vec![0],
            };
        };
        if grid.len() < 2 {
            return Self {
                origin,
                per_bucket: 0.0,
                first: vec![0],
            };
        }
        let buckets = (grid.len() * 4).max(16);
        let width = (end - origin) / buckets as f64;
        let mut interval = 0;
        let first = (0..=buckets)
            .map(|bucket| {
                let start = origin + width * (bucket as f64 - 1e-9);
                while interval + 2 < grid.len() && grid[interval + 1] <= start {
                    interval += 1;
                }
                interval as u32
            })
            .collect();
        Self {
            origin,
            per_bucket: 1.0 / width,
            first,
        }
    }

    #[inline]
    pub(crate) fn interval(&self, grid: &[f64], x: f64) -> usize {
        let bucket = ((x - self.origin) * self.per_bucket) as usize;
        let mut interval = self.first[bucket.min(self.first.len() - 1)] as usize;
        while interval + 2 < grid.len() && grid[interval + 1] <= x {
            interval += 1;
        }
        interval
    }
}

impl Table {
    /// The table of `distribution`. Planes that are all equal become one: the light is rotational.
    pub fn new(distribution: &IntensityDistribution) -> Self {
        let gamma_rad: Vec<f64> = distribution
            .gamma_deg()
            .iter()
            .map(|degrees| degrees.to_radians())
            .collect();
        let planes = distribution.c_deg().len();
        let rotational = (1..planes).all(|ic| distribution.row(ic) == distribution.row(0));
        let (c_rad, intensity_cd) = if rotational {
            (vec![0.0], distribution.row(0).to_vec())
        } else {
            let mut c_rad: Vec<f64> = distribution
                .c_deg()
                .iter()
                .map(|degrees| degrees.to_radians())
                .collect();
            c_rad.push(c_rad[0] + TAU);
            let mut intensity_cd = distribution.intensity_cd().to_vec();
            intensity_cd.extend_from_slice(distribution.row(0));
            (c_rad, intensity_cd)
        };
        let c_search = Search::over(&c_rad);
        let gamma_search = Search::over(&gamma_rad);
        let mut table = Self {
            c_rad,
            gamma_rad,
            intensity_cd,
            c_kinks: Vec::new(),
            gamma_kinks: Vec::new(),
            rough: Vec::new(),
            peak_cd: 0.0,
            c_search,
            gamma_search,
        };
        table.find_kinks();
        table.find_rough();
        table
    }

    /// Whether the intensity does not depend on C.
    pub fn is_rotational(&self) -> bool {
        self.c_rad.len() == 1
    }

    /// Intensity in candela towards `direction` (any length but zero).
    #[inline]
    pub fn toward(&self, direction: DVec3) -> f64 {
        let gamma = (direction.x * direction.x + direction.y * direction.y)
            .sqrt()
            .atan2(direction.z);
        let c = if self.is_rotational() {
            0.0
        } else {
            direction.y.atan2(direction.x)
        };
        self.at_rad(c, gamma)
    }

    /// Intensity in candela at azimuth `c` (any turn) and polar angle `gamma`, radians.
    #[inline]
    pub fn at_rad(&self, c: f64, gamma: f64) -> f64 {
        let n = self.gamma_rad.len();
        if gamma < self.gamma_rad[0] - 1e-12 || gamma > self.gamma_rad[n - 1] + 1e-12 {
            return 0.0;
        }
        if n == 1 {
            return self.intensity_cd[0];
        }
        let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
        let tg = ((gamma - self.gamma_rad[ig]) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig])).clamp(0.0, 1.0);
        let along = |row: usize| {
            let low = self.intensity_cd[row * n + ig];
            low + tg * (self.intensity_cd[row * n + ig + 1] - low)
        };
        if self.is_rotational() {
            return along(0);
        }
        let mut c = c;
        if c < self.c_rad[0] {
            c += TAU;
        }
        if c < self.c_rad[0] || c >= self.c_rad[0] + TAU {
            c = self.c_rad[0] + (c - self.c_rad[0]).rem_euclid(TAU);
        }
        let ic = self.c_search.interval(&self.c_rad, c);
        let tc = (c - self.c_rad[ic]) / (self.c_rad[ic + 1] - self.c_rad[ic]);
        let low = along(ic);
        low + tc * (along(ic + 1) - low)
    }

    /// The cell that holds azimuth `c` (any turn) and polar angle `gamma`, radians; `None` outside the range.
    #[inline]
    pub(crate) fn bilinear(&self, c: f64, gamma: f64) -> Option<Bilinear> {
        let n = self.gamma_rad.len();
        if gamma < self.gamma_rad[0] - 1e-12 || gamma > self.gamma_rad[n - 1] + 1e-12 || n < 2 {
            return None;
        }
        let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
        let (g0, per_gamma) = (
            self.gamma_rad[ig],
            (self.gamma_rad[ig + 1] - self.gamma_rad[ig]).recip(),
        );
        let at = |ic: usize, up: usize| self.intensity_cd[ic * n + ig + up];
        if self.is_rotational() {
            let (low, high) = (at(0, 0), at(0, 1));
            return Some(Bilinear {
                c: 0.0,
                per_c: 0.0,
                gamma: g0,
                per_gamma,
                corner: [low, high, low, high],
            });
        }
        let first = self.c_rad[0];
        let mut turned = if c < first { c + TAU } else { c };
        if turned < first || turned >= first + TAU {
            turned = first + (c - first).rem_euclid(TAU);
        }
        let ic = self.c_search.interval(&self.c_rad, turned);
        Some(Bilinear {
            c: self.c_rad[ic] + (c - turned),
            per_c: (self.c_rad[ic + 1] - self.c_rad[ic]).recip(),
            gamma: g0,
            per_gamma,
            corner: [at(ic, 0), at(ic, 1), at(ic + 1, 0), at(ic + 1, 1)],
        })
    }

    /// Value in cd and slope in cd/rad at `gamma` of half-plane `row`.
    pub(crate) fn along(&self, row: usize, gamma: f64) -> (f64, f64) {
        let n = self.gamma_rad.len();
        let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
        let [low, high] = [0, 1].map(|up: usize| self.intensity_cd[row * n + ig + up]);
        let slope = (high - low) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig]);
        (low + slope * (gamma - self.gamma_rad[ig]), slope)
    }

    /// Change of slope in γ at line `ig` (neither the first nor the last), towards azimuth `c` (−π to π), cd/rad.
    pub(crate) fn gamma_jump(&self, ig: usize, c: f64) -> f64 {
        let (n, grid) = (self.gamma_rad.len(), &self.gamma_rad);
        let at = |row: usize| {
            let cd = &self.intensity_cd[row * n + ig - 1..=row * n + ig + 1];
            (cd[2] - cd[1]) / (grid[ig + 1] - grid[ig]) - (cd[1] - cd[0]) / (grid[ig] - grid[ig - 1])
        };
        if self.is_rotational() {
            return at(0);
        }
        let (row, share) = self.between(c);
        (1.0 - share) * at(row) + share * at(row + 1)
    }

    /// Change of slope in C at half-plane `ic` of a table that depends on C, at polar angle `gamma`, cd/rad.
    pub(crate) fn c_jump(&self, ic: usize, gamma: f64) -> f64 {
        let before = if ic == 0 { self.c_rad.len() - 2 } else { ic - 1 };
        let slope =
            |ic: usize| (self.along(ic + 1, gamma).0 - self.along(ic, gamma).0) / (self.c_rad[ic + 1] - self.c_rad[ic]);
        slope(ic) - slope(before)
    }

    /// The half-plane below azimuth `c` (−π to π), and the share of the way to the next one.
    #[inline]
    pub(crate) fn between(&self, c: f64) -> (usize, f64) {
        let first = self.c_rad[0];
        let mut turned = if c < first { c + TAU } else { c };
        if turned < first || turned >= first + TAU {
            turned = first + (c - first).rem_euclid(TAU);
        }
        let row = self.c_search.interval(&self.c_rad, turned);
        let share = (turned - self.c_rad[row]) / (self.c_rad[row + 1] - self.c_rad[row]);
        (row, share)
    }

    /// Largest magnitude, candela.
    pub(crate) fn peak_cd(&self) -> f64 {
        self.peak_cd
    }

    /// Bound, candela, on how far the interpolant bends within `spread` of `gamma` and `spread_c` of `c` (radians): change of
    /// slope at each grid line in reach times the reach. Infinite at an end of the range that is no pole.
    pub(crate) fn bend(&self, gamma: f64, spread: f64, c: f64, spread_c: f64) -> f64 {
        let n = self.gamma_rad.len();
        let (low, high) = (gamma - spread, gamma + spread);
        if low < self.gamma_rad[0] && self.gamma_rad[0] > 1e-9
            || high > self.gamma_rad[n - 1] && self.gamma_rad[n - 1] < PI - 1e-9
            || n < 2
        {
            return f64::INFINITY;
        }
        let from = self.gamma_rad.partition_point(|line| *line < low);
        let to = self.gamma_rad.partition_point(|line| *line <= high);
        let planes = if self.is_rotational() { 1 } else { self.c_rad.len() - 1 };
        let at = |ic: usize, ig: usize| self.intensity_cd[ic % planes * n + ig];
        let slope =
            |ic: usize, ig: usize| (at(ic, ig + 1) - at(ic, ig)) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig]);
        let mut along: f64 = 0.0;
        for ig in from.max(1)..to.min(n - 1) {
            along += (0..planes)
                .map(|ic| (slope(ic, ig) - slope(ic, ig - 1)).abs())
                .fold(0.0, f64::max);
        }
        if low < 0.0 {
            // The pole is the tip of a cone.
            along += (0..planes).map(|ic| slope(ic, 0).abs()).fold(0.0, f64::max);
        }
        if high > PI {
            along += (0..planes).map(|ic| slope(ic, n - 2).abs()).fold(0.0, f64::max);
        }
        let mut across = 0.0;
        if planes > 1 {
            let rows = [low, gamma, high].map(|g| g.clamp(self.gamma_rad[0], self.gamma_rad[n - 1]));
            let value = |ic: usize, g: f64| self.at_rad(self.c_rad[ic % planes], g);
            for ic in 0..planes {
                let away = (self.c_rad[ic] - c + PI).rem_euclid(TAU) - PI;
                if away.abs() > spread_c {
                    continue;
                }
                let before = (ic + planes - 1) % planes;
                let widths = [
                    (self.c_rad[ic] - self.c_rad[before]).rem_euclid(TAU),
                    self.c_rad[ic + 1] - self.c_rad[ic],
                ];
                across += rows
                    .iter()
                    .map(|&g| {
                        let [left, mid, right] = [before, ic, ic + 1].map(|k| value(k, g));
                        ((right - mid) / widths[1] - (mid - left) / widths[0]).abs()
                    })
                    .fold(0.0, f64::max);
            }
        }
        along * spread + across * spread_c
    }

    /// Bounds on what lies within `reach` of the end of the line of sight `sight`; infinite at an end of the range that is no
    /// pole.
    pub(crate) fn bends(&self, sight: DVec3, reach: f64) -> Bends {
        const NONE: Bends = Bends {
            lines: f64::INFINITY,
            pole: f64::INFINITY,
        };
        let n = self.gamma_rad.len();
        let (distance, axis) = (sight.length(), sight.x.hypot(sight.y));
        if reach >= distance || n < 2 {
            return NONE;
        }
        let gamma = axis.atan2(sight.z);
        let spread = 1.02 * (reach / distance).asin();
        let (low, high) = (gamma - spread, gamma + spread);
        if low < self.gamma_rad[0] && self.gamma_rad[0] > 1e-9
            || high > self.gamma_rad[n - 1] && self.gamma_rad[n - 1] < PI - 1e-9
        {
            return NONE;
        }
        let from = self.gamma_rad.partition_point(|line| *line < low);
        let to = self.gamma_rad.partition_point(|line| *line <= high).max(from);
        let mut lines: f64 = self.rough[from..to].iter().map(|rough| rough.jump).sum::<f64>() * spread;
        // The lines round the reach as well: what holds at both ends holds between them.
        let around = &self.rough[from.max(1) - 1..(to + 1).min(n)];
        let most = |of: fn(&Rough) -> f64| around.iter().map(of).fold(0.0, f64::max);
        if !self.is_rotational() {
            // Between two lines a change of slope in C is no larger than linear between the lines' largest.
            let at = |gamma: f64, of: fn(&Rough) -> f64| {
                let gamma = gamma.clamp(self.gamma_rad[0], self.gamma_rad[n - 1]);
                let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
                let t = (gamma - self.gamma_rad[ig]) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig]);
                (1.0 - t) * of(&self.rough[ig]) + t * of(&self.rough[ig + 1])
            };
            let within = |of: fn(&Rough) -> f64| {
                let lines = self.rough[from..to].iter().map(of);
                lines.fold(at(low, of).max(at(high, of)), f64::max)
            };
            let round = within(|rough| rough.round);
            lines += if reach < 0.99 * axis {
                let spread_c = 1.02 * (reach / axis).asin();
                let c = sight.y.atan2(sight.x);
                let crossed = count_azimuths(&self.c_kinks, c - spread_c, c + spread_c);
                (crossed as f64 * within(|rough| rough.jump_c)).min(round) * spread_c
            } else {
                round * 0.5 * PI
            };
        }
        Bends {
            lines,
            pole: 2.0 * (most(|rough| rough.steep) + most(|rough| rough.turn)) * spread,
        }
    }

    fn find_rough(&mut self) {
        let n = self.gamma_rad.len();
        let planes = if self.is_rotational() { 1 } else { self.c_rad.len() - 1 };
        let mut rough = vec![Rough::default(); n];
        let at = |ic: usize, ig: usize| self.intensity_cd[ic % planes * n + ig];
        let slope = |ic: usize, ig: usize| {
            if ig + 1 < n {
                (at(ic, ig + 1) - at(ic, ig)) / (self.gamma_rad[ig + 1] - self.gamma_rad[ig])
            } else {
                0.0
            }
        };
        for (ig, rough) in rough.iter_mut().enumerate() {
            let sine = self.gamma_rad[ig].sin();
            for ic in 0..planes {
                rough.steep = rough.steep.max(slope(ic, ig).abs());
                if ig > 0 && ig + 1 < n {
                    rough.jump = rough.jump.max((slope(ic, ig) - slope(ic, ig - 1)).abs());
                }
                if planes > 1 {
                    let width = |ic: usize| self.c_rad[ic % planes + 1] - self.c_rad[ic % planes];
                    let across = |ic: usize| (at(ic + 1, ig) - at(ic, ig)) / width(ic);
                    let jump = (across(ic) - across(ic + planes - 1)).abs();
                    rough.jump_c = rough.jump_c.max(jump);
                    rough.round += jump;
                    let steep = across(ic).abs();
                    if steep > 0.0 {
                        rough.turn = rough.turn.max(steep / sine.max(1e-12));
                    }
                }
            }
        }
        self.rough = rough;
    }

    /// Azimuths at which the interpolant bends, in [0, 2π), rising.
    pub(crate) fn c_kinks(&self) -> &[f64] {
        &self.c_kinks
    }

    /// Polar angles at which the interpolant bends or ends, rising.
    pub(crate) fn gamma_kinks(&self) -> &[f64] {
        &self.gamma_kinks
    }

    /// A grid line at which the slope does not change is no kink; the ends of the range are unless they are the poles.
    fn find_kinks(&mut self) {
        let (nc, ng) = (self.c_rad.len(), self.gamma_rad.len());
        let peak = self
            .intensity_cd
            .iter()
            .fold(0.0_f64, |peak, value| peak.max(value.abs()));
        self.peak_cd = peak;
        let at = |ic: usize, ig: usize| self.intensity_cd[ic * ng + ig];
        let bends = |x: [f64; 3], y: [f64; 3]| {
            let straight = y[0] + (y[2] - y[0]) * (x[1] - x[0]) / (x[2] - x[0]);
            (y[1] - straight).abs() > 1e-13 * peak
        };
        let mut gamma_kinks = Vec::new();
        for ig in 0..ng {
            let gamma = self.gamma_rad[ig];
            let pole = !(1e-9..=PI - 1e-9).contains(&gamma);
            let end = ig == 0 || ig + 1 == ng;
            let kink = if end {
                !pole
            } else {
                let x = [self.gamma_rad[ig - 1], gamma, self.gamma_rad[ig + 1]];
                (0..nc).any(|ic| bends(x, [at(ic, ig - 1), at(ic, ig), at(ic, ig + 1)]))
            };
            if kink {
                gamma_kinks.push(gamma);
            }
        }
        let mut c_kinks = Vec::new();
        if nc > 1 {
            let planes = nc - 1;
            for ic in 0..planes {
                let (before, x0) = if ic == 0 {
                    (planes - 1, self.c_rad[planes - 1] - TAU)
                } else {
                    (ic - 1, self.c_rad[ic - 1])
                };
                let x = [x0, self.c_rad[ic], self.c_rad[ic + 1]];
                if (0..ng).any(|ig| bends(x, [at(before, ig), at(ic, ig), at(ic + 1, ig)])) {
                    c_kinks.push(self.c_rad[ic].rem_euclid(TAU));
                }
            }
            c_kinks.sort_by(f64::total_cmp);
        }
        self.c_kinks = c_kinks;
        self.gamma_kinks = gamma_kinks;
    }
}

/// How many `kinks` (in [0, 2π), rising) lie between two azimuths less than a turn apart.
fn count_azimuths(kinks: &[f64], from: f64, to: f64) -> usize {
    let turn = from.div_euclid(TAU) * TAU;
    let (low, high) = (from - turn, to - turn);
    let below = |x: f64| kinks.partition_point(|kink| *kink < x);
    below(high) - below(low) + below(high - TAU)
}
