//! The grid refined where the sensor can be reached, and which of its cells reach it.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::cell::Cell;
use crate::sensor::Sensor;
use crate::source::Part;
use crate::table::IntensityTable;

/// Largest width in radians of a cell that reaches the sensor: the Taylor series of sine and cosine are exact to 1e-15.
const WIDTH: f64 = 0.05;
/// By how much, in radians, targets are larger than they must be: more than the places of cells are rounded.
const SLACK: f64 = 1e-12;
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
                (ball / distance).asin() * (1.0 + 1e-9) + 2.0 * SLACK
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

/// Whether a ray of `cell` may reach the sensor; a few that say so do not.
pub(super) fn cell_reaches(cell: &Cell, c: f64, targets: &Targets) -> bool {
    let ([from, to], [middle_c, half]) = (targets.gamma, targets.c);
    if cell.gamma > to - SLACK || cell.gamma + cell.d_gamma < from + SLACK {
        return false;
    }
    let away = (c + 0.5 * cell.d_c - middle_c + PI).rem_euclid(TAU) - PI;
    if away.abs() > half + 0.5 * cell.d_c - SLACK {
        return false;
    }
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
    pub fn of(table: &IntensityTable, targets: &Targets) -> Self {
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

    pub fn cell(&self, table: &IntensityTable, part: u32, ic: usize, ig: usize) -> (Cell, f64) {
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
    pub fn negative(&self, table: &IntensityTable, ic: usize, ig: usize) -> f64 {
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

    fn corners(&self, table: &IntensityTable, ic: usize, ig: usize) -> [f64; 4] {
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use isolux_photometry::IntensityDistribution;

    use super::*;
    use crate::random::{Purpose, Random};
    use crate::sensor::{Pose, rotation};
    use crate::source::Shape;

    fn sensor(tilt_x_deg: f64, offset_mm: [f64; 2], pixels: [usize; 2]) -> Sensor {
        Sensor::new(&Pose {
            size_mm: [60.0, 40.0],
            pixels,
            distance_mm: 90.0,
            tilt_x_deg,
            tilt_y_deg: -15.0,
            rot_z_deg: 30.0,
            offset_mm,
        })
        .unwrap()
    }

    /// Every ray between a point of the emitter and one of the sensor leaves through a cell that may reach it.
    #[test]
    fn no_ray_that_reaches_the_sensor_leaves_through_a_cell_that_is_left_out() {
        let c_deg: Vec<f64> = (0..8).map(|k| 45.0 * f64::from(k)).collect();
        let gamma_deg = vec![0.0, 4.0, 9.0, 15.0, 30.0, 60.0, 90.0, 180.0];
        let table = IntensityDistribution::new(c_deg, gamma_deg.clone(), vec![1.0; 8 * gamma_deg.len()]).unwrap();
        let table = Arc::new(IntensityTable::new(&table));
        let shapes = [
            Shape::Point(DVec3::ZERO),
            Shape::Disc {
                centre: DVec3::new(1.0, 2.0, 0.0),
                radius: 6.0,
            },
            Shape::Rectangle {
                centre: DVec3::ZERO,
                half: [9.0, 2.0],
            },
        ];
        let aims = [None, Some(rotation(20.0, 35.0, 0.0))];
        let places = [[0.0, 0.0], [50.0, 30.0], [-70.0, 0.5], [0.0, -120.0]];
        let mut random = Random::new(3, Purpose::Trial).sequence(0);
        let (mut left_out, mut cells) = (0, 0);
        for (shape, aim) in shapes.iter().flat_map(|shape| aims.map(|aim| (*shape, aim))) {
            for (place, pixels) in places
                .into_iter()
                .flat_map(|place| [(place, [7, 5]), (place, [300, 200])])
            {
                let sensor = sensor(10.0, place, pixels);
                let part = Part {
                    share: 1.0,
                    shape,
                    table: Arc::clone(&table),
                    aim,
                };
                let targets = targets(&part, &sensor);
                let grid = Grid::of(&table, &targets);
                let reaches = |ic: usize, ig: usize| {
                    let (cell, _) = grid.cell(&table, 0, ic, ig);
                    cell_reaches(&cell, grid.c[ic], &targets)
                };
                for _ in 0..300 {
                    let [x, y] = [sensor.nx, sensor.ny].map(|pixels| random.uniform() * pixels as f64);
                    let ray = sensor.point(x, y) - shape.point(random.uniform(), random.uniform());
                    let own = aim.map_or(ray, |aim| aim.transpose() * ray);
                    let c = grid.c[0] + (own.y.atan2(own.x) - grid.c[0]).rem_euclid(TAU);
                    let gamma = own.x.hypot(own.y).atan2(own.z);
                    let at = |lines: &[f64], value: f64| lines.partition_point(|line| *line <= value) - 1;
                    let (ic, ig) = (at(&grid.c, c), at(&grid.gamma, gamma));
                    assert!(reaches(ic, ig), "{shape:?} {place:?}: C {c} γ {gamma}");
                }
                for (ic, ig) in (0..grid.c.len() - 1).flat_map(|ic| (0..grid.gamma.len() - 1).map(move |ig| (ic, ig))) {
                    cells += 1;
                    left_out += usize::from(!reaches(ic, ig));
                }
            }
        }
        assert!(2 * left_out > cells, "{left_out} of {cells} cells are left out");
    }
}
