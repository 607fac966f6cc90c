//! Uncertainty of what is summed from many readings: independent parts add in squares, common parts in full.

use std::collections::{BTreeMap, HashMap};

use serde::Serialize;

use crate::grid::Grid;

/// Relative and absolute standard uncertainties (k = 1) that all readings share.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Common {
    /// What was subtracted from every reading (offset, ambient, stray): its scatter, in candela.
    pub dark_noise_cd: f64,
    /// And its rounding, in candela.
    pub dark_digit_cd: f64,
    /// Distance: 2·u(d)/d.
    pub distance_rel: f64,
    /// Calibration of the lux meter.
    pub calibration_rel: f64,
    /// Drift.
    pub drift_rel: f64,
}

/// One number with its standard uncertainty and the parts of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Standard uncertainty (k = 1).
    pub u: f64,
    /// The parts of `u` by name, in the same unit; they add in squares.
    pub parts: BTreeMap<&'static str, f64>,
}

impl Quantity {
    /// A quantity from its parts.
    pub fn new(value: f64, unit: &'static str, parts: impl IntoIterator<Item = (&'static str, f64)>) -> Self {
        let parts: BTreeMap<_, _> = parts.into_iter().map(|(name, part)| (name, part.abs())).collect();
        let u = parts.values().map(|part| part * part).sum::<f64>().sqrt();
        Self { value, unit, u, parts }
    }

    /// Relative standard uncertainty.
    pub fn u_rel(&self) -> f64 {
        self.u / self.value.abs()
    }

    /// The same multiplied by a factor with a relative uncertainty of its own.
    #[must_use]
    pub fn times(&self, factor: f64, unit: &'static str, name: &'static str, u_rel: f64) -> Self {
        let value = self.value * factor;
        let parts = self
            .parts
            .iter()
            .map(|(name, part)| (*name, part * factor))
            .chain([(name, value * u_rel)]);
        Self::new(value, unit, parts)
    }
}

/// A weighted sum Σ w·I of the intensities of a grid.
///
/// The noise of each point is independent of every other. The rounding of a point is the same as that of every other point
/// with the same display: behind the lamp, where every reading shows the same digits, all are wrong by the same amount.
pub fn weighted_sum(grid: &Grid, weights: &[f64], common: &Common, unit: &'static str) -> Quantity {
    let intensity = grid.distribution.intensity_cd();
    let value: f64 = intensity.iter().zip(weights).map(|(cd, weight)| cd * weight).sum();
    let total: f64 = weights.iter().sum();
    let mut noise2 = 0.0;
    let mut alone2 = 0.0;
    let mut alike: HashMap<i64, f64> = HashMap::new();
    for (sample, weight) in grid.nodes.iter().zip(weights) {
        noise2 += (weight * sample.u_noise_cd).powi(2);
        match sample.display {
            Some(display) => *alike.entry(display).or_default() += weight * sample.u_digit_cd,
            None => alone2 += (weight * sample.u_digit_cd).powi(2),
        }
    }
    // Sorted, so that the sum of squares has the same last bit in every process.
    let mut groups: Vec<(i64, f64)> = alike.into_iter().collect();
    groups.sort_by_key(|(display, _)| *display);
    let digit2 = alone2 + groups.iter().map(|(_, sum)| sum * sum).sum::<f64>();
    Quantity::new(
        value,
        unit,
        [
            ("noise", noise2.sqrt()),
            ("digit", digit2.sqrt()),
            ("dark_noise", total * common.dark_noise_cd),
            ("dark_digit", total * common.dark_digit_cd),
            ("distance", value * common.distance_rel),
            ("calibration", value * common.calibration_rel),
            ("drift", value * common.drift_rel),
        ],
    )
}
