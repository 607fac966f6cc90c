//! Beam and field angle, with uncertainty.
//!
//! An edge is where the intensity is a share s of the largest of its plane: it moves by (s·δI_max − δI_edge)/(dI/dγ).
//! That is linear in the intensities, so their budget is the edge's. What all readings share as a factor (calibration,
//! distance, drift) moves no edge.

use isolux_photometry::{Divergence, IntensityDistribution};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::budget::{self, Common};
use crate::grid::{Grid, folded};
use crate::interpolation;
use crate::near_field;
use crate::quantity::Quantity;

/// The planes whose angles are stated: through C0 and C90.
const PLANES_DEG: [f64; 2] = [0.0, 90.0];
/// Beam and field angle: where the intensity falls to these shares of the largest (CIE S 017, 17-27-097).
const SHARES: [f64; 2] = [0.5, 0.1];
/// Either side of an edge, for the slope there.
const BESIDE_DEG: f64 = 1e-3;

/// The angles of one plane; none where the intensity does not fall so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeamAngles {
    /// The plane goes through this half-plane and its opposite.
    pub c_deg: f64,
    /// Full angle between the edges at 50 % of the largest intensity.
    pub beam: Option<Quantity>,
    /// At 10 %.
    pub field: Option<Quantity>,
}

impl BeamAngles {
    /// The plane by both of its half-planes, as `C0–C180`.
    pub fn name(&self) -> String {
        format!("C{}–C{}", self.c_deg, self.c_deg + 180.0)
    }
}

/// Angles of the planes of [`PLANES_DEG`] that `grid` has. `near_rel` is the largest relative error of an intensity by
/// the limited distance; `missing` is what no intensity knows.
pub fn of(grid: &Grid, common: &Common, near_rel: f64, missing: &[String]) -> Vec<BeamAngles> {
    let planes = PLANES_DEG
        .iter()
        .filter_map(|&c_deg| Some((c_deg, grid.distribution.plane_at(c_deg)?)));
    let angles = planes.map(|(c_deg, plane)| {
        let [beam, field] = SHARES.map(|share| {
            let found = grid.distribution.divergence(plane, share)?;
            Some(angle(grid, common, (plane, share), &found, near_rel, missing))
        });
        BeamAngles { c_deg, beam, field }
    });
    angles.collect()
}

fn angle(
    grid: &Grid,
    common: &Common,
    (plane, share): (usize, f64),
    found: &Divergence,
    near_rel: f64,
    missing: &[String],
) -> Quantity {
    let distribution = &grid.distribution;
    let c_deg = distribution.c_deg()[plane];
    let at = |gamma_deg: f64| {
        let (c, gamma) = folded(c_deg, gamma_deg);
        distribution.intensity_cd_at(c, gamma)
    };
    let node_weights = |gamma_deg: f64| {
        let (c, gamma) = folded(c_deg, gamma_deg);
        grid.direction_weights(c.rem_euclid(360.0), gamma)
    };
    // By how much the angle grows with the level, and falls with the intensity at the edge.
    let mut deg_per_cd = 0.0;
    let mut weights = vec![0.0; grid.sample_of.len()];
    for (edge_deg, side) in [(found.to_deg, 1.0), (found.from_deg, -1.0)] {
        let slope = (at(edge_deg + BESIDE_DEG) - at(edge_deg - BESIDE_DEG)) / (2.0 * BESIDE_DEG);
        let of_edge = side / slope;
        deg_per_cd += of_edge;
        add(&mut weights, &node_weights(edge_deg), -of_edge);
    }
    add(&mut weights, &node_weights(found.top_deg), share * deg_per_cd);
    let mut parts = budget::weighted_sum(grid, &weights, common, "°").parts;
    // What is a factor of every intensity moves no angle.
    for factor in ["calibration", "distance", "drift"].iter().chain(&budget::OF_METER) {
        parts.remove(*factor);
    }
    let level_cd = share * at(found.top_deg);
    parts.insert(
        "near_field".into(),
        near_field::standard(near_rel) * level_cd * deg_per_cd,
    );

    let angle_deg = found.full_angle_deg();
    let change = |thin: &IntensityDistribution| {
        let thinned_deg = thin.divergence(plane, share)?.full_angle_deg();
        Some((thinned_deg - angle_deg).abs())
    };
    let thinned = interpolation::without_every_second_gamma(distribution).unwrap_or_default();
    let changes: Option<Vec<f64>> = thinned.iter().map(change).collect();
    let too_coarse = changes.is_none().then(|| interpolation::COARSE_GAMMA.to_owned());
    parts.insert(
        "interpolation".into(),
        changes.into_iter().flatten().fold(0.0, f64::max),
    );
    Quantity::new(angle_deg, "°", parts).lacking(missing.iter().cloned().chain(too_coarse))
}

fn add(sum: &mut [f64], weights: &[f64], factor: f64) {
    let pairs = sum.iter_mut().zip(weights);
    pairs.for_each(|(sum, weight)| *sum += factor * weight);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Sample;
    use crate::testing::{Random, sample};

    const U_CD: f64 = 0.4;

    /// I = 300·cosⁿ γ cd in 24 half-planes by 2°, to which `further` adds; every reading has [`U_CD`] of noise.
    fn grid(n: i32, mut further: impl FnMut() -> f64) -> Grid {
        let nodes: Vec<Sample> = (0..24 * 46)
            .map(|place| {
                let (c_deg, gamma_deg) = (15.0 * (place / 46) as f64, 2.0 * (place % 46) as f64);
                let cd = 300.0 * gamma_deg.to_radians().cos().powi(n) + further();
                Sample {
                    u_noise_cd: U_CD,
                    ..sample(c_deg, gamma_deg, cd)
                }
            })
            .collect();
        Grid::new(&nodes).unwrap()
    }

    fn angles(grid: &Grid, common: &Common) -> Vec<[Quantity; 2]> {
        let found = of(grid, common, 0.01, &[]).into_iter();
        found.map(|plane| [plane.beam.unwrap(), plane.field.unwrap()]).collect()
    }

    #[test]
    fn noise_moves_an_angle_as_its_budget_says() {
        let whole = angles(&grid(5, || 0.0), &Common::default());
        let days = 400;
        let mut squares = [0.0; 4];
        let mut random = Random(7);
        for _ in 0..days {
            let noisy = grid(5, || U_CD * random.normal());
            let noisy = angles(&noisy, &Common::default());
            for (sum, (noisy, whole)) in squares
                .iter_mut()
                .zip(noisy.iter().flatten().zip(whole.iter().flatten()))
            {
                *sum += (noisy.value - whole.value).powi(2);
            }
        }
        for (sum, whole) in squares.iter().zip(whole.iter().flatten()) {
            let scatter = (sum / f64::from(days)).sqrt();
            assert!(
                (scatter / whole.parts["noise"] - 1.0).abs() < 0.15,
                "{scatter} {whole:?}"
            );
        }
    }

    #[test]
    fn both_edges_move_with_gamma_and_with_stray_light() {
        let common = Common {
            gamma_deg: 0.05,
            stray_cd: 0.2,
            calibration_rel: 0.01,
            distance_rel: 0.01,
            drift_rel: 0.01,
            ..Common::default()
        };
        let stray = angles(&grid(5, || 0.2), &Common::default());
        for (stated, stray) in angles(&grid(5, || 0.0), &common)
            .iter()
            .flatten()
            .zip(stray.iter().flatten())
        {
            assert!((stated.parts["angle"] - 0.1).abs() < 0.001, "{stated:?}");
            let moved = stray.value - stated.value;
            assert!((stated.parts["stray"] / moved - 1.0).abs() < 0.05, "{stated:?} {moved}");
            assert!(!stated.parts.contains_key("calibration"));
        }
        // Full angles of cos⁵: 2·arccos 0.5^(1/5), 2·arccos 0.1^(1/5).
        for plane in angles(&grid(5, || 0.0), &common) {
            for (angle, share) in plane.iter().zip(SHARES) {
                let exact = 2.0 * share.powf(0.2).acos().to_degrees();
                assert!(
                    (angle.value - exact).abs() < angle.parts["interpolation"],
                    "{angle:?} {exact}"
                );
                assert!(angle.parts["interpolation"] < 0.2, "{angle:?}");
            }
        }
    }

    #[test]
    fn what_intensities_lack_angles_lack() {
        let missing = ["not corrected for stray light".to_owned()];
        let found = of(&grid(5, || 0.0), &Common::default(), 0.0, &missing);
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].name(), "C90–C270");
        assert_eq!(found[1].beam.as_ref().unwrap().missing, missing);
        // A lamp that shines all around has no edge.
        let round = of(&grid(0, || 0.0), &Common::default(), 0.0, &missing);
        assert!(round.iter().all(|plane| plane.beam.is_none() && plane.field.is_none()));
    }
}
