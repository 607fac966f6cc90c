//! What is lost between the directions that were measured: estimated by leaving some of them out.
//!
//! Linear interpolation of a smooth distribution is wrong by K·h² to first order, h the step. With every second γ left
//! out the step is 2·h and the error four times as large, so that a third of the change is the error of the whole grid
//! (Richardson). Both ways of leaving out (the even places, the odd ones) are tried, with the ends kept, and the larger
//! change counts, since one of them may vanish by chance. Half-planes are treated in the same way. At a single point
//! close to a direction of the grid the error falls with h alone, and the whole change counts.
//!
//! None of this sees light that no direction hits. So a distribution whose lobes are narrower than three directions, or
//! whose half-planes are more than 45° apart, is not resolved, and its uncertainty is missing instead.

use isolux_photometry::IntensityDistribution;

use crate::error::ReduceError;
use crate::grid::is_pole;

/// Least directions of a lobe within half of its largest intensity.
const LOBE_NODES: usize = 3;

/// A lobe below this share of the largest intensity does not count.
const LOBE_SHARE: f64 = 0.1;

/// Half-planes further apart than this do not show how the light varies over C: 90° would miss a square luminaire.
const WIDEST_C_DEG: f64 = 45.0;

/// Why a distribution is not resolved along γ.
pub const COARSE_GAMMA: &str = "the steps of γ are too coarse for the shape of the light";

/// How the error of a linear functional of the intensities follows from the change when the step is doubled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// An integral over many steps: a third of it.
    Integral,
    /// The intensity in a few directions: all of it.
    Local,
}

impl Kind {
    const fn share(self) -> f64 {
        match self {
            Self::Integral => 1.0 / 3.0,
            Self::Local => 1.0,
        }
    }
}

/// Standard uncertainty that the interpolation of `distribution` leaves in `functional` of it.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn u_of(
    distribution: &IntensityDistribution,
    kind: Kind,
    functional: impl Fn(&IntensityDistribution) -> f64,
) -> Result<f64, ReduceError> {
    let whole = functional(distribution);
    let largest = |thinned: Vec<IntensityDistribution>| {
        let changes = thinned.iter().map(|thin| (functional(thin) - whole).abs());
        changes.fold(0.0, f64::max)
    };
    let along_gamma = largest(without_every_second_gamma(distribution)?);
    let over_c = largest(without_every_second_plane(distribution)?);
    Ok(kind.share() * along_gamma.hypot(over_c))
}

/// By how much the intensity may rise between the directions around its largest value: the top of the parabola through
/// the three directions about it, of their values or of the logarithms, whichever is higher, along γ and over C. At
/// least δ/8/√12, δ being the second difference: a parabola whose top lies anywhere between two directions exceeds them
/// by up to δ/8.
pub fn above_the_largest_cd(distribution: &IntensityDistribution) -> f64 {
    let gammas = distribution.gamma_deg();
    let planes = distribution.c_deg().len();
    let place = (0..planes * gammas.len())
        .max_by(|&a, &b| distribution.intensity_cd()[a].total_cmp(&distribution.intensity_cd()[b]))
        .unwrap_or(0);
    let (plane, column) = (place / gammas.len(), place % gammas.len());
    let at = |plane: usize, column: usize| distribution.row(plane)[column];
    let mut excess2 = 0.0;
    // At a pole the meridian goes on in the opposite half-plane, along every meridian.
    let meridians = if is_pole(gammas[column]) {
        0..planes
    } else {
        plane..plane + 1
    };
    let mut along = 0.0_f64;
    for meridian in meridians {
        let opposite = distribution.c_deg()[meridian] + 180.0;
        let beyond = |column: usize| distribution.intensity_cd_at(opposite, gammas[column]);
        let below = match column.checked_sub(1) {
            Some(below) => Some(at(meridian, below)),
            None => (gammas[0] == 0.0).then(|| beyond(1)),
        };
        let above = match gammas.get(column + 1) {
            Some(_) => Some(at(meridian, column + 1)),
            None => (gammas[column] == 180.0).then(|| beyond(column - 1)),
        };
        if let (Some(below), Some(above)) = (below, above) {
            along = along.max(top(below, at(meridian, column), above));
        }
    }
    excess2 += along * along;
    if planes > 2 && !is_pole(gammas[column]) {
        let (before, behind) = ((plane + planes - 1) % planes, (plane + 1) % planes);
        excess2 += top(at(before, column), at(plane, column), at(behind, column)).powi(2);
    }
    excess2.sqrt()
}

/// What of the distribution the grid cannot show, one phrase each.
pub fn unresolved(distribution: &IntensityDistribution) -> Vec<String> {
    let gammas = distribution.gamma_deg();
    let largest = distribution.peak().intensity_cd;
    let planes: Vec<&[f64]> = (0..distribution.c_deg().len())
        .map(|plane| distribution.row(plane))
        .collect();
    let mut missing = Vec::new();
    let meridian = |plane: usize| -> Vec<f64> {
        let opposite = distribution.c_deg()[plane] + 180.0;
        let other = gammas.iter().rev().filter(|gamma| **gamma > 0.0);
        let mut profile: Vec<f64> = other
            .map(|&gamma| distribution.intensity_cd_at(opposite, gamma))
            .collect();
        profile.extend(planes[plane]);
        profile
    };
    let narrow_in_gamma = (0..planes.len()).any(|plane| !resolved(&meridian(plane), LOBE_SHARE * largest, false));
    if narrow_in_gamma || gammas.len() < LOBE_NODES {
        missing.push(COARSE_GAMMA.to_owned());
    }
    let narrow_in_c = || {
        (0..gammas.len())
            .filter(|&column| !is_pole(gammas[column]))
            .any(|column| {
                let ring: Vec<f64> = planes.iter().map(|plane| plane[column]).collect();
                let (low, high) = ring.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
                low < 0.5 * high && !resolved(&ring, LOBE_SHARE * largest, true)
            })
    };
    let widest = distribution.plane_widths_deg().into_iter().fold(0.0, f64::max);
    // One half-plane is a lamp that is assumed to be rotational, which is said elsewhere.
    if planes.len() > 1 && (widest > WIDEST_C_DEG || narrow_in_c()) {
        missing.push("the steps of C are too coarse for the shape of the light".to_owned());
    }
    missing
}

/// Height of the parabola's top over the middle of three values, and at least what the second difference leaves open.
fn top(below: f64, middle: f64, above: f64) -> f64 {
    let over = |below: f64, middle: f64, above: f64| {
        let second = 2.0 * middle - below - above;
        if second > 0.0 {
            (above - below).powi(2) / (8.0 * second)
        } else {
            0.0
        }
    };
    let of_values = over(below, middle, above);
    let of_logarithms = if below > 0.0 && above > 0.0 {
        middle * over(below.ln(), middle.ln(), above.ln()).exp_m1()
    } else {
        0.0
    };
    let open = (2.0 * middle - below - above).max(0.0) / 8.0 / 12.0_f64.sqrt();
    of_values.max(of_logarithms).max(open)
}

/// Whether every lobe of `values` above `threshold` has enough directions within half of its largest value.
fn resolved(values: &[f64], threshold: f64, round: bool) -> bool {
    let count = values.len();
    // The value `by` places away, in a ring or in a row; beyond the ends of a row nothing is known, and nothing is held
    // against it.
    let at = |place: usize, by: isize| -> Option<f64> {
        let there = place as isize + by;
        if round {
            values.get(there.rem_euclid(count as isize) as usize).copied()
        } else {
            usize::try_from(there).ok().and_then(|there| values.get(there)).copied()
        }
    };
    (0..count).all(|place| {
        let value = values[place];
        let lower = |by| at(place, by).is_none_or(|other| other <= value);
        if value < threshold || !(lower(-1) && lower(1)) {
            return true;
        }
        let reach = |sign: isize| {
            (1..LOBE_NODES as isize)
                .take_while(|by| at(place, sign * by).is_none_or(|other| other >= 0.5 * value))
                .count()
        };
        reach(-1) + 1 + reach(1) >= LOBE_NODES
    })
}

/// The distribution with every second γ left out, both ways; the first and the last stay.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn without_every_second_gamma(
    distribution: &IntensityDistribution,
) -> Result<Vec<IntensityDistribution>, ReduceError> {
    let gammas = distribution.gamma_deg();
    let last = gammas.len() - 1;
    let ways = [0, 1].map(|parity| -> Vec<usize> {
        (0..gammas.len())
            .filter(|&column| column == 0 || column == last || column % 2 == parity)
            .collect()
    });
    let mut thinned = Vec::new();
    for kept in ways
        .into_iter()
        .filter(|kept| kept.len() >= 2 && kept.len() < gammas.len())
    {
        let intensity = (0..distribution.c_deg().len())
            .flat_map(|plane| kept.iter().map(move |&column| distribution.row(plane)[column]))
            .collect();
        let gamma_deg = kept.iter().map(|&column| gammas[column]).collect();
        thinned.push(IntensityDistribution::new(
            distribution.c_deg().to_vec(),
            gamma_deg,
            intensity,
        )?);
    }
    Ok(thinned)
}

/// The distribution with every second half-plane left out, both ways.
fn without_every_second_plane(distribution: &IntensityDistribution) -> Result<Vec<IntensityDistribution>, ReduceError> {
    let planes = distribution.c_deg();
    if planes.len() < 3 {
        return Ok(Vec::new());
    }
    let mut thinned = Vec::new();
    for parity in [0, 1] {
        let kept = || (0..planes.len()).filter(move |plane| plane % 2 == parity);
        let c_deg = kept().map(|plane| planes[plane]).collect();
        let intensity = kept()
            .flat_map(|plane| distribution.row(plane).iter().copied())
            .collect();
        thinned.push(IntensityDistribution::new(
            c_deg,
            distribution.gamma_deg().to_vec(),
            intensity,
        )?);
    }
    Ok(thinned)
}

#[cfg(test)]
mod tests;
