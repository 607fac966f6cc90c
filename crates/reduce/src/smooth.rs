//! Readings as intervals, and the smoothest distribution that they allow.
//!
//! A display that rounds gives an interval of light, not a value, and its roundings differ from direction to direction as
//! the light does not. What is sought is the distribution x that makes
//!
//! Σ (D x)²/v + Σ ((x − y)/s)² least, with |x − y| ≤ w at every direction:
//!
//! y is the raw intensity and s its standard uncertainty from rounding and scatter; w is half a digit and twice the
//! scatter; D are third differences along γ and along C, and v is the variance that the light itself has there: the squares
//! of the raw differences around a direction, less what rounding and scatter alone give. A cut-off or a narrow beam has
//! large differences, and the sum leaves it as it was read; where the readings differ by no more than they are rounded, it
//! follows a smooth curve through their intervals. Without the middle term, the smoothest distribution inside the intervals
//! lies on their ends and flattens every maximum by half a digit. A negative intensity is as good as another.

mod boxed;

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
/// Half-planes further apart than this do not tell of each other.
const LARGEST_STEP_C_DEG: f64 = 45.0;
/// Multiplications that a step of the solver may take; grids beyond it stay raw.
const MOST_WORK: f64 = 4e9;
/// The value of the sum is within this of its least value, for each direction: in units of the intervals' half widths the
/// solution is then within 10⁻³ (rms) of the exact one, as the second term is at least 3 times the square of that distance.
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
    for node in 0..count {
        // A direction without rounding and scatter is what was read.
        let closeness = if nodes.u_cd[node] > 0.0 {
            nodes.half_cd[node] / nodes.u_cd[node]
        } else {
            1.0
        };
        h.add_square(&[(node, closeness)]);
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

/// The directions of a grid, each once: a pole belongs to all half-planes. Numbered γ by γ, so that neighbours are close.
struct Nodes {
    /// The node of each place `[ic * ng + ig]` of the distribution.
    of_place: Vec<usize>,
    raw_cd: Vec<f64>,
    /// Standard uncertainty from rounding and scatter.
    u_cd: Vec<f64>,
    /// Half the width of the interval.
    half_cd: Vec<f64>,
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
        };
        for (ig, &gamma) in gammas.iter().enumerate() {
            let place = |ic: usize| ic * gammas.len() + ig;
            let sample = |ic: usize| &grid.nodes[grid.sample_of[place(ic)]];
            if is_pole(gamma) {
                // The mean of all half-planes: their scatter averages, equal roundings do not.
                let digit = (0..planes).map(|ic| sample(ic).u_digit_cd).fold(0.0, f64::max);
                let noise2: f64 = (0..planes).map(|ic| sample(ic).u_noise_cd.powi(2)).sum();
                (0..planes).for_each(|ic| nodes.of_place[place(ic)] = nodes.raw_cd.len());
                nodes.push(raw.intensity_cd()[ig], digit, noise2.sqrt() / planes as f64);
            } else {
                for ic in 0..planes {
                    nodes.of_place[place(ic)] = nodes.raw_cd.len();
                    nodes.push(
                        raw.intensity_cd()[place(ic)],
                        sample(ic).u_digit_cd,
                        sample(ic).u_noise_cd,
                    );
                }
            }
        }
        nodes
    }

    fn push(&mut self, raw_cd: f64, u_digit_cd: f64, u_noise_cd: f64) {
        self.raw_cd.push(raw_cd);
        self.u_cd.push(u_digit_cd.hypot(u_noise_cd));
        // The standard uncertainty of a rounding is digit/√12, so that half a digit is √3 of it.
        self.half_cd
            .push(3.0_f64.sqrt() * u_digit_cd + SCATTER_WIDTH * u_noise_cd);
    }
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
    let row = |along: [(usize, f64); 4], at: (usize, usize)| Row {
        terms: third_difference(along),
        at,
        variance: 0.0,
    };
    let mut along_gamma = Vec::new();
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
            along_gamma.push(row(
                [four[0], four[1], four[2], four[3]],
                (ic, (first + 1).saturating_sub(before)),
            ));
        }
    }
    let mut rows = along_gamma;
    signal_variance(&mut rows, nodes, (planes, gammas.len()));
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
                    around.push(row([at(0), at(1), at(2), at(3)], ((ic + 1) % planes, ig)));
                }
            }
        }
        signal_variance(&mut around, nodes, (planes, gammas.len()));
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

/// The variance of the light's own differences at every row: how much larger the squares around it are than rounding and
/// scatter make them.
fn signal_variance(rows: &mut [Row], nodes: &Nodes, (planes, gammas): (usize, usize)) {
    let mut excess: Vec<Option<(f64, f64)>> = vec![None; planes * gammas];
    let noise2 = |row: &Row| -> f64 { row.terms.iter().map(|(node, a)| (a * nodes.u_cd[*node]).powi(2)).sum() };
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
            noise2 * (sum / count - 1.0).max(LEAST_VARIANCE)
        } else {
            0.0
        };
    }
}

#[cfg(test)]
mod tests;
