//! The numbers that one set of spectra and weights gives.

use isolux_spectrum::{Chromaticity, Spectrum};

use super::chromaticity::{Numbers, numbers};
use super::sum;
use crate::colour::{self, COUNT};

/// What is computed again whenever something is moved.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Lumens of each direction.
    pub lumens: Vec<f64>,
    /// Σ Φ_d·e_d, W/nm.
    pub total: Spectrum,
    /// Its numbers.
    pub whole: [Option<f64>; COUNT],
    /// Numbers of every direction.
    pub directions: Vec<Numbers>,
    /// Those of the average of x and y.
    pub average: Numbers,
}

impl Outcome {
    /// Of spectra of one lumen, the lumens that each stands for, and its weight in the average; none where one has no
    /// chromaticity.
    pub fn of(per_lumen: &[Spectrum], lumens: &[f64], lm79: &[f64]) -> Option<Self> {
        let total = sum(per_lumen.iter().zip(lumens.iter().copied()))?;
        let at: Option<Vec<Chromaticity>> = per_lumen.iter().map(Spectrum::chromaticity).collect();
        let at = at?;
        let mean = |of: fn(&Chromaticity) -> f64| at.iter().zip(lm79).map(|(at, weight)| weight * of(at)).sum::<f64>();
        let average = Chromaticity {
            x: mean(|at| at.x),
            y: mean(|at| at.y),
        };
        Some(Self {
            whole: colour::numbers(&total),
            lumens: lumens.to_vec(),
            total,
            directions: at.into_iter().map(numbers).collect(),
            average: numbers(average),
        })
    }

    /// By what the numbers of the total differ from those of `centre`.
    pub fn whole_from(&self, centre: &Self) -> [f64; COUNT] {
        colour::changes(&centre.whole, Some(&self.total))
    }

    /// Differences of each direction from the average in (u′, v′).
    pub fn differences(&self) -> Vec<[f64; 2]> {
        let [_, _, Some(u), Some(v), ..] = self.average else {
            return vec![[0.0; 2]; self.directions.len()];
        };
        let of = |numbers: &Numbers| [numbers[2].unwrap_or(u) - u, numbers[3].unwrap_or(v) - v];
        self.directions.iter().map(of).collect()
    }
}
