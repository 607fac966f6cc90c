//! Bayes factors in closed form, averaged over the amplitude's scale.

use crate::calibration::AMPLITUDE_SIGMA;

/// Natural logarithm of the Bayes factor of "these `directions` carry a signal" against "they carry noise".
///
/// `explained` is the squared length of the whitened residual inside the directions. For a normal prior of variance g a
/// direction (a g-prior) the factor is (1+g)^(−k/2)·exp(½·explained·g/(1+g)); it is averaged over amplitudes from 3 to
/// 90 σ, so that no one scale is favoured (Zellner 1986; Liang et al. 2008).
pub fn ln_bayes_factor(explained: f64, directions: usize) -> f64 {
    let k = directions.max(1) as f64;
    let terms = AMPLITUDE_SIGMA.map(|sigma| {
        let g = sigma * sigma / k;
        -0.5 * k * g.ln_1p() + 0.5 * explained * g / (1.0 + g)
    });
    ln_sum_exp(&terms) - (AMPLITUDE_SIGMA.len() as f64).ln()
}

/// ln Σ exp(terms), without overflow; −∞ for none.
pub fn ln_sum_exp(terms: &[f64]) -> f64 {
    let top = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + terms.iter().map(|term| (term - top).exp()).sum::<f64>().ln()
}

/// [`ln_bayes_factor`] tabulated, for the thousands of simulated scans.
#[derive(Debug)]
pub struct EvidenceTable {
    rows: Vec<Vec<f64>>,
}

impl EvidenceTable {
    const STEP: f64 = 0.125;
    const TOP: f64 = 64.0;

    /// For up to `directions` directions.
    pub fn new(directions: usize) -> Self {
        let points = (Self::TOP / Self::STEP) as usize + 2;
        let rows = (0..=directions)
            .map(|k| (0..points).map(|i| ln_bayes_factor(i as f64 * Self::STEP, k)).collect())
            .collect();
        Self { rows }
    }

    /// As [`ln_bayes_factor`], linear between 0.125 steps of `explained` (error below 1e-3).
    pub fn at(&self, explained: f64, directions: usize) -> f64 {
        if explained >= Self::TOP {
            return ln_bayes_factor(explained, directions);
        }
        let place = explained.max(0.0) / Self::STEP;
        let i = place as usize;
        let row = &self.rows[directions];
        row[i] + (place - i as f64) * (row[i + 1] - row[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_counts_against_and_signal_for() {
        assert!(ln_bayes_factor(1.0, 1) < -1.0);
        assert!(ln_bayes_factor(25.0, 1) > 8.0);
        // More directions for the same explained sum are worse evidence.
        assert!(ln_bayes_factor(25.0, 3) < ln_bayes_factor(25.0, 1));
    }

    #[test]
    fn bayes_factor_averages_to_one_under_noise() {
        // E[BF] = 1 under the null: ∫ BF(x)·χ²₁(x) dx, by the trapezoid in z = √x.
        let step = 0.02;
        let integral: f64 = (-30_000..=30_000)
            .map(|i| {
                let z = i as f64 * step;
                ln_bayes_factor(z * z, 1) - 0.5 * z * z - 0.5 * (2.0 * std::f64::consts::PI).ln()
            })
            .map(f64::exp)
            .sum::<f64>()
            * step;
        assert!((integral - 1.0).abs() < 1e-4, "{integral}");
    }

    #[test]
    fn the_table_agrees_with_the_formula() {
        let table = EvidenceTable::new(4);
        for k in 1..=4 {
            for i in 0..500 {
                let x = 0.31 * i as f64;
                assert!((table.at(x, k) - ln_bayes_factor(x, k)).abs() < 2e-3);
            }
        }
    }
}
