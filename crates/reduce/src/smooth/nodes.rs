//! The directions of a grid with what rounding and scatter leave open of each.

use crate::grid::{Grid, is_pole};

/// Half the width of an interval beyond half a digit, in standard uncertainties of the scatter.
const SCATTER_WIDTH: f64 = 2.0;

/// What is known of each place `[ic * ng + ig]` of a distribution; at a pole, which belongs to all half-planes, the
/// same in each.
pub struct Nodes {
    /// Half-planes.
    pub planes: usize,
    /// γ of each.
    pub gammas: usize,
    pub raw_cd: Vec<f64>,
    /// Standard uncertainty from rounding and scatter.
    pub u_cd: Vec<f64>,
    /// Half the width of the interval.
    pub half_cd: Vec<f64>,
    /// The directions of each γ.
    pub rings: Vec<Ring>,
}

/// The directions of one γ.
pub struct Ring {
    /// Whether they are one, a pole.
    pub pole: bool,
    /// Their mean.
    pub mean_cd: f64,
    /// Standard uncertainty of their mean: equal roundings do not average.
    pub u_mean_cd: f64,
    /// Mean of the squares of their standard uncertainties.
    pub variance_cd2: f64,
}

impl Nodes {
    pub fn of(grid: &Grid) -> Self {
        let raw = &grid.distribution;
        let (planes, gammas) = (raw.c_deg().len(), raw.gamma_deg().len());
        let mut nodes = Self {
            planes,
            gammas,
            raw_cd: raw.intensity_cd().to_vec(),
            u_cd: vec![0.0; planes * gammas],
            half_cd: vec![0.0; planes * gammas],
            rings: Vec::with_capacity(gammas),
        };
        for (ig, &gamma) in raw.gamma_deg().iter().enumerate() {
            let places = || (0..planes).map(|ic| ic * gammas + ig);
            let samples: Vec<usize> = places().map(|place| grid.sample_of[place]).collect();
            let (mut digit, noise) = of_mean(grid, &samples);
            let pole = is_pole(gamma);
            if pole {
                // Of one direction, all readings are rounded alike.
                digit = samples.iter().map(|&at| grid.nodes[at].u_digit_cd).fold(0.0, f64::max);
            }
            for (place, &at) in places().zip(&samples) {
                let sample = &grid.nodes[at];
                let (digit, noise) = if pole {
                    (digit, noise)
                } else {
                    (sample.u_digit_cd, sample.u_noise_cd)
                };
                nodes.u_cd[place] = digit.hypot(noise);
                // The standard uncertainty of a rounding is digit/√12, so that half a digit is √3 of it.
                nodes.half_cd[place] = 3.0_f64.sqrt() * digit + SCATTER_WIDTH * noise;
            }
            let mean = |of: &dyn Fn(usize) -> f64| places().map(of).sum::<f64>() / planes as f64;
            nodes.rings.push(Ring {
                pole,
                mean_cd: mean(&|place| nodes.raw_cd[place]),
                u_mean_cd: digit.hypot(noise),
                variance_cd2: mean(&|place| nodes.u_cd[place].powi(2)),
            });
        }
        nodes
    }

    /// What every place differs from the mean of its γ: nothing at a pole.
    pub fn deviations_cd(&self) -> Vec<f64> {
        let mut deviations = self.raw_cd.clone();
        self.centre(&mut deviations);
        deviations
    }

    /// Takes from `values` the mean of every γ.
    pub fn centre(&self, values: &mut [f64]) {
        for (ig, ring) in self.rings.iter().enumerate() {
            let mean = values.iter().skip(ig).step_by(self.gammas).sum::<f64>() / self.planes as f64;
            for value in values.iter_mut().skip(ig).step_by(self.gammas) {
                *value = if ring.pole { 0.0 } else { *value - mean };
            }
        }
    }
}

/// What the mean of these samples is uncertain by, by rounding and by scatter: those with the same display are rounded
/// alike, and one that stands for several directions is wrong in all of them.
fn of_mean(grid: &Grid, samples: &[usize]) -> (f64, f64) {
    let count = samples.len() as f64;
    let mut samples = samples.to_vec();
    samples.sort_unstable();
    let mut digits: Vec<(Result<i64, usize>, f64)> = Vec::with_capacity(samples.len());
    let mut noise2 = 0.0;
    for same in samples.chunk_by(|a, b| a == b) {
        let (at, share) = (same[0], same.len() as f64 / count);
        let sample = &grid.nodes[at];
        digits.push((sample.display.ok_or(at), share * sample.u_digit_cd));
        noise2 += (share * sample.u_noise_cd).powi(2);
    }
    digits.sort_by_key(|(display, _)| *display);
    let alike = digits.chunk_by(|a, b| a.0 == b.0);
    let digit2: f64 = alike
        .map(|alike| alike.iter().map(|(_, u_cd)| u_cd).sum::<f64>().powi(2))
        .sum();
    (digit2.sqrt(), noise2.sqrt())
}
