//! What straight lines between the directions of a distribution miss, direction by direction.
//!
//! Photometric files are read with straight lines from one direction to the next. Over a step h such a line misses up
//! to f″·h²/8; f″ at a direction follows from what the line through its two neighbours misses of it (a·b·f″/2, a and
//! b the steps beside it). In a gap the larger f″ of its two ends counts, at a direction the worse of the gaps beside
//! it. Along γ and over C are added in squares. A kink is missed by no more than this too, for it bends the line
//! through the neighbours.

use isolux_photometry::IntensityDistribution;

use crate::grid::is_pole;

/// What straight lines miss within a step of each direction `[ic * ng + ig]`, cd.
pub fn straight_lines_miss_cd(distribution: &IntensityDistribution) -> Vec<f64> {
    let (planes, gammas) = (distribution.c_deg(), distribution.gamma_deg());
    let along_gamma: Vec<Vec<f64>> = (0..planes.len())
        .map(|plane| along_gamma(distribution, plane))
        .collect();
    let over_c: Vec<Vec<f64>> = (0..gammas.len())
        .map(|column| {
            // Half-way to a pole half of what is missed beside it counts.
            let (column, share) = match (is_pole(gammas[column]), column) {
                (true, 0) => (1, 0.5),
                (true, _) => (column - 1, 0.5),
                (false, _) => (column, 1.0),
            };
            let ring: Vec<f64> = (0..planes.len()).map(|plane| distribution.row(plane)[column]).collect();
            if planes.len() < 3 {
                return vec![0.0; planes.len()];
            }
            around(planes, &ring).into_iter().map(|missed| share * missed).collect()
        })
        .collect();
    let at = |plane: usize, column: usize| along_gamma[plane][column].hypot(over_c[column][plane]);
    (0..planes.len() * gammas.len())
        .map(|place| (place / gammas.len(), place % gammas.len()))
        .map(|(plane, column)| {
            // A pole is one direction of all half-planes.
            if is_pole(gammas[column]) {
                (0..planes.len()).map(|plane| at(plane, column)).fold(0.0, f64::max)
            } else {
                at(plane, column)
            }
        })
        .collect()
}

/// Along the meridian of a half-plane, which goes on in the opposite one at a pole.
fn along_gamma(distribution: &IntensityDistribution, plane: usize) -> Vec<f64> {
    let gammas = distribution.gamma_deg();
    let opposite = distribution.c_deg()[plane] + 180.0;
    let mut meridian: Vec<(f64, f64)> = gammas
        .iter()
        .copied()
        .zip(distribution.row(plane).iter().copied())
        .collect();
    let mut before = 0;
    if gammas.len() > 1 && gammas[0] == 0.0 {
        meridian.insert(0, (-gammas[1], distribution.intensity_cd_at(opposite, gammas[1])));
        before = 1;
    }
    if let [.., last, end] = gammas
        && *end == 180.0
    {
        meridian.push((360.0 - last, distribution.intensity_cd_at(opposite, *last)));
    }
    let bends: Vec<f64> = (0..meridian.len())
        .map(|k| match (k.checked_sub(1).map(|k| meridian[k]), meridian.get(k + 1)) {
            (Some(low), Some(high)) => bend(low, meridian[k], *high),
            _ => 0.0,
        })
        .collect();
    let gap = |k: usize| match (meridian.get(k), meridian.get(k + 1)) {
        (Some(from), Some(to)) => bends[k].max(bends[k + 1]) * (to.0 - from.0).powi(2) / 8.0,
        _ => 0.0,
    };
    (before..before + gammas.len())
        .map(|k| gap(k).max(k.checked_sub(1).map_or(0.0, gap)))
        .collect()
}

/// Around a circle of equal γ.
fn around(c_deg: &[f64], ring: &[f64]) -> Vec<f64> {
    let count = ring.len();
    let step = |k: usize| (c_deg[(k + 1) % count] - c_deg[k % count]).rem_euclid(360.0);
    let bends: Vec<f64> = (0..count)
        .map(|k| {
            let (before, behind) = ((k + count - 1) % count, (k + 1) % count);
            bend((-step(before), ring[before]), (0.0, ring[k]), (step(k), ring[behind]))
        })
        .collect();
    let gap = |k: usize| bends[k].max(bends[(k + 1) % count]) * step(k).powi(2) / 8.0;
    (0..count).map(|k| gap(k).max(gap((k + count - 1) % count))).collect()
}

/// |f″| at the middle one of three places by what the line through the outer two misses of it.
fn bend(low: (f64, f64), middle: (f64, f64), high: (f64, f64)) -> f64 {
    let (a, b) = (middle.0 - low.0, high.0 - middle.0);
    let line = low.1 + (high.1 - low.1) * a / (a + b);
    2.0 * (middle.1 - line).abs() / (a * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I = (2 + cos 2C·sin²γ)·cos²(γ/2) on steps of 15° and 5°.
    #[test]
    fn it_is_what_lines_miss_in_the_gaps_beside_a_direction() {
        let light = |c: f64, gamma: f64| {
            let (c, gamma) = (c.to_radians(), gamma.to_radians());
            1000.0 * (gamma / 2.0).cos().powi(2) * (2.0 + (2.0 * c).cos() * gamma.sin().powi(2))
        };
        let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k)).collect();
        let gamma_deg: Vec<f64> = (0..=36).map(|k| 5.0 * f64::from(k)).collect();
        let all = c_deg
            .iter()
            .flat_map(|c| gamma_deg.iter().map(|gamma| light(*c, *gamma)));
        let distribution = IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), all.collect()).unwrap();
        let missed = straight_lines_miss_cd(&distribution);
        let (mut of_them, mut sum) = (0, 0.0);
        for c in (0..144).map(|k| 2.5 * f64::from(k)) {
            for gamma in (0..=180).map(f64::from) {
                let error = (distribution.intensity_cd_at(c, gamma) - light(c, gamma)).abs();
                let plane = (c / 15.0).round() as usize % 24;
                let stated = missed[plane * 37 + (gamma / 5.0).round() as usize];
                // It is a standard uncertainty: both ways may err alike, and a bend may vanish at one direction alone.
                assert!(
                    error <= 2.0 * stated + 0.2,
                    "C {c}°, γ {gamma}°: {error} cd of {stated}"
                );
                sum += error / stated.max(1e-9);
                of_them += 1;
            }
        }
        // Nor is it more than what is needed: in the mean over a gap a line misses two thirds of its most.
        assert!(sum / f64::from(of_them) > 0.25, "{}", sum / f64::from(of_them));
    }
}
