//! The lobe of one aimed LED, such that all LEDs together are the file's far field.
//!
//! Parallel LEDs each carry the file's distribution. LEDs that lean inward by ψ do not: their sum over azimuth widens
//! the lobe, so the single lobe is narrower. Only its ratio to that sum is used, so that the far field is the file's
//! exactly, whatever is left of the fit.

use std::sync::Arc;

use glam::DVec3;
use isolux_photometry::{IntensityDistribution, angles_deg, direction, polar_deg};

use crate::angle_table::{AngleTable, linear};
use crate::emitter::Node;

/// Step of the table of the lobe.
const STEP_DEG: f64 = 0.5;
const NODES: usize = 361;
/// Steps of the finished tables in one of the fit.
const FINER: usize = 5;
const FINE_DEG: f64 = STEP_DEG / FINER as f64;
/// Azimuths in half a turn; the integrand is smooth and even.
const AZIMUTHS: usize = 16;
const ITERATIONS: usize = 10;
/// Half width of the smoothing in steps of the table, at least and at most.
const SMOOTHING: (usize, usize) = (4, 16);
/// The same as a share of the angle at which half the peak is left: what is narrower than that in the file of such a
/// lobe is noise, and undoing an average makes it grow.
const SMOOTHING_SHARE: f64 = 0.25;

/// Steps of the finished table of the lobe.
const SINE_STEPS: usize = NODES * FINER;

/// The lobe of one LED and the sum of all.
#[derive(Debug, Clone)]
pub struct Lobe {
    lobe: AngleTable,
    sum: Sum,
}

#[derive(Debug, Clone)]
enum Sum {
    /// The LEDs lie evenly on circles.
    Rotational(Vec<f64>),
    /// Any other places: over C and γ.
    Grid(IntensityDistribution),
}

impl Lobe {
    /// What the lobes of all LEDs add up to: the mean over C of a distribution, at the angles of [`fit`](Self::fit).
    pub(crate) fn target_cd(distribution: &IntensityDistribution) -> Arc<[f64]> {
        (0..NODES)
            .map(|i| mean_over_c(distribution, i as f64 * STEP_DEG).max(0.0))
            .collect()
    }

    /// The lobe of LEDs `nodes` that lean inward by `aim_deg`.
    pub(crate) fn fit(target: &[f64], nodes: &[Node], aim_deg: f64, on_circles: bool) -> Option<Self> {
        let upright = Self::upright(nodes);
        let (sin, cos) = aim_deg.to_radians().sin_cos();
        // What LEDs at these azimuths send to one γ left them at other angles from their own axes.
        let cos_azimuth: [f64; AZIMUTHS] =
            std::array::from_fn(|k| (std::f64::consts::PI * (k as f64 + 0.5) / AZIMUTHS as f64).cos());
        let ring_cosines = |gamma_deg: f64| {
            let (sin_gamma, cos_gamma) = gamma_deg.to_radians().sin_cos();
            cos_azimuth.map(|cos_azimuth| (cos * cos_gamma + sin * sin_gamma * cos_azimuth).clamp(-1.0, 1.0))
        };
        let places: Vec<f64> = (0..NODES)
            .flat_map(|i| ring_cosines(i as f64 * STEP_DEG).map(|cosine| cosine.acos().to_degrees() / STEP_DEG))
            .collect();
        let sum_of = |lobe: &[f64]| -> Vec<f64> {
            (0..NODES)
                .map(|i| {
                    let ring: f64 = places[i * AZIMUTHS..(i + 1) * AZIMUTHS]
                        .iter()
                        .map(|place| linear(lobe, *place))
                        .sum();
                    upright * lobe[i] + (1.0 - upright) * ring / AZIMUTHS as f64
                })
                .collect()
        };
        // Multiplicative iteration keeps the lobe positive; the correction is smoothed, because undoing an average
        // would otherwise blow up the corners that the file's grid has between its angles.
        let mut lobe = target.to_vec();
        let peak = target.iter().fold(0.0_f64, |peak, value| peak.max(*value));
        let bright = target.iter().rposition(|value| *value >= 0.5 * peak).unwrap_or(0);
        let half_width = ((SMOOTHING_SHARE * bright as f64) as usize).clamp(SMOOTHING.0, SMOOTHING.1) as isize;
        for _ in 0..ITERATIONS {
            let sum = sum_of(&lobe);
            let ratio: Vec<f64> = target
                .iter()
                .zip(&sum)
                .map(|(target, sum)| if *sum > 0.0 && *target > 0.0 { target / sum } else { 1.0 })
                .collect();
            for (index, value) in lobe.iter_mut().enumerate() {
                *value *= smoothed(&ratio, index, half_width);
            }
        }
        // A finer table, so that the LEDs' shares add up to one between the angles of the fit, too.
        let fine = finer(&lobe);
        let lobe = AngleTable::of(SINE_STEPS, |gamma_deg| linear(&fine, gamma_deg / FINE_DEG));
        let sum = if on_circles {
            let sum_at = |index: usize| {
                let own_cosines = ring_cosines(index as f64 * FINE_DEG);
                let ring: f64 = own_cosines.iter().map(|cosine| lobe.at_cosine(*cosine)).sum();
                upright * fine[index] + (1.0 - upright) * ring / AZIMUTHS as f64
            };
            Sum::Rotational((0..fine.len()).map(sum_at).collect())
        } else {
            Sum::Grid(grid(&lobe, nodes)?)
        };
        Some(Self { lobe, sum })
    }

    /// The weight of LEDs on the axis, which have nowhere to lean.
    pub(crate) fn upright(nodes: &[Node]) -> f64 {
        let upright = nodes.iter().filter(|node| node.axis == DVec3::Z);
        upright.map(|node| node.weight).sum()
    }

    /// The share of the far field towards `direction` (unit) that an LED with `axis` has, relative to its weight.
    pub fn share(&self, axis: DVec3, direction: DVec3) -> f64 {
        self.share_at(axis, direction, polar_deg(direction))
    }

    /// As [`share`](Self::share), γ of the direction being known.
    pub(crate) fn share_at(&self, axis: DVec3, direction: DVec3, gamma_deg: f64) -> f64 {
        let own = self.lobe.at_cosine(axis.dot(direction));
        let sum = match &self.sum {
            Sum::Rotational(sum) => linear(sum, gamma_deg / FINE_DEG),
            Sum::Grid(sum) => sum.intensity_cd_at(angles_deg(direction).0, gamma_deg),
        };
        if sum > 1e-9 * self.lobe.first().abs() {
            own / sum
        } else {
            1.0
        }
    }
}

fn grid(lobe: &AngleTable, nodes: &[Node]) -> Option<IntensityDistribution> {
    let c_deg: Vec<f64> = (0..72).map(|i| 5.0 * i as f64).collect();
    let gamma_deg: Vec<f64> = (0..=180).map(f64::from).collect();
    let mut sum = Vec::with_capacity(c_deg.len() * gamma_deg.len());
    for c in &c_deg {
        for gamma in &gamma_deg {
            let direction = direction(*c, *gamma);
            let of_node = |node: &Node| node.weight * lobe.at_cosine(node.axis.dot(direction));
            sum.push(nodes.iter().map(of_node).sum());
        }
    }
    IntensityDistribution::new(c_deg, gamma_deg, sum).ok()
}

/// Mean over C at a γ, cd.
pub(crate) fn mean_over_c(distribution: &IntensityDistribution, gamma_deg: f64) -> f64 {
    if distribution.is_rotational() {
        return distribution.intensity_cd_at(0.0, gamma_deg);
    }
    (0..24)
        .map(|k| distribution.intensity_cd_at(15.0 * f64::from(k), gamma_deg))
        .sum::<f64>()
        / 24.0
}

/// Mean over ± `half_width` steps, mirrored at both poles.
fn smoothed(table: &[f64], index: usize, half_width: isize) -> f64 {
    let at = |place: isize| {
        let mirrored = place.unsigned_abs();
        table[if mirrored < NODES {
            mirrored
        } else {
            2 * (NODES - 1) - mirrored
        }]
    };
    (-half_width..=half_width).map(|k| at(index as isize + k)).sum::<f64>() / (2 * half_width + 1) as f64
}

/// The same table with `FINER` times as many steps, by cubic convolution.
fn finer(table: &[f64]) -> Vec<f64> {
    let at = |place: isize| {
        let mirrored = place.unsigned_abs();
        table[if mirrored < NODES {
            mirrored
        } else {
            2 * (NODES - 1) - mirrored
        }]
    };
    let between = |index: usize| {
        let (cell, t) = ((index / FINER) as isize, (index % FINER) as f64 / FINER as f64);
        let [a, b, c, d] = [-1, 0, 1, 2].map(|k| at(cell + k));
        b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
    };
    (0..=(NODES - 1) * FINER).map(|index| between(index).max(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitter::Emitter;

    /// LEDs of cosⁿ lobes, leaning inward: their far field is known in closed form of a sum, and so is each LED's
    /// share.
    #[test]
    fn finds_the_single_lobe_of_a_ring() {
        let (n, aim) = (6, 6.0f64);
        let ring = Emitter::Leds {
            position_mm: vec![],
            weight: vec![],
            radius_mm: vec![28.0],
            count: vec![36],
            aim_deg: aim,
        };
        let nodes = ring.nodes(1);
        let truth = |axis: DVec3, d: DVec3| axis.dot(d).max(0.0).powi(n);
        let gamma: Vec<f64> = (0..=90).map(f64::from).collect();
        let far: Vec<f64> = gamma
            .iter()
            .map(|g| {
                let (sin, cos) = g.to_radians().sin_cos();
                nodes
                    .iter()
                    .map(|node| node.weight * truth(node.axis, DVec3::new(sin, 0.0, cos)))
                    .sum()
            })
            .collect();
        let file = IntensityDistribution::new(vec![0.0], gamma, far.clone()).unwrap();
        let lobe = Lobe::fit(&Lobe::target_cd(&file), &nodes, aim, true).unwrap();
        for g in [0.0f64, 5.0, 15.0, 30.0, 45.0] {
            let (sin, cos) = g.to_radians().sin_cos();
            for azimuth in [0.0f64, 1.0, 2.5] {
                let d = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                let total: f64 = nodes.iter().map(|node| node.weight * truth(node.axis, d)).sum();
                for node in nodes.iter().step_by(5) {
                    let (found, expected) = (lobe.share(node.axis, d), truth(node.axis, d) / total);
                    assert!((found / expected - 1.0).abs() < 3e-3, "γ {g}: {found} for {expected}");
                }
            }
        }
    }

    /// The file of a measured lamp has noise, which must not grow in the lobe of LEDs that lean.
    #[test]
    fn noise_of_the_file_stays_small_in_the_lobe() {
        let gamma: Vec<f64> = (0..=45).map(|i| 2.0 * f64::from(i)).collect();
        let file = |noise_rel: f64| {
            let value = |(i, gamma): (usize, &f64)| {
                let noise = (i as f64 * 12.9898).sin() * 2_f64.sqrt() * noise_rel;
                1000.0 * gamma.to_radians().cos().powi(8) * (1.0 + noise)
            };
            let values = gamma.iter().enumerate().map(value).collect();
            IntensityDistribution::new(vec![0.0], gamma.clone(), values).unwrap()
        };
        let ring = Emitter::Leds {
            position_mm: vec![],
            weight: vec![],
            radius_mm: vec![28.0],
            count: vec![12],
            aim_deg: 8.0,
        };
        let nodes = ring.nodes(1);
        let [clean, noisy] =
            [0.0, 1e-3].map(|noise| Lobe::fit(&Lobe::target_cd(&file(noise)), &nodes, 8.0, true).unwrap());
        // The light of all LEDs on a sensor at 500 mm, where each is seen from another direction.
        let worst = (0..15)
            .map(|x| {
                let point = DVec3::new(10.0 * f64::from(x), 0.0, 500.0);
                let sum = |lobe: &Lobe| -> f64 {
                    let share = |node: &Node| lobe.share(node.axis, (point - node.position_mm).normalize());
                    nodes.iter().map(share).sum()
                };
                (sum(&noisy) / sum(&clean) - 1.0).abs()
            })
            .fold(0.0, f64::max);
        assert!(worst < 0.012, "{worst}");
    }
}
