//! The intensity distribution as the solvers read it: radians, one look-up, and the list of its kinks.

mod kinks;
mod rough;
mod search;

use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use glam::DVec3;
use isolux_photometry::IntensityDistribution;

use self::rough::Rough;
pub(crate) use self::search::Search;
use crate::angles::{LANES, Lanes};

/// Bilinear interpolant of an intensity distribution in candela, periodic in C, dark outside its γ range.
#[derive(Debug, Clone)]
pub struct IntensityTable {
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
    /// One over the widths of the intervals.
    per_c: Vec<f64>,
    per_gamma: Vec<f64>,
    /// Seen in a mirror at γ = 90°, made when it is asked for.
    upside_down: OnceLock<Box<IntensityTable>>,
}

/// One bilinear cell: the interpolant between four of its grid's lines.
struct Cell {
    /// First line, and one over the width.
    c: [f64; 2],
    gamma: [f64; 2],
    /// Intensities at `[C][γ]`, cd.
    corner: [[f64; 2]; 2],
}

impl Cell {
    /// The interpolant at (C, γ), and whether the cell holds all of them.
    fn holds_all(&self, c: &Lanes, gamma: &Lanes, out: &mut Lanes) -> bool {
        within(self.c, self.gamma, self.corner, c, gamma, out)
    }
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn within(
    [c0, per_c]: [f64; 2],
    [gamma0, per_gamma]: [f64; 2],
    [low, high]: [[f64; 2]; 2],
    c: &Lanes,
    gamma: &Lanes,
    out: &mut Lanes,
) -> bool {
    let mut outside = 0.0_f64;
    for lane in 0..LANES {
        let (s, t) = ((c[lane] - c0) * per_c, (gamma[lane] - gamma0) * per_gamma);
        let (a, b) = (low[0] + t * (low[1] - low[0]), high[0] + t * (high[1] - high[0]));
        out[lane] = a + s * (b - a);
        let away = (s - 0.5).abs().max((t - 0.5).abs());
        outside = if away > outside { away } else { outside };
    }
    outside <= 0.5 + 1e-9
}

impl IntensityTable {
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
        Self::over(c_rad, gamma_rad, intensity_cd)
    }

    fn over(c_rad: Vec<f64>, gamma_rad: Vec<f64>, intensity_cd: Vec<f64>) -> Self {
        let c_search = Search::over(&c_rad);
        let gamma_search = Search::over(&gamma_rad);
        let per = |grid: &[f64]| grid.windows(2).map(|pair| (pair[1] - pair[0]).recip()).collect();
        let mut table = Self {
            per_c: per(&c_rad),
            per_gamma: per(&gamma_rad),
            c_rad,
            gamma_rad,
            intensity_cd,
            c_kinks: Vec::new(),
            gamma_kinks: Vec::new(),
            rough: Vec::new(),
            peak_cd: 0.0,
            c_search,
            gamma_search,
            upside_down: OnceLock::new(),
        };
        table.find_kinks();
        table.find_rough();
        table
    }

    /// The table of the light seen in a mirror at γ = 90°.
    pub(crate) fn upside_down(&self) -> &Self {
        self.upside_down.get_or_init(|| {
            let n = self.gamma_rad.len();
            let rows = self.intensity_cd.chunks(n);
            Box::new(Self::over(
                self.c_rad.clone(),
                self.gamma_rad.iter().rev().map(|gamma| PI - gamma).collect(),
                rows.flat_map(|row| row.iter().rev().copied()).collect(),
            ))
        })
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
        let tg = ((gamma - self.gamma_rad[ig]) * self.per_gamma[ig]).clamp(0.0, 1.0);
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
        let tc = (c - self.c_rad[ic]) * self.per_c[ic];
        let low = along(ic);
        low + tc * (along(ic + 1) - low)
    }

    /// Intensities in candela at azimuths `c` and polar angles `gamma`: where one cell holds them all, without looking
    /// up each.
    pub(crate) fn several(&self, c: &Lanes, gamma: &Lanes) -> Lanes {
        let mut out = [0.0; LANES];
        if let Some(cell) = self.cell(c[0], gamma[0])
            && cell.holds_all(c, gamma, &mut out)
        {
            return out;
        }
        for (lane, out) in out.iter_mut().enumerate() {
            *out = self.at_rad(c[lane], gamma[lane]);
        }
        out
    }

    /// The cell that holds azimuth `c` in [−π, π] and polar angle `gamma`, radians; `None` outside the range.
    #[inline]
    fn cell(&self, c: f64, gamma: f64) -> Option<Cell> {
        let n = self.gamma_rad.len();
        if n < 2 || gamma < self.gamma_rad[0] || gamma > self.gamma_rad[n - 1] {
            return None;
        }
        let ig = self.gamma_search.interval(&self.gamma_rad, gamma);
        let at = |row: usize| [self.intensity_cd[row * n + ig], self.intensity_cd[row * n + ig + 1]];
        let gamma = [self.gamma_rad[ig], self.per_gamma[ig]];
        if self.is_rotational() {
            return Some(Cell {
                c: [0.0; 2],
                gamma,
                corner: [at(0); 2],
            });
        }
        let turned = if c < self.c_rad[0] { c + TAU } else { c };
        let ic = self.c_search.interval(&self.c_rad, turned);
        Some(Cell {
            c: [self.c_rad[ic] + (c - turned), self.per_c[ic]],
            gamma,
            corner: [at(ic), at(ic + 1)],
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
