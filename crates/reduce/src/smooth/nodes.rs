//! The directions of a grid with what rounding and scatter leave open of each.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::grid::{Grid, is_pole};

/// Half the width of an interval beyond half a digit, in standard uncertainties of the scatter.
const SCATTER_WIDTH: f64 = 2.0;

/// The directions of a grid, each once: a pole belongs to all half-planes. Numbered γ by γ, so that neighbours are
/// close.
pub struct Nodes {
    /// The node of each place `[ic * ng + ig]` of the distribution.
    pub of_place: Vec<usize>,
    pub raw_cd: Vec<f64>,
    /// Standard uncertainty from rounding and scatter.
    pub u_cd: Vec<f64>,
    /// Half the width of the interval.
    pub half_cd: Vec<f64>,
    /// The directions of each γ.
    pub rings: Vec<Ring>,
}

/// The directions of one γ; one alone at a pole.
pub struct Ring {
    pub nodes: Range<usize>,
    /// Standard uncertainty of their mean: equal roundings do not average.
    pub u_mean_cd: f64,
}

impl Ring {
    /// The mean of the ring and what each of its directions differs from it: terms and standard uncertainty of each.
    pub fn modes(&self, u_cd: &[f64]) -> Vec<(Vec<(usize, f64)>, f64)> {
        let share = 1.0 / self.nodes.len() as f64;
        let mean = self.nodes.clone().map(|node| (node, share)).collect();
        let mut modes = vec![(mean, self.u_mean_cd)];
        if self.nodes.len() > 1 {
            modes.extend(self.nodes.clone().map(|own| {
                let weight = |node: usize| if node == own { 1.0 - share } else { -share };
                (self.nodes.clone().map(|node| (node, weight(node))).collect(), u_cd[own])
            }));
        }
        modes
    }
}

impl Nodes {
    pub fn of(grid: &Grid) -> Self {
        let raw = &grid.distribution;
        let (planes, gammas) = (raw.c_deg().len(), raw.gamma_deg());
        let mut nodes = Self {
            of_place: vec![0; planes * gammas.len()],
            raw_cd: Vec::new(),
            u_cd: Vec::new(),
            half_cd: Vec::new(),
            rings: Vec::new(),
        };
        for (ig, &gamma) in gammas.iter().enumerate() {
            let place = |ic: usize| ic * gammas.len() + ig;
            let first = nodes.raw_cd.len();
            let samples: Vec<usize> = (0..planes).map(|ic| grid.sample_of[place(ic)]).collect();
            let (mut digit, noise) = of_mean(grid, &samples);
            if is_pole(gamma) {
                // Of one direction, all readings are rounded alike.
                digit = samples.iter().map(|&at| grid.nodes[at].u_digit_cd).fold(0.0, f64::max);
                (0..planes).for_each(|ic| nodes.of_place[place(ic)] = first);
                nodes.push(raw.intensity_cd()[ig], digit, noise);
            } else {
                for (ic, &at) in samples.iter().enumerate() {
                    nodes.of_place[place(ic)] = nodes.raw_cd.len();
                    let sample = &grid.nodes[at];
                    nodes.push(raw.intensity_cd()[place(ic)], sample.u_digit_cd, sample.u_noise_cd);
                }
            }
            nodes.rings.push(Ring {
                nodes: first..nodes.raw_cd.len(),
                u_mean_cd: digit.hypot(noise),
            });
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

/// What the mean of these samples is uncertain by, by rounding and by scatter: those with the same display are rounded
/// alike, and one that stands for several directions is wrong in all of them.
fn of_mean(grid: &Grid, samples: &[usize]) -> (f64, f64) {
    let share = 1.0 / samples.len() as f64;
    let mut shares: BTreeMap<usize, f64> = BTreeMap::new();
    for &sample in samples {
        *shares.entry(sample).or_default() += share;
    }
    let mut alike: BTreeMap<Result<i64, usize>, f64> = BTreeMap::new();
    let mut noise2 = 0.0;
    for (at, share) in shares {
        let sample = &grid.nodes[at];
        *alike.entry(sample.display.ok_or(at)).or_default() += share * sample.u_digit_cd;
        noise2 += (share * sample.u_noise_cd).powi(2);
    }
    let digit2: f64 = alike.values().map(|u_cd| u_cd * u_cd).sum();
    (digit2.sqrt(), noise2.sqrt())
}
