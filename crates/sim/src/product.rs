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
        &nodes(pixel, emitter, [fine_pixel.max(2), fine_emitter.max(2)]),
        rp + re,
    );
    [1.0, 2.0, 4.0, 7.0, 12.0, 20.0]
        .into_iter()
        .map(|total| {
            let orders = split(total, 16);
            let nodes = nodes(pixel, emitter, orders);
            let reach = (rp + re).max(1e-300);
            Rule::new(&nodes, &fine, reach, orders, [rp / reach, re / reach])
        })
        .collect()
}

fn nodes(pixel: &Patch, emitter: Option<&Patch>, orders: [usize; 2]) -> Vec<(DVec3, f64)> {
    let (mut at, mut spots) = (Vec::new(), Vec::new());
    pixel.nodes(orders[0], &mut at);
    match emitter {
        Some(emitter) => emitter.nodes(orders[1], &mut spots),
        None => spots.push((DVec3::ZERO, 1.0)),
    }
    at.iter()
        .flat_map(|&(a, w)| spots.iter().map(move |&(s, ws)| (a + s, w * ws)))
        .collect()
}

impl Rule {
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

    fn new(nodes: &[(DVec3, f64)], fine: &Ramps, reach: f64, orders: [usize; 2], shares: [f64; 2]) -> Self {
        let ramp = Ramps::of(nodes, reach).worst_against(fine);
        let mut rule = Self {
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            w: Vec::new(),
            nodes: nodes.to_vec(),
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
    fn of(nodes: &[(DVec3, f64)], reach: f64) -> Self {
        let mut means = Vec::new();
        for k in 0..7 {
            let (sin, cos) = (0.1 + 0.4488 * f64::from(k)).sin_cos();
            let g = DVec3::new(cos, sin, 0.0) / reach.max(1e-300);
            // All places at once: each node is looked at seven times.
            let places: [f64; 13] = std::array::from_fn(|step| -0.9 + 0.15 * step as f64);
            let mut sums = [0.0; 13];
            for &(v, w) in nodes {
                let height = g.dot(v);
                for (sum, t) in sums.iter_mut().zip(places) {
                    *sum += w * (height - t).max(0.0);
                }
            }
            means.extend(sums);
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
