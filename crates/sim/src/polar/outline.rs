//! Integrals along an outline, as seen from one point of the sensor: cut where it crosses the lines of the grid.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::tables::Polar;
use crate::angles::atan2;
use crate::rules;
use crate::sines::sin_cos;

/// One point of the sensor: the foot is the origin.
pub(super) struct Sight<'a> {
    pub polar: &'a Polar<'a>,
    pub height: f64,
    pub toward: DVec3,
    /// Strip from which G counts.
    pub base: usize,
}

impl Sight<'_> {
    /// ∫ G dC along the arc of a circle between two angles (less than a turn apart, rising), counter-clockwise.
    pub fn arc(&self, centre: DVec2, radius: f64, [start, end]: [f64; 2], cuts: &mut Vec<f64>) -> Option<f64> {
        let (distance, away) = (centre.length(), atan2(centre.y, centre.x));
        // Angles count from the point that is farthest from the foot.
        let (start, end) = (start - away, end - away);
        cuts.clear();
        cuts.extend([start, end]);
        let mut push = |angle: f64| {
            let angle = start + (angle - start).rem_euclid(TAU);
            if angle < end {
                cuts.push(angle);
            }
        };
        push(0.0);
        push(PI);
        let (near, far) = ((distance - radius).powi(2), (distance + radius).powi(2));
        let square = self.height * self.height;
        let first = self.polar.cones.partition_point(|cone| cone * square <= near);
        for cone in &self.polar.cones[first..] {
            let cosine = (cone * square - distance * distance - radius * radius) / (2.0 * distance * radius);
            if cosine >= 1.0 || cone * square >= far {
                break;
            }
            let angle = cosine.clamp(-1.0, 1.0).acos();
            push(angle);
            push(-angle);
        }
        for plane in &self.polar.planes {
            let (along, aside) = (plane.dot(centre), plane.perp_dot(centre));
            let root = radius * radius - aside * aside;
            if root > 0.0 {
                let root = root.sqrt();
                for reach in [along - root, along + root] {
                    if reach > 0.0 {
                        let v = reach * *plane - centre;
                        push(atan2(v.y, v.x) - away);
                    }
                }
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let (sin, cos) = away.sin_cos();
        let mut sum = 0.0;
        for pair in cuts.windows(2) {
            // The nearest point to the foot is at a half turn, where the cuts have a place.
            let nearest = |at: f64| {
                (distance * distance + radius * radius + 2.0 * distance * radius * at.cos())
                    .max(0.0)
                    .sqrt()
            };
            // The outline itself is smooth on the scale of its radius.
            let ends = nearest(pair[0]).min(nearest(pair[1])).min(radius);
            sum += self.panel(*pair.first()?, *pair.last()?, ends, radius, radius, &mut |angle| {
                let (s, c) = sin_cos(angle);
                let out = DVec2::new(c * cos - s * sin, s * cos + c * sin);
                let at = centre + radius * out;
                (at, radius * at.dot(out))
            })?;
        }
        Some(sum)
    }

    /// ∫ G dC along a straight line.
    pub fn edge(&self, from: DVec2, to: DVec2, cuts: &mut Vec<f64>) -> Option<f64> {
        let along = to - from;
        let turn = from.perp_dot(along);
        let length = along.length();
        if turn.abs() <= 1e-14 * length * (from.length() + length) {
            // Seen from the foot the line does not turn.
            return Some(0.0);
        }
        cuts.clear();
        cuts.extend([0.0, 1.0]);
        let mut push = |u: f64| {
            if u > 0.0 && u < 1.0 {
                cuts.push(u);
            }
        };
        let nearest = -from.dot(along) / (length * length);
        push(nearest);
        let aside = turn * turn / (length * length);
        let square = self.height * self.height;
        let first = self.polar.cones.partition_point(|cone| cone * square <= aside);
        let far = from.length_squared().max(to.length_squared());
        for cone in &self.polar.cones[first..] {
            if cone * square >= far {
                break;
            }
            let half = (cone * square - aside).sqrt() / length;
            push(nearest - half);
            push(nearest + half);
        }
        for plane in &self.polar.planes {
            let u = -plane.perp_dot(from) / plane.perp_dot(along);
            if u > 0.0 && u < 1.0 && plane.dot(from + u * along) > 0.0 {
                push(u);
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        let mut sum = 0.0;
        for pair in cuts.windows(2) {
            let ends = (from + pair[0] * along).length().min((from + pair[1] * along).length());
            sum += self.panel(pair[0], pair[1], ends, length, f64::INFINITY, &mut |u| {
                (from + u * along, turn)
            })?;
        }
        Some(sum)
    }

    /// ∫ G·(turn/ρ²) over a parameter between two cuts, of which one is nearest to the foot: `place` gives the point
    /// and the turn x dy − y dx per parameter, `speed` is the length per parameter, `smooth` the scale of the outline
    /// itself.
    fn panel(
        &self,
        from: f64,
        to: f64,
        nearest: f64,
        speed: f64,
        smooth: f64,
        place: &mut dyn FnMut(f64) -> (DVec2, f64),
    ) -> Option<f64> {
        let width = to - from;
        if width <= 1e-14 {
            return Some(0.0);
        }
        let ratio = width * speed / nearest.max(1e-9 * self.height);
        if ratio > 1.0 && width * speed > 1e-6 * self.height {
            let middle = 0.5 * (from + to);
            let (at, _) = place(middle);
            let middle_distance = at.length().min(smooth);
            // Distances between are at least those of the ends, less half the way.
            let [low, high] = if place(from).0.length_squared() < place(to).0.length_squared() {
                [nearest, middle_distance]
            } else {
                [middle_distance, nearest]
            };
            return Some(
                self.panel(from, middle, low, speed, smooth, place)?
                    + self.panel(middle, to, high, speed, smooth, place)?,
            );
        }
        let order = match ratio {
            r if r < 0.03 => 2,
            r if r < 0.15 => 3,
            r if r < 0.4 => 4,
            r if r < 0.7 => 6,
            _ => 8,
        };
        let mut sum = 0.0;
        for &(s, weight) in rules::gauss(order) {
            let (at, turn) = place(from + width * s);
            let square = at.length_squared();
            if square > 0.0 {
                sum += weight * turn / square * self.polar.at(at, self.height, self.toward, self.base)?;
            }
        }
        Some(width * sum)
    }
}
