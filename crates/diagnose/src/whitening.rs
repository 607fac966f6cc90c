//! From readings to independent unit residuals: stated uncertainties, serial correlation, outlier weights.

mod correlation;

use nalgebra::{DMatrix, DVector};

pub use crate::calibration::MOST_CORRELATED;
use crate::noise::limits::PAUSE;

/// The order in which readings were taken, and how far apart, in typical steps.
///
/// The correlation of two neighbours `k` steps apart is ρᵏ (AR(1)); rows that have no place in time are independent.
#[derive(Debug, Clone)]
pub struct Sequence {
    /// Row numbers in time order, one run after the other.
    order: Vec<usize>,
    /// Steps since the row before in `order`; infinite at the start of a run.
    steps: Vec<f64>,
}

impl Sequence {
    /// Orders rows by `(run, time_s)`. A NaN time makes the row independent of its neighbours. The typical step is the
    /// median gap inside a run.
    pub fn by_time(run: &[usize], time_s: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..run.len()).collect();
        order.sort_by(|&a, &b| {
            run[a]
                .cmp(&run[b])
                .then(time_s[a].total_cmp(&time_s[b]))
                .then(a.cmp(&b))
        });
        let gap = |pair: &[usize]| {
            if run[pair[0]] == run[pair[1]] {
                time_s[pair[1]] - time_s[pair[0]]
            } else {
                f64::NAN
            }
        };
        let mut gaps: Vec<f64> = order.windows(2).map(gap).filter(|gap| *gap > 0.0).collect();
        gaps.sort_by(f64::total_cmp);
        let typical = gaps.get(gaps.len() / 2).copied().unwrap_or(1.0);
        let mut steps = vec![f64::INFINITY; run.len()];
        for (place, pair) in order.windows(2).enumerate() {
            let gap = gap(pair);
            steps[place + 1] = if gap.is_nan() {
                f64::INFINITY
            } else {
                (gap / typical).max(1e-3)
            };
        }
        Self { order, steps }
    }

    /// Row numbers in time order.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Whether any two rows are neighbours at all.
    pub fn has_neighbours(&self) -> bool {
        self.steps.iter().any(|step| *step < 1.5)
    }

    /// What every value has beyond twice its neighbours' in time, where they have the same sign: a reading that failed
    /// stands alone; a shadow lies on several readings in a row.
    fn isolated(&self, values: &DVector<f64>) -> DVector<f64> {
        let mut shared = DVector::zeros(values.len());
        for (place, pair) in self.order.windows(2).enumerate() {
            let [before, after] = [values[pair[0]], values[pair[1]]];
            if self.steps[place + 1] <= PAUSE && before * after > 0.0 {
                shared[pair[0]] = after.abs().max(shared[pair[0]]);
                shared[pair[1]] = before.abs().max(shared[pair[1]]);
            }
        }
        values.zip_map(&shared, |value, shared: f64| (value.abs() - 2.0 * shared).max(0.0))
    }

    fn correlation(&self, place: usize, rho: f64) -> f64 {
        let step = self.steps[place];
        if rho == 0.0 || step > PAUSE {
            0.0
        } else if step == 1.0 {
            rho
        } else {
            rho.powf(step)
        }
    }

    /// Correlation φ of every place with the one before, and √(1 − φ²).
    fn couplings(&self, rho: f64) -> Vec<(f64, f64)> {
        let coupling = |place: usize| {
            let phi = self.correlation(place, rho);
            (phi, (1.0 - phi * phi).sqrt())
        };
        (0..self.order.len()).map(coupling).collect()
    }

    /// Turns AR(1) residuals of unit variance into independent ones of unit variance, column by column.
    pub fn whiten(&self, rho: f64, matrix: &mut DMatrix<f64>) {
        if rho == 0.0 {
            return;
        }
        let couplings = self.couplings(rho);
        for mut column in matrix.column_iter_mut() {
            self.decouple(&couplings, column.as_mut_slice());
        }
    }

    fn decouple(&self, couplings: &[(f64, f64)], values: &mut [f64]) {
        for place in (1..self.order.len()).rev() {
            let (phi, own) = couplings[place];
            if phi != 0.0 {
                let before = values[self.order[place - 1]];
                let here = &mut values[self.order[place]];
                *here = (*here - phi * before) / own;
            }
        }
    }

    /// Turns independent values of unit variance into AR(1) ones, in place.
    pub fn colour(&self, rho: f64, values: &mut [f64]) {
        if rho == 0.0 {
            return;
        }
        for place in 1..self.order.len() {
            let phi = self.correlation(place, rho);
            if phi != 0.0 {
                let before = values[self.order[place - 1]];
                let here = &mut values[self.order[place]];
                *here = phi * before + (1.0 - phi * phi).sqrt() * *here;
            }
        }
    }

    /// [`whiten`](Self::whiten) for many vectors one after the other.
    pub fn whitening(&self, rho: f64) -> impl Fn(&mut [f64]) + Sync + '_ {
        let couplings = if rho == 0.0 { Vec::new() } else { self.couplings(rho) };
        move |values| {
            if !couplings.is_empty() {
                self.decouple(&couplings, values);
            }
        }
    }

    /// The transpose of [`whitening`](Self::whitening), in place.
    pub fn whiten_transposed(&self, rho: f64, values: &mut [f64]) {
        if rho == 0.0 {
            return;
        }
        let couplings = self.couplings(rho);
        for place in 0..self.order.len() {
            let later = couplings.get(place + 1).map_or(0.0, |(phi, own)| {
                if *phi == 0.0 {
                    0.0
                } else {
                    phi / own * values[self.order[place + 1]]
                }
            });
            let here = &mut values[self.order[place]];
            *here = *here / couplings[place].1 - later;
        }
    }
}

/// The noise of these observations.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Common factor on the stated uncertainties.
    pub scale: f64,
    /// The factor that the residuals show, fitted or not.
    pub observed: f64,
    /// Serial correlation of neighbours in time.
    pub rho: f64,
    /// Its standard uncertainty; 0 where there is none.
    pub u_rho: f64,
    /// What the variance of the residuals would be expected to be, in units of what it is, were the correlation lower
    /// or higher by `u_rho`.
    pub variance_at: [f64; 2],
    /// Outlier weights, one a row.
    pub weights: Vec<f64>,
}

/// A serial correlation and its standard uncertainty.
#[derive(Debug, Clone, Copy, Default)]
pub struct Correlation {
    /// ρ.
    pub rho: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

/// Outlier weights of a Student-t likelihood: 1 for all where the residuals are no heavier than a normal law's.
///
/// `residual` in units of its scale, in the rows of `sequence`. Only what a reading does not share with its neighbours
/// can make it an outlier, and less than `least` times its scale is none. The degrees of freedom follow from the sample
/// kurtosis (excess 6/(ν−4)); an excess below four of its own standard errors counts as none, so clean data keep
/// their full weight.
pub fn heavy_tail_weights(residual: &DVector<f64>, sequence: &Sequence, least: f64) -> Vec<f64> {
    let n = residual.len() as f64;
    let second = residual.iter().map(|z| z * z).sum::<f64>() / n;
    let fourth = residual.iter().map(|z| z.powi(4)).sum::<f64>() / n;
    let excess = fourth / (second * second) - 3.0;
    if excess.is_nan() || excess <= 4.0 * (24.0 / n).sqrt() {
        return vec![1.0; residual.len()];
    }
    let nu = (4.0 + 6.0 / excess).min(30.0);
    // Scale by the median so that the outliers themselves do not set it (median of |z| of a normal law: 0.6745).
    let mut magnitudes: Vec<f64> = residual.iter().map(|z| z.abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    // More than half of them may be equal to rounding.
    let scale = (magnitudes[magnitudes.len() / 2] / 0.6745).max(least);
    let isolated = sequence.isolated(residual);
    isolated
        .iter()
        .map(|z| ((nu + 1.0) / (nu + (z / scale).powi(2))).min(1.0))
        .collect()
}

/// Whitens rows of covariance I + v·vᵀ: W = I − (1 − 1/√(1+|v|²))·v·vᵀ/|v|².
pub(crate) fn without(v: &[(usize, f64)], column: &mut [f64]) {
    let length: f64 = v.iter().map(|(_, v)| v * v).sum();
    if length == 0.0 {
        return;
    }
    let share = (1.0 - 1.0 / (1.0 + length).sqrt()) / length;
    let along: f64 = v.iter().map(|&(i, v)| v * column[i]).sum();
    if along != 0.0 {
        for &(i, v) in v {
            column[i] -= share * along * v;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::correlation::tests::correlated;
    use super::*;

    #[test]
    fn whitening_leaves_no_correlation_and_unit_variance() {
        let n = 20_000;
        let time: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let sequence = Sequence::by_time(&vec![0; n], &time);
        let residual = correlated(n, 0.5, 3);
        let mut matrix = DMatrix::from_column_slice(n, 1, residual.as_slice());
        sequence.whiten(0.5, &mut matrix);
        let column = matrix.column(0);
        let lag: f64 = (1..n).map(|i| column[i] * column[i - 1]).sum::<f64>() / n as f64;
        assert!(lag.abs() < 0.02 && (column.norm_squared() / n as f64 - 1.0).abs() < 0.03);
    }

    #[test]
    fn outliers_lose_weight_and_normal_noise_keeps_it() {
        let time: Vec<f64> = (0..500).map(f64::from).collect();
        let sequence = Sequence::by_time(&[0; 500], &time);
        let mut residual = correlated(500, 0.0, 7);
        assert!(heavy_tail_weights(&residual, &sequence, 1.0).iter().all(|w| *w == 1.0));
        residual[17] = 9.0;
        residual[170] = -8.0;
        // A shadow on three readings in a row.
        residual.rows_mut(300, 3).copy_from_slice(&[-8.0, -10.0, -7.0]);
        let weights = heavy_tail_weights(&residual, &sequence, 1.0);
        assert!(weights[17] < 0.15 && weights[170] < 0.15);
        assert!(weights[300..303].iter().all(|weight| *weight > 0.5), "{weights:?}");
        assert!(weights.iter().sum::<f64>() > 400.0);
    }
}
