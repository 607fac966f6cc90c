//! A series of samples: mean, spread and tolerance interval of each quantity that all of them have.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::item::Item;

/// Items from which on a series has a spread.
const LEAST: usize = 3;
/// Normal deviate that holds 95 % on both sides.
const Z_CONTENT: f64 = 1.959_963_984_540_054;
/// One less the confidence.
const BELOW: f64 = 0.05;

/// The spread of all items.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// How many items.
    pub count: usize,
    /// Factor on the standard deviation of the tolerance interval.
    pub k_tolerance: f64,
    /// One a quantity.
    pub rows: Vec<SeriesRow>,
}

/// One quantity of a series.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SeriesRow {
    /// What it is.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation of one item.
    pub s: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Interval that holds 95 % of all such items with 95 % confidence, if they are distributed normally.
    pub tolerance: [f64; 2],
}

impl Series {
    /// None of fewer than three items.
    pub(super) fn of(items: &[Item]) -> Option<Self> {
        let count = items.len();
        let (first, _) = items.split_first().filter(|_| count >= LEAST)?;
        let k = k_tolerance(count);
        let row = |name: &str, unit: &str| {
            let values: Vec<f64> = items
                .iter()
                .map(|item| Some(item.values.iter().find(|value| value.name == name)?.value))
                .collect::<Option<_>>()?;
            let n = count as f64;
            let mean = values.iter().sum::<f64>() / n;
            let s = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            Some(SeriesRow {
                quantity: name.to_owned(),
                unit: unit.to_owned(),
                mean,
                s,
                min: values.iter().copied().fold(f64::INFINITY, f64::min),
                max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                tolerance: [mean - k * s, mean + k * s],
            })
        };
        let rows = first.values.iter().filter_map(|value| row(&value.name, &value.unit));
        Some(Self {
            count,
            k_tolerance: k,
            rows: rows.collect(),
        })
    }
}

/// Factor of a two-sided tolerance interval for 95 % of a normal population with 95 % confidence (ISO 16269-6), by Howe
/// (J. Am. Stat. Assoc. 64, 1969): within 1 % from three items on.
fn k_tolerance(count: usize) -> f64 {
    let n = count as f64;
    Z_CONTENT * ((n - 1.0) * (1.0 + 1.0 / n) / chi_square_below(count - 1)).sqrt()
}

/// The value below which [`BELOW`] of a χ² distribution lies.
fn chi_square_below(degrees: usize) -> f64 {
    let (mut low, mut high) = (0.0, degrees as f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if chi_square_share(middle, degrees) < BELOW {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Share of a χ² distribution below `value`: the series of the incomplete gamma function (NIST DLMF 8.7.1).
fn chi_square_share(value: f64, degrees: usize) -> f64 {
    let (s, x) = (0.5 * degrees as f64, 0.5 * value);
    // xˢ e⁻ˣ / Γ(s + 1), factor by factor from Γ(1) = 1 or Γ(3/2) = √π/2.
    let (mut at, mut term) = if degrees.is_multiple_of(2) {
        (0.0, (-x).exp())
    } else {
        (0.5, (-x).exp() * x.sqrt() * 2.0 / std::f64::consts::PI.sqrt())
    };
    while at < s {
        at += 1.0;
        term *= x / at;
    }
    let mut sum = 0.0;
    while term > 1e-17 {
        sum += term;
        at += 1.0;
        term *= x / at;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::k_tolerance;

    #[test]
    fn factors_are_those_of_the_tables() {
        // Two-sided, 95 % of the population, 95 % confidence: Natrella, NBS Handbook 91 (1963), table A-6.
        for (count, expected) in [(3, 9.916), (5, 5.079), (10, 3.379), (20, 2.752), (30, 2.549)] {
            let k = k_tolerance(count);
            assert!((k / expected - 1.0).abs() < 0.01, "{count}: {k}, {expected}");
        }
    }
}
