//! The quick path: a fixed product rule over pixel and emitter, in the vector units, where the patch of directions is
//! small and at most one grid line of each kind crosses it.
//!
//! The interpolant is then one or four bilinear cells round the patch; angles are small differences from its middle, so
//! that a short series replaces the arc tangent, and nothing is looked up inside the loop. How far a bend can lead a rule
//! astray is measured on ramps when the rule is made: a rule is used only where that bound meets the tolerance.

use glam::DVec3;

use crate::angles::{self, LANES, Sights};
use crate::patch::{Light, Patch};
use crate::table::Table;

/// Nodes of pixel and emitter together: offsets from the line between their middles, and weights.
#[derive(Debug, Clone)]
pub(crate) struct Rule {
    x: Vec<[f64; LANES]>,
    y: Vec<[f64; LANES]>,
    z: Vec<[f64; LANES]>,
    w: Vec<[f64; LANES]>,
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
    /// Relative error on a smooth integrand, when the reach is `ratio` of the distance to its nearest singularity: n points
    /// a side are exact to degree 2n − 1.
    pub fn smooth(&self, ratio: f64) -> f64 {
        let one = |k: usize| (self.shares[k] * ratio).powi(2 * self.orders[k] as i32);
        one(0) + one(1)
    }

    /// Relative error on a function that is linear in the angles about an axis, when the reach is `ratio` of the distance from
    /// that axis: the tip of a cone where it is in reach.
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
    /// Mean of the light round the line of sight to `sight`, each node looked up.
    pub fn mean(&self, light: Light<'_>, sight: DVec3, scratch: &mut Vec<Sights>) -> f64 {
        angles::around(sight, [&self.x, &self.y, &self.z], &self.w, light.toward, scratch);
        let mut sum = 0.0;
        for sights in scratch.iter() {
            for lane in 0..LANES {
                let cd = light.table.at_rad(sights.c[lane], sights.gamma[lane]);
                let cd = if light.extinction_per_mm == 0.0 {
                    cd
                } else {
                    cd * (-light.extinction_per_mm * sights.length[lane]).exp()
                };
                sum += sights.per_cd[lane] * cd;
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

/// The interpolant round one patch, as hinges at one line of constant γ and one of constant C.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Local {
    sin_gamma: f64,
    cos_gamma: f64,
    sin_c: f64,
    cos_c: f64,
    /// γ of the hinge less γ of the middle, C likewise.
    hinge: [f64; 2],
    /// For C planes below, at and above the hinge: value at the γ hinge, slope below, slope above.
    column: [[f64; 3]; 3],
    /// 1/(distance of the planes) below and above.
    per_c: [f64; 2],
    rotational: bool,
    /// Change of slope in γ and in C at hinges inside the patch, cd/rad.
    pub bend: [f64; 2],
}

impl Local {
    /// The interpolant within `reach` of `sight`; `None` where more than one line of a kind, the pole of a table that
    /// depends on C, or the end of the γ range is in reach.
    pub fn new(table: &Table, sight: DVec3, reach: f64) -> Option<Self> {
        let distance = sight.length();
        let axis = (sight.x * sight.x + sight.y * sight.y).sqrt();
        if reach > 0.1 * distance {
            return None;
        }
        let gamma = axis.atan2(sight.z);
        let spread = 1.02 * reach / distance;
        let rotational = table.is_rotational();
        let pole = gamma < spread || gamma > std::f64::consts::PI - spread;
        if !rotational && reach > 0.1 * axis {
            return None;
        }
        let (g0, slopes) = hinge(&table.gamma_rad, gamma, spread)?;
        let n = table.gamma_rad.len();
        let row = |ic: usize| {
            let at = |ig: usize| table.intensity_cd[ic * n + ig];
            let slope = |ig: usize| (at(ig + 1) - at(ig)) / (table.gamma_rad[ig + 1] - table.gamma_rad[ig]);
            [at(g0), slope(slopes[0]), slope(slopes[1])]
        };
        let (sin_gamma, cos_gamma) = gamma.sin_cos();
        let bend_of = |column: &[f64; 3]| (column[2] - column[1]).abs();
        let hinge_gamma = table.gamma_rad[g0] - gamma;
        if rotational {
            let column = row(0);
            // The pole is the tip of a cone: the slope turns round there.
            let tip = if pole {
                2.0 * column[1].abs().max(column[2].abs())
            } else {
                0.0
            };
            return Some(Self {
                sin_gamma,
                cos_gamma,
                sin_c: 0.0,
                cos_c: 1.0,
                hinge: [hinge_gamma, 0.0],
                column: [column; 3],
                per_c: [0.0; 2],
                rotational,
                bend: [bend_of(&column) + tip, 0.0],
            });
        }
        let mut c = sight.y.atan2(sight.x);
        let first = table.c_rad[0];
        c = first + (c - first).rem_euclid(std::f64::consts::TAU);
        let planes = table.c_rad.len() - 1;
        let spread_c = 1.02 * reach / axis;
        // Planes once more on either side, so that the seam is a line like any other.
        let plane = |k: isize| {
            let turns = k.div_euclid(planes as isize);
            let index = k.rem_euclid(planes as isize) as usize;
            (index, table.c_rad[index] + turns as f64 * std::f64::consts::TAU)
        };
        let below = table.c_rad.partition_point(|line| *line <= c) as isize - 1;
        let mut inside = (below - 1..=below + 2).filter(|&k| (plane(k).1 - c).abs() <= spread_c);
        let (mid, sides) = match (inside.next(), inside.next()) {
            (None, _) => (below, [below, below]),
            (Some(k), None) => (k, [k - 1, k]),
            _ => return None,
        };
        let at_mid = plane(mid).1;
        let columns = [sides[0].min(mid - 1), mid, mid + 1].map(|k| row(plane(k).0));
        let per = |low: isize| 1.0 / (plane(low + 1).1 - plane(low).1);
        let per_c = [per(sides[0]), per(sides[1])];
        // Where no plane crosses the patch, both sides are the cell above the plane below.
        let columns = if sides[0] == mid {
            let (low, high) = (columns[1], columns[2]);
            [std::array::from_fn(|k| 2.0 * low[k] - high[k]), low, high]
        } else {
            columns
        };
        let bend_c = if sides[0] == mid {
            0.0
        } else {
            (0..3)
                .map(|k| {
                    let reach = if k == 0 { 1.0 } else { spread };
                    reach
                        * ((columns[2][k] - columns[1][k]) * per_c[1] - (columns[1][k] - columns[0][k]) * per_c[0])
                            .abs()
                })
                .fold(0.0, f64::max)
        };
        let (sin_c, cos_c) = c.sin_cos();
        Some(Self {
            sin_gamma,
            cos_gamma,
            sin_c,
            cos_c,
            hinge: [hinge_gamma, at_mid - c],
            column: columns,
            per_c,
            rotational,
            bend: [columns.iter().map(bend_of).fold(0.0, f64::max), bend_c],
        })
    }

    /// Intensity in cd towards the middle.
    pub fn middle_cd(&self) -> f64 {
        let along =
            |column: [f64; 3]| column[0] - self.hinge[0] * if self.hinge[0] <= 0.0 { column[2] } else { column[1] };
        let [low, mid, high] = self.column.map(along);
        if self.rotational {
            return mid;
        }
        let c = -self.hinge[1];
        mid + c * if c >= 0.0 {
            (high - mid) * self.per_c[1]
        } else {
            (mid - low) * self.per_c[0]
        }
    }

    /// Largest slopes in γ and in C, cd/rad.
    pub fn steep(&self) -> [f64; 2] {
        let gamma = self
            .column
            .iter()
            .map(|column| column[1].abs().max(column[2].abs()))
            .fold(0.0, f64::max);
        let [low, mid, high] = self.column.map(|column| column[0]);
        let c = ((mid - low) * self.per_c[0])
            .abs()
            .max(((high - mid) * self.per_c[1]).abs());
        // The columns stand at the hinge; a patch is within one cell of it.
        [gamma, if self.rotational { 0.0 } else { 2.0 * c }]
    }

    /// Mean over `rule` round the line of sight to `sight`.
    pub fn mean(&self, light: Light<'_>, sight: DVec3, rule: &Rule) -> f64 {
        let mean = sum(self, rule, sight.to_array(), light.toward.to_array());
        if light.extinction_per_mm == 0.0 {
            1e6 * mean
        } else {
            // Over a patch this small the path hardly changes: the middle's transmission, the slope being in the rule's reach.
            1e6 * mean * (-light.extinction_per_mm * sight.length()).exp()
        }
    }
}

/// The grid line within `spread` of `x`, or the one below it; and the intervals below and above. `None` for two lines in
/// reach and at the ends of the grid.
fn hinge(grid: &[f64], x: f64, spread: f64) -> Option<(usize, [usize; 2])> {
    let last = grid.len() - 1;
    // The poles are no ends: nothing lies beyond them.
    let ends = (grid[0] > 1e-9 && x - spread < grid[0])
        || (grid[last] < std::f64::consts::PI - 1e-9 && x + spread > grid[last])
        || last == 0;
    if ends {
        return None;
    }
    let from = grid.partition_point(|line| *line < x - spread).max(1);
    let to = grid.partition_point(|line| *line <= x + spread).min(last);
    match to.saturating_sub(from) {
        0 => {
            let interval = (grid.partition_point(|line| *line <= x).max(1) - 1).min(last - 1);
            Some((interval, [interval, interval]))
        }
        1 => Some((from, [from - 1, from])),
        _ => None,
    }
}

/// arctan for |x| ≤ 0.12, error below 1e-15.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside the multiversioned loop, or it would not be vectorised"
)]
fn small_atan(x: f64) -> f64 {
    let y = x * x;
    let series = 1.0 / 13.0 - y / 15.0;
    let series = 1.0 / 9.0 - y * (1.0 / 11.0 - y * series);
    let series = 1.0 / 5.0 - y * (1.0 / 7.0 - y * series);
    x * (1.0 - y * (1.0 / 3.0 - y * series))
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn sum(local: &Local, rule: &Rule, base: [f64; 3], toward: [f64; 3]) -> f64 {
    let [bx, by, bz] = base;
    let [tx, ty, tz] = toward;
    let [hinge_gamma, hinge_c] = local.hinge;
    let [low, mid, high] = local.column;
    let mut total = [0.0; LANES];
    for (((xs, ys), zs), ws) in rule.x.iter().zip(&rule.y).zip(&rule.z).zip(&rule.w) {
        for lane in 0..LANES {
            let (x, y, z) = (bx + xs[lane], by + ys[lane], bz + zs[lane]);
            let square = x * x + y * y;
            let axis = square.sqrt();
            let whole = square + z * z;
            let tangent =
                (axis * local.cos_gamma - z * local.sin_gamma) / (z * local.cos_gamma + axis * local.sin_gamma);
            let g = small_atan(tangent) - hinge_gamma;
            let above = g >= 0.0;
            let along = |column: [f64; 3]| column[0] + g * if above { column[2] } else { column[1] };
            let at = along(mid);
            let intensity = if local.rotational {
                at
            } else {
                let tangent = (y * local.cos_c - x * local.sin_c) / (x * local.cos_c + y * local.sin_c);
                let c = small_atan(tangent) - hinge_c;
                let slope = if c >= 0.0 {
                    (along(high) - at) * local.per_c[1]
                } else {
                    (at - along(low)) * local.per_c[0]
                };
                at + c * slope
            };
            let projected = (tx * x + ty * y + tz * z).max(0.0);
            total[lane] += ws[lane] * intensity * projected / (whole * whole.sqrt());
        }
    }
    total.iter().sum()
}
