//! The grid refined where the sensor can be reached, and which of its cells reach it.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::cell::Cell;
use crate::sensor::Sensor;
use crate::source::Part;
use crate::table::Table;

/// Largest width in radians of a cell that reaches the sensor: the Taylor series of sine and cosine are exact to 1e-15.
const WIDTH: f64 = 0.05;
/// Patches along each side that stand for the sensor when cells are sorted.
const PATCHES: usize = 16;

/// Balls that cover the sensor as directions from a part's middle: direction, and angle that ball and emitter add with
/// its sine and cosine.
pub(super) struct Targets {
    cap: Vec<(DVec3, f64, [f64; 2])>,
    gamma: [f64; 2],
    /// Middle and half width in C; half width π where the pole is near.
    c: [f64; 2],
}

pub(super) fn targets(part: &Part, sensor: &Sensor) -> Targets {
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

pub(super) fn cell_reaches(cell: &Cell, targets: &Targets) -> bool {
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
    // Half the diagonal, measured along γ and along the widest parallel: an upper bound on any distance within the
    // cell.
    let radius = 0.5 * (cell.d_gamma + most_sin * cell.d_c) + 1e-12;
    let (sin, cos) = radius.sin_cos();
    targets.cap.iter().any(|&(to, angle, [angle_sin, angle_cos])| {
        angle + radius >= PI || middle.dot(to) >= angle_cos * cos - angle_sin * sin
    })
}

/// A grid with extra lines, none of which changes the interpolant.
pub(super) struct Grid {
    pub c: Vec<f64>,
    pub gamma: Vec<f64>,
}

impl Grid {
    pub fn of(table: &Table, targets: &Targets) -> Self {
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

    pub fn cell(&self, table: &Table, part: u32, ic: usize, ig: usize) -> (Cell, f64) {
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
    pub fn negative(&self, table: &Table, ic: usize, ig: usize) -> f64 {
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
