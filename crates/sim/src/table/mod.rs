//! The intensity distribution as the solvers read it: radians, one look-up, and the list of its kinks.

mod kinks;
mod search;

use std::f64::consts::TAU;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;

use self::kinks::Rough;
pub(crate) use self::search::Search;

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
}
