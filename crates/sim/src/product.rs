//! The quick route: a fixed product rule over pixel and emitter, in the vector units.
//!
//! How far a bend of the interpolant can lead a rule astray is measured on ramps when the rule is made: a rule is used
//! only where that bound meets the tolerance.

use glam::DVec3;

use crate::angles::{self, LANES, Lanes, Sights};
use crate::patch::{Light, Patch};

/// Nodes of pixel and emitter together: offsets from the line between their middles, and weights.
#[derive(Debug, Clone)]
pub(crate) struct Rule {
    x: Vec<[f64; LANES]>,
    y: Vec<[f64; LANES]>,
    z: Vec<[f64; LANES]>,
    w: Vec<[f64; LANES]>,
    /// The same, one by one.
    pub nodes: Vec<(DVec3, f64)>,
    /// Worst error on a ramp of unit slope per unit of reach, over directions and places.
    pub ramp: f64,
    /// Points a side of pixel and emitter.
    orders: [usize; 2],
    /// Their shares of the reach.
    shares: [f64; 2],
}

/// Rules of rising cost for one pixel and one emitter patch (`None`: a point).
pub(crate) fn rules(pixel: &Patch, emitter: Option<&Patch>) -> Vec<Rule> {
    let (rp, re) = (pixel.radius(), emitter.map_or(0.0, Patch::radius));
    // Points a side stay well below those that measure the rule.
    let split = |total: f64, most: usize| {
        let of = |own: f64| ((total * own / (rp + re)).round() as usize).clamp(1, most);
        [of(rp), of(re)]
    };
    let [fine_pixel, fine_emitter] = split(32.0, 24);
    let fine = Ramps::of(
        &Nodes::new(pixel, emitter, [fine_pixel.max(2), fine_emitter.max(2)]),
        rp + re,
    );
    [1.0, 2.0, 4.0, 7.0, 12.0, 20.0]
        .into_iter()
        .map(|total| {
            let orders = split(total, 16);
            let nodes = Nodes::new(pixel, emitter, orders);
            let reach = (rp + re).max(1e-300);
            Rule::new(&nodes, &fine, reach, orders, [rp / reach, re / reach])
        })
        .collect()
}

/// Nodes of the pixel and of the emitter; a rule has each of the one with each of the other.
struct Nodes {
    pixel: Vec<(DVec3, f64)>,
    emitter: Vec<(DVec3, f64)>,
}

impl Nodes {
    fn new(pixel: &Patch, emitter: Option<&Patch>, orders: [usize; 2]) -> Self {
        let (mut at, mut spots) = (Vec::new(), Vec::new());
        pixel.nodes(orders[0], &mut at);
        match emitter {
            Some(emitter) => emitter.nodes(orders[1], &mut spots),
            None => spots.push((DVec3::ZERO, 1.0)),
        }
        Self {
            pixel: at,
            emitter: spots,
        }
    }

    fn product(&self) -> Vec<(DVec3, f64)> {
        let spots = |(a, w): (DVec3, f64)| self.emitter.iter().map(move |&(s, ws)| (a + s, w * ws));
        self.pixel.iter().copied().flat_map(spots).collect()
    }
}

impl Rule {
    /// Nodes with those that fill up the vector units.
    pub fn lanes(&self) -> usize {
        LANES * self.w.len()
    }

    /// Relative error on a smooth integrand, when the reach is `ratio` of the distance to its nearest singularity: n
    /// points a side are exact to degree 2n − 1.
    pub fn smooth(&self, ratio: f64) -> f64 {
        let one = |k: usize| (self.shares[k] * ratio).powi(2 * self.orders[k] as i32);
        one(0) + one(1)
    }

    /// Relative error on a function that is linear in the angles about an axis, when the reach is `ratio` of the
    /// distance from that axis: the tip of a cone where it is in reach.
    pub fn about(&self, ratio: f64) -> f64 {
        let tip = 2.0 * self.ramp;
        if ratio < 1.0 {
            tip.min(self.smooth(ratio) / ratio)
        } else {
            tip
        }
    }

    fn new(parts: &Nodes, fine: &Ramps, reach: f64, orders: [usize; 2], shares: [f64; 2]) -> Self {
        let ramp = Ramps::of(parts, reach).worst_against(fine);
        let nodes = parts.product();
        let mut rule = Self {
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            w: Vec::new(),
            nodes: Vec::new(),
            ramp,
            orders,
            shares,
        };
        for chunk in nodes.chunks(LANES) {
            let lane =
                |of: &dyn Fn(&(DVec3, f64)) -> f64, rest: f64| std::array::from_fn(|k| chunk.get(k).map_or(rest, of));
            // Empty lanes repeat a node with no weight.
            rule.x.push(lane(&|node| node.0.x, chunk[0].0.x));
            rule.y.push(lane(&|node| node.0.y, chunk[0].0.y));
            rule.z.push(lane(&|node| node.0.z, chunk[0].0.z));
            rule.w.push(lane(&|node| node.1, 0.0));
        }
        rule.nodes = nodes;
        rule
    }
}

impl Rule {
    /// Mean of the light round the line of sight to `sight`, lx.
    pub fn mean(&self, light: Light<'_>, sight: DVec3, scratch: &mut Vec<Sights>) -> f64 {
        angles::around(sight, [&self.x, &self.y, &self.z], &self.w, light.toward, scratch);
        let mut sum = 0.0;
        for sights in scratch.iter() {
            sum += light.along(sights).iter().sum::<f64>();
        }
        sum
    }

    /// The same round the lines of sight to a + x·b + y·c, one for each lane.
    pub fn means(&self, light: Light<'_>, a: DVec3, steps: [DVec3; 2], x: &Lanes, y: &Lanes) -> Lanes {
        let mut sum = [0.0; LANES];
        for &(node, weight) in &self.nodes {
            let found = light.along(&angles::across(a + node, steps, light.toward, x, y));
            for (sum, value) in sum.iter_mut().zip(found) {
                *sum += weight * value;
            }
        }
        sum
    }
}

/// Means of the ramps (g·v − t)₊, unit vectors g and v in units of the reach.
struct Ramps(Vec<f64>);

impl Ramps {
    /// Of each node of the pixel with each of the emitter: for those of the pixel, sums over the emitter's highest ones
    /// say what lies above a place.
    fn of(nodes: &Nodes, reach: f64) -> Self {
        let mut means = Vec::new();
        for k in 0..7 {
            let (sin, cos) = (0.1 + 0.4488 * f64::from(k)).sin_cos();
            let g = DVec3::new(cos, sin, 0.0) / reach.max(1e-300);
            let height = |&(v, w): &(DVec3, f64)| (g.dot(v), w);
            let mut falling: Vec<(f64, f64)> = nodes.emitter.iter().map(height).collect();
            falling.sort_by(|a, b| b.0.total_cmp(&a.0));
            // Weight and weighted height of the highest none, one, two …
            let mut sums = vec![(0.0, 0.0)];
            let (mut weight, mut moment) = (0.0, 0.0);
            for &(height, w) in &falling {
                (weight, moment) = (weight + w, moment + w * height);
                sums.push((weight, moment));
            }
            let pixel: Vec<(f64, f64)> = nodes.pixel.iter().map(height).collect();
            means.extend((0..13).map(|step| {
                let place = -0.9 + 0.15 * f64::from(step);
                let above = |&(height, w): &(f64, f64)| {
                    let level = place - height;
                    let (weight, moment) = sums[falling.partition_point(|(height, _)| *height > level)];
                    w * (moment - weight * level)
                };
                pixel.iter().map(above).sum::<f64>()
            }));
        }
        Self(means)
    }

    /// Seven directions and thirteen places see most of the worst case.
    fn worst_against(&self, fine: &Self) -> f64 {
        1.5 * self
            .0
            .iter()
            .zip(&fine.0)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_the_highest_are_the_means_of_the_ramps() {
        let pixel = Patch::Parallelogram {
            corner: DVec3::new(-0.1, -0.1, 500.0),
            first: DVec3::X * 0.2,
            second: DVec3::new(0.03, 0.2, 0.01),
        };
        let emitter = Patch::Parallelogram {
            corner: DVec3::new(-0.4, -0.3, 0.0),
            first: DVec3::X * 0.8,
            second: DVec3::Y * 0.6,
        };
        let (nodes, reach) = (Nodes::new(&pixel, Some(&emitter), [4, 6]), 0.7);
        let each = nodes.product();
        let found = Ramps::of(&nodes, reach).0;
        assert_eq!(found.len(), 7 * 13);
        for (at, mean) in found.iter().enumerate() {
            let (sin, cos) = (0.1 + 0.4488 * (at / 13) as f64).sin_cos();
            let g = DVec3::new(cos, sin, 0.0) / reach;
            let place = -0.9 + 0.15 * (at % 13) as f64;
            let one_by_one: f64 = each.iter().map(|&(v, w)| w * (g.dot(v) - place).max(0.0)).sum();
            assert!((mean - one_by_one).abs() < 1e-14, "{at}: {mean} {one_by_one}");
        }
    }
}
