//! Samples → one intensity distribution, with one value at the poles.

use isolux_photometry::{Circle, IntensityDistribution, Sector, Symmetry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::ReduceError;
use crate::samples::Sample;

/// Rounds of moving intensities from where they were read to the nodes of the grid. Displacements are small against the
/// grid, so that each round gains several digits.
const ROUNDS: usize = 6;

/// What smoothing did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Smoothing {
    /// Root mean square of (smoothed − raw), in candela.
    pub rms_cd: f64,
    /// Largest difference, in candela.
    pub max_cd: f64,
    /// Largest difference relative to half the width of its interval: at most 1.
    pub max_of_half_width: f64,
    /// The share that what a half-plane differs from the mean of all has in its smoothed value, along γ and around C;
    /// the mean over the directions, weighted by their intensity.
    pub own_share: [f64; 2],
    /// The same share of the mean of all half-planes along γ.
    pub mean_share: f64,
}

/// A distribution and the samples that stand at its nodes.
#[derive(Debug, Clone)]
pub struct Grid {
    /// The distribution: smoothed, where `smoothed` says so.
    pub distribution: IntensityDistribution,
    /// The distribution as it was read, and what smoothing changed, where it was smoothed.
    pub smoothed: Option<(IntensityDistribution, Smoothing)>,
    /// The samples, by half-plane and γ; at a pole all half-planes share their mean.
    pub nodes: Vec<Sample>,
    /// The sample of each node `[ic * ng + ig]` of the distribution: one for each, but for half-planes that are mirror
    /// images, and for a pole that was read in some half-planes alone.
    pub sample_of: Vec<usize>,
    /// Symmetry that was assumed, because the half-planes do not go round.
    pub assumed: Symmetry,
    /// Largest difference between half-planes at γ = 0 and γ = 180°, before they were made one value.
    pub pole_spread_cd: [f64; 2],
}

impl Grid {
    /// The grid of the samples that are not of the closing half-plane. Half-planes over a quarter or half of the circle
    /// are taken as those of a symmetric lamp.
    ///
    /// # Errors
    /// [`ReduceError::NoLight`] without two γ, [`ReduceError::NoGrid`] when half-planes have different γ,
    /// [`ReduceError::NotRound`] when a part of the circle is missing that no symmetry gives.
    pub fn new(samples: &[Sample]) -> Result<Self, ReduceError> {
        let nodes: Vec<Sample> = samples.iter().filter(|sample| !sample.closing).copied().collect();
        let planes: Vec<&[Sample]> = nodes.chunk_by(|a, b| a.c_deg == b.c_deg).collect();
        let gamma_deg = gammas(&planes)?;
        let measured: Vec<f64> = planes.iter().map(|plane| plane[0].c_deg).collect();
        let circle = Circle::of(&measured)?;
        let sample_of = samples_of(&nodes, &measured, &circle, &gamma_deg);
        // A single half-plane says the lamp is rotational whatever its C.
        let c_deg = match circle.planes.as_slice() {
            [_] => vec![0.0],
            planes => planes.iter().map(|(c_deg, _)| *c_deg).collect(),
        };
        let spread = |of_samples: &[f64]| -> Vec<f64> { sample_of.iter().map(|&sample| of_samples[sample]).collect() };
        let of = |intensity_cd: Vec<f64>| IntensityDistribution::new(c_deg.clone(), gamma_deg.clone(), intensity_cd);
        let read: Vec<f64> = nodes.iter().map(|sample| sample.intensity_cd).collect();
        let place_of = places_of(&sample_of, nodes.len());
        let mut moved = read.clone();
        for _ in 0..ROUNDS {
            // At a pole the half-plane of a direction is a matter of rounding, so what is compared there is the one
            // value.
            let distribution = of(one_at_poles(&spread(&moved), &gamma_deg))?;
            let mut changed = false;
            for (node, sample) in nodes.iter().enumerate() {
                let there = at_signed(&distribution, sample.true_c_deg, sample.true_gamma_deg);
                let next = read[node] - (there - distribution.intensity_cd()[place_of[node]]);
                changed |= next != moved[node];
                moved[node] = next;
            }
            if !changed {
                break;
            }
        }
        let pole_spread_cd = of(spread(&moved))?.pole_spread_cd();
        let distribution = of(one_at_poles(&spread(&moved), &gamma_deg))?;
        Ok(Self {
            distribution,
            smoothed: None,
            nodes,
            sample_of,
            assumed: circle.assumed,
            pole_spread_cd,
        })
    }

    /// The distribution as it was read, before smoothing.
    pub fn as_read(&self) -> &IntensityDistribution {
        self.smoothed.as_ref().map_or(&self.distribution, |(raw, _)| raw)
    }

    /// Weight of every node in the luminous flux, in sr: Φ = Σ w·I.
    pub fn flux_weights_sr(&self) -> Vec<f64> {
        self.shared_at_poles(self.distribution.flux_weights_sr())
    }

    /// Weight of every node in the luminous flux of a part of the sphere, in sr.
    pub fn sector_weights_sr(&self, sector: &Sector) -> Vec<f64> {
        self.shared_at_poles(self.distribution.sector_weights_sr(sector))
    }

    /// Weight of every node in the intensity towards one direction.
    pub fn direction_weights(&self, c_deg: f64, gamma_deg: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.sample_of.len()];
        self.add_direction(&mut weights, (c_deg, gamma_deg), 1.0);
        self.shared_at_poles(weights)
    }

    /// Adds `factor` times the weights of the nodes around the direction (C, γ), as if poles were many directions.
    fn add_direction(&self, weights: &mut [f64], (c_deg, gamma_deg): (f64, f64), factor: f64) {
        let (cs, gammas) = (self.distribution.c_deg(), self.distribution.gamma_deg());
        let above = gammas.partition_point(|at| *at < gamma_deg);
        let (low, high) = match (above.checked_sub(1), gammas.get(above)) {
            (_, Some(&at)) if at == gamma_deg => (above, above),
            (Some(low), Some(_)) => (low, above),
            _ => return,
        };
        let v = if low == high {
            0.0
        } else {
            (gamma_deg - gammas[low]) / (gammas[high] - gammas[low])
        };
        let next = cs.partition_point(|at| *at <= c_deg) % cs.len();
        let previous = (next + cs.len() - 1) % cs.len();
        let gap = (cs[next] - cs[previous]).rem_euclid(360.0);
        let u = if gap == 0.0 {
            0.0
        } else {
            (c_deg - cs[previous]).rem_euclid(360.0) / gap
        };
        for (plane, share_c) in [(previous, 1.0 - u), (next, u)] {
            weights[plane * gammas.len() + low] += factor * share_c * (1.0 - v);
            weights[plane * gammas.len() + high] += factor * share_c * v;
        }
    }

    /// Weight of every node in the mean of E = I·cos α/R² over a square sensor on the axis, in 1/m²: the same
    /// quadrature for all nodes.
    pub fn sensor_weights_per_m2(&self, side_mm: f64, distance_mm: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.sample_of.len()];
        for (c, gamma, factor) in sensor_points(side_mm, distance_mm) {
            self.add_direction(&mut weights, (c, gamma), factor);
        }
        self.shared_at_poles(weights)
    }

    /// Slope of the intensity over γ at every node, in candela per degree: that of the chord between its neighbours;
    /// zero at a pole, where all half-planes share one value.
    pub fn gamma_slopes_cd_per_deg(&self) -> Vec<f64> {
        let gammas = self.distribution.gamma_deg();
        let slope = |row: &[f64], column: usize| {
            if is_pole(gammas[column]) {
                return 0.0;
            }
            let (low, high) = (column.saturating_sub(1), (column + 1).min(gammas.len() - 1));
            (row[high] - row[low]) / (gammas[high] - gammas[low])
        };
        let rows = self.distribution.intensity_cd().chunks(gammas.len());
        rows.flat_map(|row| (0..gammas.len()).map(move |column| slope(row, column)))
            .collect()
    }

    /// Weights on intensities become weights on samples: at a pole each half-plane's sample has an equal share.
    fn shared_at_poles(&self, mut weights: Vec<f64>) -> Vec<f64> {
        let gammas = self.distribution.gamma_deg();
        let planes = self.distribution.c_deg().len();
        for (column, &gamma) in gammas.iter().enumerate() {
            if is_pole(gamma) {
                let sum: f64 = (0..planes).map(|plane| weights[plane * gammas.len() + column]).sum();
                (0..planes).for_each(|plane| weights[plane * gammas.len() + column] = sum / planes as f64);
            }
        }
        weights
    }
}

/// 12 × 12 points of a square sensor on the axis: their direction (C, γ) in degrees, and what one candela there adds to
/// the mean illuminance, in 1/m².
pub fn sensor_points(side_mm: f64, distance_mm: f64) -> impl Iterator<Item = (f64, f64, f64)> {
    const POINTS: usize = 12;
    (0..POINTS * POINTS).map(move |point| {
        let place = |i: usize| ((i as f64 + 0.5) / POINTS as f64 - 0.5) * side_mm;
        let (x, y) = (place(point / POINTS), place(point % POINTS));
        let r2 = x * x + y * y + distance_mm * distance_mm;
        let gamma_deg = x.hypot(y).atan2(distance_mm).to_degrees();
        let c_deg = y.atan2(x).to_degrees().rem_euclid(360.0);
        let per_m2 = distance_mm / r2.sqrt() / (r2 * 1e-6) / (POINTS * POINTS) as f64;
        (c_deg, gamma_deg, per_m2)
    })
}

/// The γ of all half-planes. A pole is one direction, and one half-plane is enough for it.
fn gammas(planes: &[&[Sample]]) -> Result<Vec<f64>, ReduceError> {
    let between = |plane: &[Sample]| -> Vec<f64> {
        let gammas = plane.iter().map(|sample| sample.gamma_deg);
        gammas.filter(|&gamma| !is_pole(gamma)).collect()
    };
    let mut gamma_deg = planes.first().map_or_else(Vec::new, |plane| between(plane));
    for plane in planes {
        if between(plane) != gamma_deg {
            let (c_deg, found, expected) = (plane[0].c_deg, plane.len(), planes[0].len());
            return Err(ReduceError::NoGrid { c_deg, found, expected });
        }
    }
    let read = |pole: f64| {
        planes
            .iter()
            .any(|plane| plane.iter().any(|sample| sample.gamma_deg == pole))
    };
    if read(0.0) {
        gamma_deg.insert(0, 0.0);
    }
    if read(180.0) {
        gamma_deg.push(180.0);
    }
    if gamma_deg.len() < 2 {
        return Err(ReduceError::NoLight);
    }
    Ok(gamma_deg)
}

/// The sample of every node of the full circle, `[ic * ng + ig]`. Where a half-plane has no reading at a pole, those of
/// the others stand for it in turn.
fn samples_of(nodes: &[Sample], measured: &[f64], circle: &Circle, gamma_deg: &[f64]) -> Vec<usize> {
    let of_poles: Vec<Vec<usize>> = [0.0, 180.0]
        .iter()
        .map(|pole| {
            (0..nodes.len())
                .filter(|node| nodes[*node].gamma_deg == *pole)
                .collect()
        })
        .collect();
    let mut of_nodes = Vec::with_capacity(circle.planes.len() * gamma_deg.len());
    for (place, &(_, plane)) in circle.planes.iter().enumerate() {
        let first = nodes.partition_point(|sample| sample.c_deg < measured[plane]);
        let behind = nodes.partition_point(|sample| sample.c_deg <= measured[plane]);
        let here = &nodes[first..behind];
        for &gamma in gamma_deg {
            // By γ rising, as all samples are.
            let at = here.partition_point(|sample| sample.gamma_deg < gamma);
            of_nodes.push(match here.get(at) {
                Some(sample) if sample.gamma_deg == gamma => first + at,
                _ => {
                    let read = &of_poles[usize::from(gamma > 0.0)];
                    read[place % read.len()]
                }
            });
        }
    }
    of_nodes
}

/// The first node of every sample. That of the half-plane in which it was read: its images come behind it, or are equal.
fn places_of(sample_of: &[usize], samples: usize) -> Vec<usize> {
    let mut place_of = vec![0; samples];
    for (place, &sample) in sample_of.iter().enumerate().rev() {
        place_of[sample] = place;
    }
    place_of
}

/// Whether all half-planes meet at this γ.
pub fn is_pole(gamma_deg: f64) -> bool {
    gamma_deg == 0.0 || gamma_deg == 180.0
}

/// Intensities of half-planes of equal γ, with their mean where γ is a pole.
fn one_at_poles(intensity_cd: &[f64], gamma_deg: &[f64]) -> Vec<f64> {
    let mut one = intensity_cd.to_vec();
    let planes = intensity_cd.len() / gamma_deg.len();
    for (column, &gamma) in gamma_deg.iter().enumerate() {
        if is_pole(gamma) {
            let nodes = || (0..planes).map(|plane| plane * gamma_deg.len() + column);
            let mean = nodes().map(|node| intensity_cd[node]).sum::<f64>() / planes as f64;
            nodes().for_each(|node| one[node] = mean);
        }
    }
    one
}

/// A direction (C, γ) by a γ that may go on beyond the poles: (C, −γ) is (C + 180°, γ), (C, 180° + x) is
/// (C + 180°, 180° − x).
pub fn folded(c_deg: f64, signed_gamma_deg: f64) -> (f64, f64) {
    let within = (-180.0..=360.0).contains(&signed_gamma_deg);
    let gamma_deg = if within {
        signed_gamma_deg
    } else {
        signed_gamma_deg.rem_euclid(360.0)
    };
    match gamma_deg {
        below if below < 0.0 => (c_deg + 180.0, -below),
        beyond if beyond > 180.0 => (c_deg + 180.0, 360.0 - beyond),
        gamma_deg => (c_deg, gamma_deg),
    }
}

/// The interpolant beyond the poles, [`folded`]; clamped to the grid's γ elsewhere, because the distribution is zero
/// outside it and a displaced sample is not.
fn at_signed(distribution: &IntensityDistribution, c_deg: f64, gamma_deg: f64) -> f64 {
    let gammas = distribution.gamma_deg();
    let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
    let over_a_pole = gamma_deg < 0.0 && first == 0.0 || gamma_deg > 180.0 && last == 180.0;
    let (c, gamma) = if over_a_pole {
        folded(c_deg, gamma_deg)
    } else {
        (c_deg, gamma_deg.clamp(first, last))
    };
    distribution.intensity_cd_at(c, gamma)
}
