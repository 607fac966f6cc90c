//! Readings as intervals, and the smoothest distribution that they allow.
//!
//! A display that rounds gives an interval of light, not a value, and its roundings differ from direction to direction
//! as the light does not. What is sought is the distribution x that makes
//!
//! Σ (D x)²/v + Σ ((x − y)/s)² least, with |x − y| ≤ w at every direction:
//!
//! y is the raw intensity and s its standard uncertainty from rounding and scatter; w is half a digit and twice the
//! scatter; D are third differences along γ and along C, and v is the variance that the light itself has there: the
//! squares of the raw differences around a direction, less what rounding and scatter alone give. A cut-off or a narrow
//! beam has large differences, and the sum leaves it as it was read; where the readings differ by no more than they are
//! rounded, it follows a smooth curve through their intervals. Without the second term, the smoothest distribution
//! inside the intervals lies on their ends and flattens every maximum by half a digit. A negative intensity is as good
//! as another.
//!
//! The mean of all half-planes is known better than each of them, and what a lamp has along γ it mostly has in all of
//! them. Both sums are therefore taken twice: of the mean over the half-planes, with the s and v of that mean, and of
//! what each half-plane differs from it, with its own. Taken of each half-plane alone, the sums bend a curvature that
//! all half-planes have by as much as one of them is uncertain, which is more than their mean is.

mod boxed;

use std::collections::BTreeMap;
use std::ops::Range;

use isolux_photometry::IntensityDistribution;
use serde::Serialize;

use crate::grid::{Grid, is_pole};
use boxed::Band;

/// Half the width of an interval beyond half a digit, in standard uncertainties of the scatter.
const SCATTER_WIDTH: f64 = 2.0;
/// Half-planes to either side, and γ, over which the variance of the light is taken.
const AROUND: (usize, usize) = (3, 4);
/// Least variance of the light's differences, relative to that of rounding and scatter.
const LEAST_VARIANCE: f64 = 1e-3;
/// Standard deviations of the mean of so few squares that are added to the variance of the light in the mean of all
/// half-planes: where that came out too small by chance, a curve that all half-planes have would be bent straight.
const DOUBT: f64 = 2.0;
/// Half-planes further apart than this do not tell of each other.
const LARGEST_STEP_C_DEG: f64 = 45.0;
/// Multiplications that a step of the solver may take; grids beyond it stay raw.
const MOST_WORK: f64 = 4e9;
/// The value of the sum is within this of its least value, for each direction: in units of the intervals' half widths
/// what a half-plane differs from the mean of all N is then within 10⁻³ (rms) of the exact one, and the mean within
/// 10⁻³·√N, as the second term is at least 3 times the squares of these distances.
const GAP: f64 = 1e-6;

/// What smoothing did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Smoothing {
    /// Root mean square of (smoothed − raw), in candela.
    pub rms_cd: f64,
    /// Largest difference, in candela.
    pub max_cd: f64,
    /// Largest difference relative to half the width of its interval: at most 1.
    pub max_of_half_width: f64,
}

/// Why a distribution stays raw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SmoothError {
    /// More directions than there is time for.
    #[error("the grid has too many directions to be smoothed: the distribution is the raw one")]
    TooLarge,
    /// The solver did not come within its stated distance of the solution.
    #[error("the smoothing did not converge: the distribution is the raw one")]
    NotConverged,
}

/// The smoothest distribution that the readings of `grid` allow.
///
/// # Errors
/// [`SmoothError`]: the raw distribution stands.
pub fn smooth(grid: &Grid) -> Result<(IntensityDistribution, Smoothing), SmoothError> {
    let nodes = Nodes::of(grid);
    let rows = differences(grid, &nodes);
    let count = nodes.raw_cd.len();
    let band = rows.iter().map(Row::width).max().unwrap_or(0);
    if count as f64 * (band as f64).powi(2) > MOST_WORK {
        return Err(SmoothError::TooLarge);
    }
    let mut h = Band::zero(count, band);
    let mut g = vec![0.0; count];
    for row in &rows {
        let sharpness = 1.0 / row.variance.sqrt();
        let terms: Vec<(usize, f64)> = row
            .terms
            .iter()
            .map(|&(node, weight)| (node, weight * nodes.half_cd[node] * sharpness))
            .collect();
        h.add_square(&terms);
        let value = row.value(&nodes.raw_cd) * sharpness;
        for &(node, weight) in &terms {
            g[node] += weight * value;
        }
    }
    for (node, half) in nodes.half_cd.iter().enumerate() {
        // A direction without rounding and scatter is what was read.
        if *half == 0.0 {
            h.add_square(&[(node, 1.0)]);
        }
    }
    for ring in &nodes.rings {
        for (terms, u_cd) in ring.modes(&nodes.u_cd) {
            if u_cd > 0.0 {
                let scaled: Vec<(usize, f64)> = terms
                    .iter()
                    .map(|&(node, weight)| (node, weight * nodes.half_cd[node] / u_cd))
                    .collect();
                h.add_square(&scaled);
            }
        }
    }
    let solution = boxed::solve(&h, &g, GAP * count as f64).ok_or(SmoothError::NotConverged)?;
    let change: Vec<f64> = solution.iter().zip(&nodes.half_cd).map(|(x, half)| x * half).collect();
    let raw = &grid.distribution;
    let smoothed = nodes
        .of_place
        .iter()
        .map(|&node| nodes.raw_cd[node] + change[node])
        .collect();
    let distribution = IntensityDistribution::new(raw.c_deg().to_vec(), raw.gamma_deg().to_vec(), smoothed)
        .map_err(|_| SmoothError::NotConverged)?;
    let places = nodes.of_place.len() as f64;
    let squares: f64 = nodes.of_place.iter().map(|&node| change[node].powi(2)).sum();
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    Ok((
        distribution,
        Smoothing {
            rms_cd: (squares / places).sqrt(),
            max_cd: largest(&change),
            max_of_half_width: largest(&solution),
        },
    ))
}

/// The directions of a grid, each once: a pole belongs to all half-planes. Numbered γ by γ, so that neighbours are
/// close.
struct Nodes {
    /// The node of each place `[ic * ng + ig]` of the distribution.
    of_place: Vec<usize>,
    raw_cd: Vec<f64>,
    /// Standard uncertainty from rounding and scatter.
    u_cd: Vec<f64>,
    /// Half the width of the interval.
    half_cd: Vec<f64>,
    /// The directions of each γ.
    rings: Vec<Ring>,
}

/// The directions of one γ; one alone at a pole.
struct Ring {
    nodes: Range<usize>,
    /// Standard uncertainty of their mean: equal roundings do not average.
    u_mean_cd: f64,
}

impl Ring {
    /// The mean of the ring and what each of its directions differs from it: terms and standard uncertainty of each.
    fn modes(&self, u_cd: &[f64]) -> Vec<(Vec<(usize, f64)>, f64)> {
        let share = 1.0 / self.nodes.len() as f64;
        let mean = self.nodes.clone().map(|node| (node, share)).collect();
        let mut modes = vec![(mean, self.u_mean_cd)];
        if self.nodes.len() > 1 {
            modes.extend(self.nodes.clone().map(|own| {
                let weight = |node: usize| if node == own { 1.0 - share } else { -share };
                (self.nodes.clone().map(|node| (node, weight(node))).collect(), u_cd[own])
            }));
        }
        modes
    }
}

impl Nodes {
    fn of(grid: &Grid) -> Self {
        let raw = &grid.distribution;
        let (planes, gammas) = (raw.c_deg().len(), raw.gamma_deg());
        let mut nodes = Self {
            of_place: vec![0; planes * gammas.len()],
            raw_cd: Vec::new(),
            u_cd: Vec::new(),
            half_cd: Vec::new(),
            rings: Vec::new(),
        };
        for (ig, &gamma) in gammas.iter().enumerate() {
            let place = |ic: usize| ic * gammas.len() + ig;
            let first = nodes.raw_cd.len();
            let samples: Vec<usize> = (0..planes).map(|ic| grid.sample_of[place(ic)]).collect();
            let (mut digit, noise) = of_mean(grid, &samples);
            if is_pole(gamma) {
                // Of one direction, all readings are rounded alike.
                digit = samples.iter().map(|&at| grid.nodes[at].u_digit_cd).fold(0.0, f64::max);
                (0..planes).for_each(|ic| nodes.of_place[place(ic)] = first);
                nodes.push(raw.intensity_cd()[ig], digit, noise);
            } else {
                for (ic, &at) in samples.iter().enumerate() {
                    nodes.of_place[place(ic)] = nodes.raw_cd.len();
                    let sample = &grid.nodes[at];
                    nodes.push(raw.intensity_cd()[place(ic)], sample.u_digit_cd, sample.u_noise_cd);
                }
            }
            nodes.rings.push(Ring {
                nodes: first..nodes.raw_cd.len(),
                u_mean_cd: digit.hypot(noise),
            });
        }
        nodes
    }

    /// Variance that rounding and scatter give a row that has equal weights all around every γ.
    fn variance_of_rings(&self, row: &Row) -> f64 {
        let mut of_rings: BTreeMap<usize, f64> = BTreeMap::new();
        for &(node, weight) in &row.terms {
            let ring = self.rings.partition_point(|ring| ring.nodes.end <= node);
            *of_rings.entry(ring).or_default() += weight;
        }
        let of_ring = |(ring, weight): (usize, f64)| (weight * self.rings[ring].u_mean_cd).powi(2);
        of_rings.into_iter().map(of_ring).sum()
    }

    fn push(&mut self, raw_cd: f64, u_digit_cd: f64, u_noise_cd: f64) {
        self.raw_cd.push(raw_cd);
        self.u_cd.push(u_digit_cd.hypot(u_noise_cd));
        // The standard uncertainty of a rounding is digit/√12, so that half a digit is √3 of it.
        self.half_cd
            .push(3.0_f64.sqrt() * u_digit_cd + SCATTER_WIDTH * u_noise_cd);
    }
}

/// What the mean of these samples is uncertain by, by rounding and by scatter: those with the same display are rounded
/// alike, and one that stands for several directions is wrong in all of them.
fn of_mean(grid: &Grid, samples: &[usize]) -> (f64, f64) {
    let share = 1.0 / samples.len() as f64;
    let mut shares: BTreeMap<usize, f64> = BTreeMap::new();
    for &sample in samples {
        *shares.entry(sample).or_default() += share;
    }
    let mut alike: BTreeMap<Result<i64, usize>, f64> = BTreeMap::new();
    let mut noise2 = 0.0;
    for (at, share) in shares {
        let sample = &grid.nodes[at];
        *alike.entry(sample.display.ok_or(at)).or_default() += share * sample.u_digit_cd;
        noise2 += (share * sample.u_noise_cd).powi(2);
    }
    let digit2: f64 = alike.values().map(|u_cd| u_cd * u_cd).sum();
    (digit2.sqrt(), noise2.sqrt())
}

/// One difference of neighbours.
struct Row {
    /// Nodes and their weights.
    terms: Vec<(usize, f64)>,
    /// Half-plane and γ that it stands at.
    at: (usize, usize),
    /// Variance that the light has there.
    variance: f64,
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

    fn width(&self) -> usize {
        let nodes = || self.terms.iter().map(|(node, _)| *node);
        nodes().max().unwrap_or(0) - nodes().min().unwrap_or(0)
    }

    fn value(&self, of_nodes: &[f64]) -> f64 {
        self.terms.iter().map(|&(node, weight)| weight * of_nodes[node]).sum()
    }
}

/// All third differences: along every meridian, across the poles too, and around every circle of equal γ.
fn differences(grid: &Grid, nodes: &Nodes) -> Vec<Row> {
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
        nodes.variance_of_rings(row)
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

#[cfg(test)]
mod tests;
