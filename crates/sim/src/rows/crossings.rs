//! Where half-planes and cones of a grid cross a row of pixels, and which pixels they may touch.

use glam::DVec3;

use super::Rows;
use super::lamp::{Cone, Lamp, Plane};

impl Rows<'_> {
    /// Pixels between two places.
    pub(super) fn whole(&self, low: f64, high: f64) -> Option<[usize; 2]> {
        let (low, high) = (low.max(0.0), high.min(self.nx as f64));
        (low < high).then(|| [low.floor() as usize, (high.ceil() as usize).min(self.nx)])
    }

    /// Pixels of a row that a half-plane may cross, from the places where it crosses the row's edges and middle.
    pub(super) fn by_plane(&self, lamp: &Lamp<'_>, plane: &Plane, edges: [f64; 3]) -> Option<[usize; 2]> {
        let found = edges.map(|y| lamp.plane_crossing(lamp.corner + y * lamp.step_y, plane.turn));
        let mut hull = [f64::INFINITY, f64::NEG_INFINITY];
        for u in found.into_iter().flatten() {
            hull = [hull[0].min(u), hull[1].max(u)];
        }
        // A half-plane that begins within the row, or runs along it.
        let some = found.iter().flatten().count();
        if some == 1 || some == 2 || some == 0 && lamp.side_changes(edges, plane.turn) {
            hull = if some == 0 {
                [0.0, self.nx as f64]
            } else {
                lamp.widened(hull, edges[1])
            };
        }
        self.whole(hull[0] - 1.0, hull[1] + 1.0)
    }

    /// Pixels of a row that a cone may cross, in one run or two.
    pub(super) fn by_cone(&self, lamp: &Lamp<'_>, cone: &Cone, edges: [f64; 3]) -> [Option<[usize; 2]>; 2] {
        let found = edges.map(|y| lamp.cone_crossings(lamp.corner + y * lamp.step_y, cone.cosine));
        let hull = |of: &mut dyn Iterator<Item = f64>| {
            let [low, high] = of.fold([f64::INFINITY, f64::NEG_INFINITY], |hull, u| {
                [hull[0].min(u), hull[1].max(u)]
            });
            self.whole(low - 1.0, high + 1.0)
        };
        if found.iter().all(|pair| pair[0].is_some() && pair[1].is_some()) {
            let runs = [0, 1].map(|k: usize| hull(&mut found.iter().filter_map(|pair| pair[k])));
            let apart = runs[0].zip(runs[1]).is_none_or(|(a, b)| a[1] <= b[0] || b[1] <= a[0]);
            if apart {
                return runs;
            }
        }
        [hull(&mut found.iter().flatten().copied().flatten()), None]
    }
}

impl Lamp<'_> {
    /// The place along the row at `a` of a half-plane of azimuth.
    pub fn plane_crossing(&self, a: DVec3, [sin, cos]: [f64; 2]) -> Option<f64> {
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
    pub fn cone_crossings(&self, a: DVec3, cosine: f64) -> [Option<f64>; 2] {
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
    pub fn nearest_to_axis(&self, y: f64) -> f64 {
        let (a, b) = ((self.corner + y * self.step_y).truncate(), self.step_x.truncate());
        -a.dot(b) / b.length_squared().max(1e-300)
    }

    /// From where to where row `y` is within `axis` of the pole axis.
    pub fn near_axis(&self, y: f64) -> Option<[f64; 2]> {
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
