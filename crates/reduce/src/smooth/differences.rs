//! Third differences between neighbouring directions, and the variance that the light itself has there.

use std::collections::BTreeMap;

use super::nodes::Nodes;
use crate::grid::{Grid, is_pole};

/// Half-planes to either side, and γ, over which the variance of the light is taken.
const AROUND: (usize, usize) = (3, 4);

/// Least variance of the light's differences, relative to that of rounding and scatter.
const LEAST_VARIANCE: f64 = 1e-3;

/// Standard deviations of the mean of so few squares that are added to the variance of the light in the mean of all
/// half-planes: where that came out too small by chance, a curve that all half-planes have would be bent straight.
const DOUBT: f64 = 2.0;

/// Half-planes further apart than this do not tell of each other.
const LARGEST_STEP_C_DEG: f64 = 45.0;

/// One difference of neighbours.
pub struct Row {
    /// Nodes and their weights.
    pub terms: Vec<(usize, f64)>,
    /// Half-plane and γ that it stands at.
    at: (usize, usize),
    /// Variance that the light has there.
    pub variance: f64,
}

impl Row {
    const fn new(terms: Vec<(usize, f64)>, at: (usize, usize)) -> Self {
        Self {
            terms,
            at,
            variance: 0.0,
        }
    }

    /// The mean of the rows of all half-planes.
    fn mean(rows: &[Self]) -> Self {
        let mut terms: BTreeMap<usize, f64> = BTreeMap::new();
        for &(node, weight) in rows.iter().flat_map(|row| &row.terms) {
            *terms.entry(node).or_default() += weight / rows.len() as f64;
        }
        Self::new(terms.into_iter().collect(), (0, rows[0].at.1))
    }

    /// What the row of one half-plane differs from their mean.
    fn less(&self, mean: &Self) -> Self {
        let mut terms: BTreeMap<usize, f64> = mean.terms.iter().map(|(node, weight)| (*node, -weight)).collect();
        for &(node, weight) in &self.terms {
            *terms.entry(node).or_default() += weight;
        }
        Self::new(terms.into_iter().collect(), self.at)
    }

    pub fn width(&self) -> usize {
        let nodes = || self.terms.iter().map(|(node, _)| *node);
        nodes().max().unwrap_or(0) - nodes().min().unwrap_or(0)
    }

    pub fn value(&self, of_nodes: &[f64]) -> f64 {
        self.terms.iter().map(|&(node, weight)| weight * of_nodes[node]).sum()
    }
}

/// All third differences: along every meridian, across the poles too, and around every circle of equal γ.
pub fn differences(grid: &Grid, nodes: &Nodes) -> Vec<Row> {
    let raw = &grid.distribution;
    let (c_deg, gammas) = (raw.c_deg(), raw.gamma_deg());
    let (planes, last) = (c_deg.len(), gammas.len() - 1);
    let node = |ic: usize, ig: usize| nodes.of_place[ic * gammas.len() + ig];
    // Of each window of four γ the differences of all half-planes that have it.
    let mut windows: BTreeMap<usize, Vec<Row>> = BTreeMap::new();
    for ic in 0..planes {
        let opposite = c_deg.iter().position(|c| ((c - c_deg[ic]).abs() - 180.0).abs() < 1e-9);
        let opposite = if planes == 1 { Some(0) } else { opposite };
        let mut meridian: Vec<(usize, f64)> = (0..=last).map(|ig| (node(ic, ig), gammas[ig])).collect();
        let mut before = 0;
        if let Some(opposite) = opposite {
            if gammas[0] == 0.0 && last > 0 {
                meridian.insert(0, (node(opposite, 1), -gammas[1]));
                before = 1;
            }
            if gammas[last] == 180.0 && last > 0 {
                meridian.push((node(opposite, last - 1), 360.0 - gammas[last - 1]));
            }
        }
        for (first, four) in meridian.windows(4).enumerate() {
            windows.entry(first + 1 - before).or_default().push(Row::new(
                third_difference([four[0], four[1], four[2], four[3]]),
                (ic, (first + 1).saturating_sub(before)),
            ));
        }
    }
    let (mut means, mut rows) = (Vec::new(), Vec::new());
    for of_planes in windows.into_values() {
        if of_planes.len() < planes {
            rows.extend(of_planes);
            continue;
        }
        let mean = Row::mean(&of_planes);
        if planes > 1 {
            rows.extend(of_planes.iter().map(|row| row.less(&mean)));
        }
        means.push(mean);
    }
    let alone = |row: &Row| -> f64 { row.terms.iter().map(|(node, a)| (a * nodes.u_cd[*node]).powi(2)).sum() };
    signal_variance(&mut rows, nodes, (planes, gammas.len()), 0.0, alone);
    signal_variance(&mut means, nodes, (1, gammas.len()), DOUBT, |row| {
        variance_of_rings(nodes, row)
    });
    rows.extend(means);
    let step = |ic: usize| (c_deg[(ic + 1) % planes] - c_deg[ic]).rem_euclid(360.0);
    if planes >= 6 && (0..planes).all(|ic| step(ic) <= LARGEST_STEP_C_DEG) {
        let mut around = Vec::new();
        for ic in 0..planes {
            for (ig, gamma) in gammas.iter().enumerate() {
                if !is_pole(*gamma) {
                    let at = |k: usize| {
                        let (turn, plane) = ((ic + k) / planes, (ic + k) % planes);
                        (node(plane, ig), c_deg[plane] + 360.0 * turn as f64)
                    };
                    let four = [at(0), at(1), at(2), at(3)];
                    around.push(Row::new(third_difference(four), ((ic + 1) % planes, ig)));
                }
            }
        }
        signal_variance(&mut around, nodes, (planes, gammas.len()), 0.0, alone);
        rows.extend(around);
    }
    rows.retain(|row| row.variance > 0.0);
    rows
}

/// Divided difference over four places, scaled as if they were one apart: −1, 3, −3, 1 where they are evenly spaced.
fn third_difference(along: [(usize, f64); 4]) -> Vec<(usize, f64)> {
    let step = (along[3].1 - along[0].1) / 3.0;
    let mut terms: Vec<(usize, f64)> = Vec::with_capacity(4);
    for (k, (node, at)) in along.into_iter().enumerate() {
        let others = along.iter().enumerate().filter(|(other, _)| *other != k);
        let weight = others.fold(6.0, |weight, (_, (_, other))| weight * step / (at - other));
        // Across a pole of a rotational lamp one node stands on both sides.
        match terms.iter_mut().find(|term| term.0 == node) {
            Some(term) => term.1 += weight,
            None => terms.push((node, weight)),
        }
    }
    terms
}

/// The variance of the light's own differences at every row: how much larger the squares around it are than `noise2`,
/// what rounding and scatter make them, with so many standard deviations of that estimate.
fn signal_variance(
    rows: &mut [Row],
    nodes: &Nodes,
    (planes, gammas): (usize, usize),
    doubt: f64,
    noise2: impl Fn(&Row) -> f64,
) {
    let mut excess: Vec<Option<(f64, f64)>> = vec![None; planes * gammas];
    for row in rows.iter() {
        let noise2 = noise2(row);
        if noise2 > 0.0 {
            let here = excess[row.at.0 * gammas + row.at.1].get_or_insert((0.0, 0.0));
            here.0 += row.value(&nodes.raw_cd).powi(2) / noise2;
            here.1 += 1.0;
        }
    }
    let wide = AROUND.0.min((planes - 1) / 2);
    for row in rows.iter_mut() {
        let (ic, ig) = row.at;
        let (mut sum, mut count) = (0.0, 0.0);
        for d in 0..=2 * wide {
            let plane = (ic + planes + d - wide) % planes;
            for at in ig.saturating_sub(AROUND.1)..=(ig + AROUND.1).min(gammas - 1) {
                if let Some((squares, rows)) = excess[plane * gammas + at] {
                    sum += squares;
                    count += rows;
                }
            }
        }
        let noise2 = noise2(row);
        row.variance = if count > 0.0 {
            noise2 * (sum / count - 1.0 + doubt * f64::sqrt(2.0 / count)).max(LEAST_VARIANCE)
        } else {
            0.0
        };
    }
}

/// Variance that rounding and scatter give a row that has equal weights all around every γ.
fn variance_of_rings(nodes: &Nodes, row: &Row) -> f64 {
    let mut of_rings: BTreeMap<usize, f64> = BTreeMap::new();
    for &(node, weight) in &row.terms {
        let ring = nodes.rings.partition_point(|ring| ring.nodes.end <= node);
        *of_rings.entry(ring).or_default() += weight;
    }
    let of_ring = |(ring, weight): (usize, f64)| (weight * nodes.rings[ring].u_mean_cd).powi(2);
    of_rings.into_iter().map(of_ring).sum()
}
