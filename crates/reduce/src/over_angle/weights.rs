//! What each measured spectrum stands for: the lumens of the lux meter's distribution about its direction, and its
//! weight in the average of LM-79.

use std::f64::consts::TAU;

use isolux_model::gauss_legendre;
use isolux_photometry::{HalfPlanes, IntensityDistribution};

/// Cells of the distribution wider than this over C are cut, in degrees: the harmonics of a few half-planes bend in
/// them.
const WIDEST_DEG: f64 = 15.0;

/// Lumens by direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Lumens {
    /// Φ_d = ∫ I(C, γ)·w_d(C, γ) dΩ, with the weight of the direction in the mixture there.
    pub of: Vec<f64>,
    /// The part of them beyond the last spectrum of the nearest half-plane, where it is held.
    pub held: Vec<f64>,
}

impl Lumens {
    /// Of `count` directions on `half_planes`, of a lamp that stands at γ + `shift_deg` where γ is read; `added_cd`
    /// is added to every intensity.
    pub fn of(
        distribution: &IntensityDistribution,
        half_planes: &HalfPlanes,
        count: usize,
        shift_deg: f64,
        added_cd: f64,
    ) -> Self {
        let mut lumens = Self {
            of: vec![0.0; count],
            held: vec![0.0; count],
        };
        let gammas = distribution.gamma_deg();
        let rule = gauss_legendre(3);
        for [from_c, to_c] in cells(distribution.c_deg()) {
            for pair in gammas.windows(2) {
                let (half_c, half_gamma) = (0.5 * (to_c - from_c), 0.5 * (pair[1] - pair[0]));
                for (x, over_c) in &rule {
                    for (y, over_gamma) in &rule {
                        let (c_deg, gamma_deg) = (from_c + half_c * (1.0 + x), pair[0] + half_gamma * (1.0 + y));
                        let solid = over_c * over_gamma * half_c * half_gamma * (TAU / 360.0).powi(2);
                        let sine = (gamma_deg + shift_deg).to_radians().sin().max(0.0);
                        let intensity_cd = distribution.intensity_cd_at(c_deg, gamma_deg) + added_cd;
                        let share = solid * sine * intensity_cd;
                        let held = !half_planes.holds(c_deg, gamma_deg);
                        half_planes.each_weight(c_deg, gamma_deg, |index, weight| {
                            lumens.of[index] += weight * share;
                            if held {
                                lumens.held[index] += weight * share;
                            }
                        });
                    }
                }
            }
        }
        lumens
    }
}

/// Pieces of the circle from one half-plane to the next, none wide.
fn cells(c_deg: &[f64]) -> Vec<[f64; 2]> {
    let turn = c_deg[0] + 360.0;
    let ends = c_deg[1..].iter().chain(std::iter::once(&turn));
    let pieces = c_deg.iter().zip(ends).flat_map(|(from, to)| {
        let count = ((to - from) / WIDEST_DEG).ceil().max(1.0);
        let step = (to - from) / count;
        (0..count as usize).map(move |k| [from + step * k as f64, from + step * (k + 1) as f64])
    });
    pieces.collect()
}

/// Weights I·Ω of IES LM-79-08, 12, for each direction, which add up to 1: a ring of γ has Ω =
/// 2π[cos(γ − Δ/2) − cos(γ + Δ/2)], half a ring at a pole, shared by the half-planes as they share the circle.
/// `planned` are all directions of the plan on half-planes, `intensity_cd` the intensity of each by its number; none:
/// it is left out, and takes part in no ring. `shift_deg` as in [`Lumens::of`].
pub fn lm79(planned: &HalfPlanes, intensity_cd: &[Option<f64>], shift_deg: f64) -> Vec<f64> {
    let mut weights = vec![0.0; intensity_cd.len()];
    let c_deg: Vec<f64> = planned.planes().map(|(c_deg, _)| c_deg).collect();
    for (plane, (_, nodes)) in planned.planes().enumerate() {
        let share = width_deg(&c_deg, plane) / 360.0;
        for (place, (gamma_deg, index)) in nodes.iter().enumerate() {
            let Some(intensity_cd) = intensity_cd[*index] else {
                continue;
            };
            let below = place.checked_sub(1).map(|below| gamma_deg - nodes[below].0);
            let above = nodes.get(place + 1).map(|(above, _)| above - gamma_deg);
            let half = |own: Option<f64>, other: Option<f64>| 0.5 * own.or(other).unwrap_or(180.0);
            let edge = |deg: f64| (deg.clamp(0.0, 180.0) + shift_deg).clamp(0.0, 180.0).to_radians().cos();
            let (low, high) = (gamma_deg - half(below, above), gamma_deg + half(above, below));
            weights[*index] += share * TAU * (edge(low) - edge(high)) * intensity_cd.max(0.0);
        }
    }
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// Half the way to the neighbours on both sides.
fn width_deg(c_deg: &[f64], plane: usize) -> f64 {
    let count = c_deg.len();
    if count == 1 {
        return 360.0;
    }
    let gap = |from: usize, to: usize| (c_deg[to] - c_deg[from]).rem_euclid(360.0);
    0.5 * (gap((plane + count - 1) % count, plane) + gap(plane, (plane + 1) % count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn every_10(c_deg: &[f64]) -> Vec<(f64, f64)> {
        let rings = c_deg.iter().flat_map(|c| (1..=9).map(|k| (*c, 10.0 * f64::from(k))));
        std::iter::once((0.0, 0.0)).chain(rings).collect()
    }

    #[test]
    fn the_lumens_of_all_directions_are_the_flux_and_those_of_a_ring_have_a_closed_form() {
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let even = IntensityDistribution::new(vec![0.0], gamma.clone(), vec![100.0; 91]).unwrap();
        let directions = every_10(&[0.0, 90.0, 180.0, 270.0]);
        let planes = HalfPlanes::new(&directions).unwrap();
        let lumens = Lumens::of(&even, &planes, directions.len(), 0.0, 0.0);
        let sum: f64 = lumens.of.iter().sum();
        assert!((sum / (200.0 * PI) - 1.0).abs() < 1e-9, "{sum}");
        assert!(lumens.held.iter().all(|held| *held == 0.0));
        // A hat of ±h about γ: ∫ hat·sin γ dγ = 2·sin γ·(1 − cos h)/h; a quarter of the circle each.
        let h = 10f64.to_radians();
        for (of, (_, gamma)) in lumens
            .of
            .iter()
            .zip(&directions)
            .filter(|(_, (_, gamma))| (10.0..90.0).contains(gamma))
        {
            let exact = 100.0 * 0.25 * TAU * 2.0 * gamma.to_radians().sin() * (1.0 - h.cos()) / h;
            assert!((of / exact - 1.0).abs() < 1e-9, "{gamma}: {of} {exact}");
        }
        // Beyond the last spectrum it is held.
        let half = HalfPlanes::new(&directions[..6]).unwrap();
        let short = Lumens::of(&even, &half, 6, 0.0, 0.0);
        let beyond = short.held.iter().sum::<f64>();
        assert!(
            (beyond / (200.0 * PI * 50f64.to_radians().cos()) - 1.0).abs() < 1e-6,
            "{beyond}"
        );
    }

    #[test]
    fn rings_of_lm_79_share_the_sphere() {
        let directions = every_10(&[0.0, 90.0, 180.0, 270.0]);
        let planes = HalfPlanes::new(&directions).unwrap();
        let weights = lm79(&planes, &vec![Some(5.0); directions.len()], 0.0);
        let whole = 1.0 - 95f64.to_radians().cos();
        assert!((weights[0] - (1.0 - 5f64.to_radians().cos()) / whole).abs() < 1e-12);
        let ring = (25f64.to_radians().cos() - 35f64.to_radians().cos()) / whole / 4.0;
        for (weight, (_, gamma)) in weights.iter().zip(&directions).filter(|(_, (_, gamma))| *gamma == 30.0) {
            assert!((weight - ring).abs() < 1e-12, "{gamma}");
        }
        // What is left out takes no ring, and its neighbours no more than theirs.
        let without: Vec<Option<f64>> = directions
            .iter()
            .map(|(_, gamma)| (*gamma != 40.0).then_some(5.0))
            .collect();
        let fewer = lm79(&planes, &without, 0.0);
        assert!((fewer[0] / fewer[3] - weights[0] / weights[3]).abs() < 1e-12);
        // Two halves of unequal width: 0° and 180° have a quarter of the circle more than 90° alone.
        let three = HalfPlanes::new(&[(0.0, 60.0), (90.0, 60.0), (180.0, 60.0), (300.0, 60.0)]).unwrap();
        let weights = lm79(&three, &[Some(1.0); 4], 0.0);
        assert!(
            (weights[1] - 90.0 / 360.0).abs() < 1e-12 && (weights[3] - 90.0 / 360.0).abs() < 1e-12,
            "{weights:?}"
        );
        assert!((weights[2] - 105.0 / 360.0).abs() < 1e-12);
    }
}
