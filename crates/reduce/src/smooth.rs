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
mod differences;
mod nodes;

use isolux_photometry::IntensityDistribution;

use crate::grid::{Grid, Smoothing};
use boxed::Band;
use differences::{Row, differences};
use nodes::Nodes;

/// Multiplications that a step of the solver may take; grids beyond it stay raw.
const MOST_WORK: f64 = 4e9;
/// The value of the sum is within this of its least value, for each direction: in units of the intervals' half widths
/// what a half-plane differs from the mean of all N is then within 10⁻³ (rms) of the exact one, and the mean within
/// 10⁻³·√N, as the second term is at least 3 times the squares of these distances.
const GAP: f64 = 1e-6;

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

/// Replaces the distribution of `grid` by the smoothest one that its readings allow, and keeps the raw one beside it.
///
/// # Errors
/// [`SmoothError`]; the distribution is as it was then.
pub fn apply(grid: &mut Grid) -> Result<(), SmoothError> {
    let (smooth, facts) = smooth(grid)?;
    let raw = std::mem::replace(&mut grid.distribution, smooth);
    grid.smoothed = Some((raw, facts));
    Ok(())
}

/// The smoothest distribution that the readings of `grid` allow.
///
/// # Errors
/// [`SmoothError`]: the raw distribution stands.
fn smooth(grid: &Grid) -> Result<(IntensityDistribution, Smoothing), SmoothError> {
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

#[cfg(test)]
mod tests;
