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
    peak_cd: f64,
    c_search: Search,
    gamma_search: Search,
}

/// Buckets of equal width over a rising grid: the interval of an abscissa in constant time.
#[derive(Debug, Clone)]
struct Search {
    origin: f64,
    per_bucket: f64,
    first: Vec<u32>,
}

impl Search {
    fn over(grid: &[f64]) -> Self {
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
    fn interval(&self, grid: &[f64], x: f64) -> usize {
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
            peak_cd: 0.0,
            c_search,
            gamma_search,
        };
        table.find_kinks();
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
