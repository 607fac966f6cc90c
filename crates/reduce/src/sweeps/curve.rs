//! Light along one sweep: the spline whose means over the windows of the conversions are what was read.
//!
//! Each conversion is the mean over the way that the axis went while the meter integrated; fitting the spline to these
//! means undoes their blur. A penalty on second differences of its coefficients holds it where few conversions do, in
//! proportion to the weight that they have there; its strength is the one at which conversions that are kept out are
//! predicted best. The covariance is that of the posterior, so a way without light is uncertain, not smooth.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::basis::{Basis, Weights};

/// One conversion: the way that it is the mean over, what it said, and the standard deviation of its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    pub from_deg: f64,
    pub to_deg: f64,
    pub value: f64,
    pub sigma: f64,
}

impl Window {
    /// Middle of the way, degrees.
    pub fn middle_deg(&self) -> f64 {
        0.5 * (self.from_deg + self.to_deg)
    }
}

/// The light along a sweep.
#[derive(Debug, Clone)]
pub struct Curve {
    basis: Basis,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Where conversions were kept out, and by how much their square of the error exceeds what noise explains.
    kept_out: Vec<(f64, f64)>,
    /// Degrees over which that is averaged.
    reach_deg: f64,
    /// Steps of γ in the window of a conversion, at least one: its mean over several says less of each.
    steps: f64,
}

/// One in so many conversions is kept out at a time.
const FOLDS: usize = 4;
/// Strengths of the penalty, in shares of the weight of the coefficients around.
const STRENGTHS: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];
/// Steps of γ over which the error of kept-out conversions is averaged.
const REACH_STEPS: f64 = 3.0;

impl Curve {
    /// The curve over `gamma_deg` through `windows`; none where they do not determine it.
    pub fn through(gamma_deg: &[f64], windows: &[Window]) -> Option<Self> {
        if windows.is_empty() {
            return None;
        }
        let basis = Basis::over(gamma_deg);
        let rows: Vec<Weights> = windows.iter().map(|w| basis.mean(w.from_deg, w.to_deg)).collect();
        let wanted = |kept: &dyn Fn(usize) -> bool| normal(basis.len(), &rows, windows, kept);
        let folds: Vec<_> = (0..FOLDS).map(|fold| wanted(&|k| k % FOLDS != fold)).collect();
        let (matrix, right) = wanted(&|_| true);
        let penalty = penalty(&matrix, &basis, windows);
        let errors = |strength: f64| -> Option<Vec<f64>> {
            let mut errors = vec![0.0; windows.len()];
            for (fold, (matrix, right)) in folds.iter().enumerate() {
                let coefficients = solved(matrix, &penalty, strength)?.solve(right);
                for k in (fold..windows.len()).step_by(FOLDS) {
                    errors[k] = windows[k].value - rows[k].value(&coefficients);
                }
            }
            Some(errors)
        };
        let misfit = |errors: &[f64]| -> f64 { errors.iter().zip(windows).map(|(e, w)| (e / w.sigma).powi(2)).sum() };
        let (strength, kept_out) = STRENGTHS
            .into_iter()
            .filter_map(|strength| Some((strength, errors(strength)?)))
            .min_by(|a, b| misfit(&a.1).total_cmp(&misfit(&b.1)))?;

        let factor = solved(&matrix, &penalty, strength)?;
        let coefficients = factor.solve(&right);
        let inverse = factor.inverse();
        let freedom = windows.len() as f64 - (&inverse * &matrix).trace();
        let residual: f64 = rows
            .iter()
            .zip(windows)
            .map(|(row, window)| ((window.value - row.value(&coefficients)) / window.sigma).powi(2))
            .sum();
        // What is stated of the noise is believed as far as the scatter allows.
        let scale = if freedom > 1.0 {
            (residual / freedom).max(1.0)
        } else {
            1.0
        };
        let covariance = inverse * scale;
        let kept_out = kept_out
            .iter()
            .zip(windows.iter().zip(&rows))
            .map(|(error, (window, row))| {
                let explained = window.sigma * window.sigma + row.variance(&covariance);
                (window.middle_deg(), error * error - explained)
            })
            .collect();
        let [low, high] = basis.range_deg();
        let step_deg = (high - low) / (gamma_deg.len() - 1) as f64;
        let widths = windows.iter().map(|window| (window.to_deg - window.from_deg).abs());
        Some(Self {
            reach_deg: REACH_STEPS * step_deg,
            steps: (widths.sum::<f64>() / (windows.len() as f64 * step_deg)).max(1.0),
            basis,
            coefficients,
            covariance,
            kept_out,
        })
    }

    /// First and last γ.
    pub fn range_deg(&self) -> [f64; 2] {
        self.basis.range_deg()
    }

    /// Light at γ.
    pub fn at(&self, gamma_deg: f64) -> f64 {
        self.basis.at(gamma_deg).value(&self.coefficients)
    }

    /// Its slope, per degree.
    pub fn slope(&self, gamma_deg: f64) -> f64 {
        self.basis.slope(gamma_deg).value(&self.coefficients)
    }

    /// Standard uncertainty at γ from the scatter of the conversions.
    pub fn u_noise(&self, gamma_deg: f64) -> f64 {
        self.basis.at(gamma_deg).variance(&self.covariance).sqrt()
    }

    /// Standard uncertainty at γ of the smoothing itself: what conversions that were kept out show beyond noise.
    pub fn u_smoothing(&self, gamma_deg: f64) -> f64 {
        let mean = |reach_deg: f64| {
            let (mut sum, mut total) = (0.0, 0.0);
            for (at, excess) in &self.kept_out {
                let weight = (-0.5 * ((at - gamma_deg) / reach_deg).powi(2)).exp();
                sum += weight * excess;
                total += weight;
            }
            if total > 0.0 { sum / total } else { 0.0 }
        };
        let [near, around] = [1.0 / 3.0, 1.0].map(|share| mean(share * self.reach_deg));
        self.steps * near.max(around).max(0.0).sqrt()
    }
}

/// Normal equations of the windows that are kept.
fn normal(
    count: usize,
    rows: &[Weights],
    windows: &[Window],
    kept: &dyn Fn(usize) -> bool,
) -> (DMatrix<f64>, DVector<f64>) {
    let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
    for (_, (row, window)) in rows.iter().zip(windows).enumerate().filter(|(k, _)| kept(*k)) {
        let weight = 1.0 / (window.sigma * window.sigma);
        for (i, a) in row.of.iter().enumerate() {
            right[row.first + i] += weight * a * window.value;
            for (j, b) in row.of.iter().enumerate() {
                matrix[(row.first + i, row.first + j)] += weight * a * b;
            }
        }
    }
    (matrix, right)
}

/// Squares of the second differences of the coefficients, each as heavy as conversions with the noise around would be:
/// bright light has more noise than dim light, and is to be smoothed no more for that. Where conversions are missing it
/// is as heavy as where there are some, so that what lies between follows from its neighbours.
fn penalty(weights: &DMatrix<f64>, basis: &Basis, windows: &[Window]) -> DMatrix<f64> {
    let count = weights.nrows();
    let precision = |k: usize| {
        let from = |window: &&Window| (window.middle_deg() - basis.centre_deg(k)).abs();
        let nearest = windows.iter().min_by(|a, b| from(a).total_cmp(&from(b)));
        nearest.map_or(0.0, |window| 1.0 / (window.sigma * window.sigma))
    };
    let precisions: Vec<f64> = (0..count).map(precision).collect();
    // How much of the conversions' weight a coefficient usually has.
    let mut shares: Vec<f64> = (0..count).map(|k| weights[(k, k)] / precisions[k]).collect();
    shares.sort_by(f64::total_cmp);
    let share = shares[count / 2].max(f64::MIN_POSITIVE);
    let mut matrix = DMatrix::zeros(count, count);
    for k in 1..count - 1 {
        let heavy = share * precisions[k - 1].min(precisions[k]).min(precisions[k + 1]);
        for (i, a) in [1.0, -2.0, 1.0].into_iter().enumerate() {
            for (j, b) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                matrix[(k - 1 + i, k - 1 + j)] += heavy * a * b;
            }
        }
    }
    matrix
}

fn solved(matrix: &DMatrix<f64>, penalty: &DMatrix<f64>, strength: f64) -> Option<Cholesky<f64, Dyn>> {
    (matrix + penalty * strength).cholesky()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(gamma: f64) -> f64 {
        100.0 * 0.5f64.powf((gamma / 7.5).powi(2))
    }

    /// Windows of 2.5° whose middles are 1.2° apart, without noise.
    fn blurred() -> Vec<Window> {
        (0..73)
            .map(|k| {
                let from_deg = -45.0 + 1.2 * f64::from(k);
                let to_deg = from_deg + 2.5;
                let parts = 200;
                let at = |part: i32| spot(from_deg + 2.5 * (f64::from(part) + 0.5) / f64::from(parts));
                let value = (0..parts).map(at).sum::<f64>() / f64::from(parts);
                Window {
                    from_deg,
                    to_deg,
                    value,
                    sigma: 0.02,
                }
            })
            .collect()
    }

    #[test]
    fn the_blur_of_the_windows_is_undone() {
        let gamma: Vec<f64> = (0..46).map(|k| -45.0 + 2.0 * f64::from(k)).collect();
        let windows = blurred();
        let curve = Curve::through(&gamma, &windows).unwrap();
        let at_peak = windows.iter().map(|window| window.value).fold(0.0, f64::max);
        assert!(at_peak < 99.5, "the windows blur: {at_peak}");
        for gamma in (0..80).map(|k| -40.0 + f64::from(k)) {
            assert!(
                (curve.at(gamma) - spot(gamma)).abs() < 0.1,
                "{gamma}: {} against {}",
                curve.at(gamma),
                spot(gamma)
            );
            assert!(curve.u_noise(gamma) < 0.1 && curve.u_smoothing(gamma) < 0.3);
        }
    }

    #[test]
    fn bright_light_is_not_smoothed_for_the_sake_of_dim_light() {
        let gamma: Vec<f64> = (0..121).map(|k| -180.0 + 3.0 * f64::from(k)).collect();
        let light = |gamma: f64| 100.0 * (-(gamma / 22.0).powi(2)).exp();
        let windows: Vec<Window> = (0..290)
            .map(|k| {
                let from_deg = -179.5 + 1.235 * f64::from(k);
                let parts = (0..20).map(|part| light(from_deg + (f64::from(part) + 0.5) / 20.0));
                let value = parts.sum::<f64>() / 20.0;
                let sigma = (8e-4 * value).hypot(8e-4);
                // Noise of this size, the same in every run.
                let noise = sigma * 1.4 * (f64::from(k) * 78.233).sin();
                Window {
                    from_deg,
                    to_deg: from_deg + 1.0,
                    value: value + noise,
                    sigma,
                }
            })
            .collect();
        let curve = Curve::through(&gamma, &windows).unwrap();
        for gamma in gamma {
            let error = (curve.at(gamma) - light(gamma)).abs();
            let u = curve.u_noise(gamma).hypot(curve.u_smoothing(gamma));
            assert!(error < 0.25 && error < 3.5 * u + 1e-3, "{gamma}: {error}, u = {u}");
        }
    }

    #[test]
    fn what_is_finer_than_the_grid_shows_in_the_uncertainty() {
        // An edge of 0.5° on a grid of 4°.
        let gamma: Vec<f64> = (0..24).map(|k| -46.0 + 4.0 * f64::from(k)).collect();
        let edge = |gamma: f64| if gamma < 0.3 { 100.0 } else { 0.0 };
        let windows: Vec<Window> = (0..75)
            .map(|k| {
                let from_deg = -45.5 + 1.2 * f64::from(k);
                Window {
                    from_deg,
                    to_deg: from_deg + 1.0,
                    value: (0..50)
                        .map(|part| edge(from_deg + (f64::from(part) + 0.5) / 50.0))
                        .sum::<f64>()
                        / 50.0,
                    sigma: 0.1,
                }
            })
            .collect();
        let curve = Curve::through(&gamma, &windows).unwrap();
        let error = (curve.at(2.0) - edge(2.0)).abs();
        assert!(error > 1.0, "{error}");
        let u = curve.u_noise(2.0).hypot(curve.u_smoothing(2.0));
        assert!(error < 3.0 * u, "{error} against {u}");
        assert!(curve.u_smoothing(-35.0) < 0.2 * curve.u_smoothing(2.0));
    }

    #[test]
    fn without_light_over_half_the_way_there_is_still_a_curve_and_it_says_so() {
        let gamma: Vec<f64> = (0..46).map(|k| -45.0 + 2.0 * f64::from(k)).collect();
        let mut windows = blurred();
        windows.retain(|window| window.from_deg < -5.0 || window.from_deg > 7.0);
        let curve = Curve::through(&gamma, &windows).unwrap();
        assert!(curve.u_noise(2.0) > 10.0 * curve.u_noise(-20.0));
        assert!(Curve::through(&gamma, &[]).is_none());
    }
}
