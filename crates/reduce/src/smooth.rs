//! Readings as intervals, and the smooth distribution that they allow.
//!
//! A display that rounds gives an interval of light, not a value, and its roundings differ from direction to direction
//! as the light does not. Along one line of directions, what is sought is the x that makes
//!
//! Σ (D x)²/v + Σ ((x − y)/s)² least, with |x − y| ≤ w at every direction:
//!
//! y is the raw intensity and s its standard uncertainty from rounding and scatter; w is half a digit and twice the
//! scatter; D are third differences, and v is the variance that the light itself has there: the squares of the raw
//! differences around a direction, less what rounding and scatter alone give. A cut-off or a narrow beam has large
//! differences, and the sum leaves it as it was read; where the readings differ by no more than they are rounded, it
//! follows a smooth curve through their intervals. Without the second term, the smoothest distribution inside the
//! intervals lies on their ends and flattens every maximum by half a digit. A negative intensity is as good as another.
//!
//! The mean of all half-planes is known better than each of them, and what a lamp has along γ it mostly has in all of
//! them. So the sum is taken of the mean over the half-planes, with the s and v of that mean, and of what each
//! half-plane differs from it, with its own. Taken of each half-plane by itself, the sum bends a curvature that all
//! half-planes have by as much as one of them is uncertain, which is more than their mean is.
//!
//! Around a circle the lowest orders of what the half-planes differ stay as they were read: their differences between
//! neighbours are smaller than noise gives them, and smoothing would bend them by more than they are uncertain, while
//! they hold little of the noise.
//!
//! Half-planes that were read in motion are curves along γ already, and what such a curve leaves open is no scatter:
//! they are smoothed around circles alone, within their noise. Taken for scatter it bends neighbouring half-planes
//! towards each other by as much.
//!
//! What the half-planes differ is smoothed along every meridian and then around every circle of equal γ: the product of
//! the two smoothings in place of the one that has both sums at once (L. Xiao, Y. Li, D. Ruppert, J. R. Stat. Soc. B
//! 75, 577, 2013). Each line is then a system of its own with a narrow band, and the time grows with the number of
//! directions; `docs/decisions/0026-smoothing-by-lines.md` has what the product costs in accuracy. The bounds w are
//! applied to the sum of all, at the end.

mod circle;
mod differences;
mod light;
mod line;
mod nodes;

use isolux_photometry::IntensityDistribution;

use crate::grid::{Grid, Smoothing};
use circle::CircleDifferences;
use differences::{Meridians, Term};
use light::{Difference, variances};
use line::Line;
use nodes::Nodes;

/// Standard deviations of the mean of so few squares that are added to the variance of the light in the mean of all
/// half-planes and around a circle, each of which is smoothed without its neighbours: where that variance came out too
/// small by chance, a curve that the light has would be bent straight. With 0 around the circles, what the half-planes
/// of ring illuminators differ is wrong by up to twice as much.
const DOUBT: f64 = 2.0;

/// Why a distribution stays raw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the uncertainties of the readings are beyond the range of numbers: the distribution is the raw one")]
pub struct SmoothError;

/// Replaces the distribution of `grid` by the smooth one that its readings allow, and keeps the raw one beside it.
///
/// # Errors
/// [`SmoothError`]; the distribution is as it was then.
pub fn apply(grid: &mut Grid) -> Result<(), SmoothError> {
    let (smooth, facts) = smooth(grid)?;
    let raw = std::mem::replace(&mut grid.distribution, smooth);
    grid.smoothed = Some((raw, facts));
    Ok(())
}

/// The smooth distribution that the readings of `grid` allow.
///
/// # Errors
/// [`SmoothError`]: the raw distribution stands.
fn smooth(grid: &Grid) -> Result<(IntensityDistribution, Smoothing), SmoothError> {
    let nodes = Nodes::of(grid);
    let raw = &grid.distribution;
    let meridians = Meridians::of(raw.c_deg(), raw.gamma_deg());
    // The curve of a sweep is smooth along γ as far as its readings say.
    let along = !grid.nodes.iter().any(|sample| sample.u_curve_cd.is_some());
    let meridians = along.then_some(&meridians);
    let (of_means, shares) = match meridians {
        Some(meridians) => means(&nodes, meridians).ok_or(SmoothError)?,
        None => (vec![0.0; nodes.gammas], vec![1.0; nodes.gammas]),
    };
    let (of_places, mut own_share) = deviations(&nodes, meridians, raw.c_deg()).ok_or(SmoothError)?;
    let mut mean = MeanShare::default();
    for (share, ring) in shares.iter().zip(&nodes.rings) {
        mean.add(*share, ring.mean_cd);
    }
    if nodes.planes == 1 {
        own_share[0] = mean.value();
    }
    let mut facts = Smoothing {
        rms_cd: 0.0,
        max_cd: 0.0,
        max_of_half_width: 0.0,
        own_share,
        mean_share: mean.value(),
    };
    let mut smoothed = nodes.raw_cd.clone();
    for (place, (value, change)) in smoothed.iter_mut().zip(&of_places).enumerate() {
        let half_cd = nodes.half_cd[place];
        let change = (change + of_means[place % nodes.gammas]).clamp(-half_cd, half_cd);
        *value += change;
        facts.rms_cd += change * change / of_places.len() as f64;
        facts.max_cd = facts.max_cd.max(change.abs());
        if half_cd > 0.0 {
            facts.max_of_half_width = facts.max_of_half_width.max(change.abs() / half_cd);
        }
    }
    facts.rms_cd = facts.rms_cd.sqrt();
    let distribution = IntensityDistribution::new(raw.c_deg().to_vec(), raw.gamma_deg().to_vec(), smoothed)
        .map_err(|_| SmoothError)?;
    Ok((distribution, facts))
}

/// By how much the mean of all half-planes changes at every γ, and the share that it has in itself.
fn means(nodes: &Nodes, meridians: &Meridians) -> Option<(Vec<f64>, Vec<f64>)> {
    let rings = &nodes.rings;
    let mut differences = vec![Difference::default(); nodes.gammas];
    for window in meridians.of_all() {
        let mut weights: Vec<(usize, f64)> = Vec::with_capacity(4);
        for term in window.terms {
            // Across a pole one γ stands on both sides.
            match weights.iter_mut().find(|(ig, _)| *ig == term.ig) {
                Some((_, weight)) => *weight += term.weight,
                None => weights.push((term.ig, term.weight)),
            }
        }
        differences[window.ig] = Difference {
            value: weights.iter().map(|(ig, weight)| weight * rings[*ig].mean_cd).sum(),
            noise2: weights
                .iter()
                .map(|(ig, weight)| (weight * rings[*ig].u_mean_cd).powi(2))
                .sum(),
        };
    }
    let variances = variances(&differences, nodes.gammas, DOUBT);
    let mut line = Line::new(rings.iter().map(|ring| ring.u_mean_cd).collect());
    for window in meridians.of_all().filter(|window| variances[window.ig] > 0.0) {
        let terms = window.terms.map(|term| (term.ig, term.weight));
        line.add(terms, differences[window.ig].value, variances[window.ig]);
    }
    line.solve()
}

/// By how much what each half-plane differs from the mean changes at every place, and the mean share of a place's own
/// reading along the meridians, which are left as they are where none are given, and around the circles.
fn deviations(nodes: &Nodes, meridians: Option<&Meridians>, c_deg: &[f64]) -> Option<(Vec<f64>, [f64; 2])> {
    let mut change = vec![0.0; nodes.raw_cd.len()];
    let mut own = [1.0; 2];
    if nodes.planes > 1 {
        let read = nodes.deviations_cd();
        let mut smooth = read.clone();
        if let Some(meridians) = meridians {
            own[0] = along_meridians(nodes, meridians, &mut smooth)?;
        }
        if let Some(circle) = CircleDifferences::of(c_deg) {
            own[1] = around_circles(nodes, &circle, &read, &mut smooth)?;
        }
        // Where one half-plane is less certain than another the mean moves too, which was smoothed already.
        for (change, (smooth, read)) in change.iter_mut().zip(smooth.iter().zip(&read)) {
            *change = smooth - read;
        }
        nodes.centre(&mut change);
    }
    Some((change, own))
}

/// The mean of shares, weighted by the light at their places.
#[derive(Default)]
struct MeanShare {
    sum: f64,
    weights: f64,
}

impl MeanShare {
    fn add(&mut self, share: f64, intensity_cd: f64) {
        self.sum += share * intensity_cd.abs();
        self.weights += intensity_cd.abs();
    }

    fn value(&self) -> f64 {
        if self.weights > 0.0 {
            self.sum / self.weights
        } else {
            1.0
        }
    }
}

/// Smooths the deviations along every meridian, on both sides of the poles at once where both were measured. The mean
/// share of a place in itself.
fn along_meridians(nodes: &Nodes, meridians: &Meridians, deviation_cd: &mut [f64]) -> Option<f64> {
    let mut mean = MeanShare::default();
    let gammas = nodes.gammas;
    let share = 1.0 / nodes.planes as f64;
    let place = |ic: usize, term: Term| -> Option<usize> {
        let plane = if term.across { meridians.opposite[ic]? } else { ic };
        Some(plane * gammas + term.ig)
    };
    let mut differences = vec![Difference::default(); deviation_cd.len()];
    for ic in 0..nodes.planes {
        for window in &meridians.windows {
            let mut difference = Difference::default();
            let mut whole = true;
            for term in window.terms {
                let ring = &nodes.rings[term.ig];
                match place(ic, term) {
                    Some(_) if ring.pole => {}
                    Some(place) => {
                        difference.value += term.weight * deviation_cd[place];
                        // The mean that is subtracted has a share of it.
                        let variance_cd2 = nodes.u_cd[place].powi(2);
                        let less_mean = variance_cd2 * (1.0 - 2.0 * share) + ring.variance_cd2 * share;
                        difference.noise2 += term.weight.powi(2) * less_mean;
                    }
                    None => whole = false,
                }
            }
            if whole {
                differences[ic * gammas + window.ig] = difference;
            }
        }
    }
    let variances = variances(&differences, gammas, 0.0);
    for first in 0..nodes.planes {
        let sides: Vec<usize> = match meridians.opposite[first] {
            Some(second) if second < first => continue,
            Some(second) => vec![first, second],
            None => vec![first],
        };
        // The two sides in turn: neighbours across a pole are close too.
        let node = |side: usize, ig: usize| ig * sides.len() + side;
        let places: Vec<usize> = (0..gammas)
            .flat_map(|ig| sides.iter().map(move |ic| ic * gammas + ig))
            .collect();
        let u_cd = |place: &usize| {
            if nodes.rings[place % gammas].pole {
                0.0
            } else {
                nodes.u_cd[*place]
            }
        };
        let mut line = Line::new(places.iter().map(u_cd).collect());
        for (side, ic) in sides.iter().enumerate() {
            for window in &meridians.windows {
                let at = ic * gammas + window.ig;
                if variances[at] > 0.0 {
                    let terms = window.terms.map(|term| {
                        let side = if term.across { 1 - side } else { side };
                        (node(side, term.ig), term.weight)
                    });
                    line.add(terms, differences[at].value, variances[at]);
                }
            }
        }
        let (changes, shares) = line.solve()?;
        for (place, (change, share)) in places.into_iter().zip(changes.into_iter().zip(shares)) {
            deviation_cd[place] += change;
            mean.add(share, nodes.raw_cd[place]);
        }
    }
    Some(mean.value())
}

/// Smooths the deviations around every circle of equal γ but for their lowest orders; the variance of the light is that
/// of what was read. The mean share of a place in itself.
fn around_circles(nodes: &Nodes, circle: &CircleDifferences, read_cd: &[f64], deviation_cd: &mut [f64]) -> Option<f64> {
    let (planes, gammas) = (nodes.planes, nodes.gammas);
    let place = |ic: usize, ig: usize| ic % planes * gammas + ig;
    let rings = || (0..gammas).filter(|ig| !nodes.rings[*ig].pole);
    let of = |values: &[f64], ig: usize| -> Vec<f64> { (0..planes).map(|ic| values[place(ic, ig)]).collect() };
    let mut differences = vec![Difference::default(); deviation_cd.len()];
    for ig in rings() {
        let fine = circle.without_kept(of(read_cd, ig));
        for (ic, weights) in circle.differences.iter().enumerate() {
            let difference = &mut differences[place(ic + 1, ig)];
            for (k, weight) in weights.iter().enumerate() {
                difference.value += weight * fine[(ic + k) % planes];
                difference.noise2 += (weight * nodes.u_cd[place(ic + k, ig)]).powi(2);
            }
        }
    }
    let variances = variances(&differences, gammas, DOUBT);
    // Half-planes on both sides of C 0° in turn: the circle is a line whose two halves are neighbours at both ends.
    let node = |ic: usize| {
        let ic = ic % planes;
        if 2 * ic < planes {
            2 * ic
        } else {
            2 * (planes - 1 - ic) + 1
        }
    };
    let mut mean = MeanShare::default();
    for ig in rings() {
        let fine = circle.without_kept(of(deviation_cd, ig));
        let mut u_cd = vec![0.0; planes];
        (0..planes).for_each(|ic| u_cd[node(ic)] = nodes.u_cd[place(ic, ig)]);
        let mut line = Line::new(u_cd);
        for (ic, weights) in circle.differences.iter().enumerate() {
            let variance = variances[place(ic + 1, ig)];
            if variance > 0.0 {
                let terms = [0, 1, 2, 3].map(|k| (node(ic + k), weights[k]));
                let value = (0..4).map(|k| weights[k] * fine[(ic + k) % planes]).sum();
                line.add(terms, value, variance);
            }
        }
        let (change, shares) = line.solve()?;
        let kept = circle.kept_share();
        for ic in 0..planes {
            let at = place(ic, ig);
            deviation_cd[at] += change[node(ic)];
            mean.add(kept + (1.0 - kept) * shares[node(ic)], nodes.raw_cd[at]);
        }
    }
    Some(mean.value())
}

#[cfg(test)]
mod tests;
