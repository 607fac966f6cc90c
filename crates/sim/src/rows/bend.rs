//! Pixels that a kink crosses: what it adds to the value at their centre, or that they want their own integral.

use glam::DVec3;

use super::lamp::Within;
use super::{Rows, Work};
use crate::angles;
use crate::number::Number;

impl Rows<'_> {
    /// Adds to pixels of a row what a kink across them adds to the values at their centres.
    pub(super) fn bend<N: Number>(&self, iy: usize, line: &mut [N]) {
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

    /// Pixels of a row that centres do not stand for: near the pole axis, and across kinks that no ramp describes.
    pub(super) fn own_pixels(&self, iy: usize, work: &mut Work) {
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
