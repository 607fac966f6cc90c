//! A strictly convex quadratic program with bounds: min ½ xᵀHx + gᵀx subject to |x| ≤ 1, where H is a narrow band
//! matrix.

/// A symmetric matrix with a band, its lower half by rows: `rows[i * (band + 1) + band + j - i]` for i − band ≤ j ≤ i.
#[derive(Debug, Clone)]
pub struct Band {
    size: usize,
    band: usize,
    rows: Vec<f64>,
}

impl Band {
    /// A matrix of zeros.
    pub fn zero(size: usize, band: usize) -> Self {
        Self {
            size,
            band,
            rows: vec![0.0; size * (band + 1)],
        }
    }

    /// Adds the square of one row of the roughness: the outer product of its terms.
    pub fn add_square(&mut self, terms: &[(usize, f64)]) {
        for &(i, a) in terms {
            for &(j, b) in terms {
                if j <= i {
                    let place = i * (self.band + 1) + self.band + j - i;
                    self.rows[place] += a * b;
                }
            }
        }
    }

    /// The product with a vector.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; self.size];
        for i in 0..self.size {
            let first = i.saturating_sub(self.band);
            let row = self.row(i);
            let mut sum = row[row.len() - 1] * x[i];
            for (value, j) in row[..row.len() - 1].iter().zip(first..i) {
                sum += value * x[j];
                y[j] += value * x[i];
            }
            y[i] += sum;
        }
        y
    }

    /// The solution of (H + diagonal) x = b by Cholesky's method; none where the matrix is not positive definite.
    fn solve_with(&self, diagonal: &[f64], b: &[f64]) -> Option<Vec<f64>> {
        let mut factor = self.clone();
        for (i, extra) in diagonal.iter().enumerate() {
            let first = i.saturating_sub(self.band);
            for j in first..=i {
                let from = first.max(j.saturating_sub(self.band));
                let dot: f64 = factor
                    .part(i, from, j)
                    .iter()
                    .zip(factor.part(j, from, j))
                    .map(|(a, b)| a * b)
                    .sum();
                let place = i * (self.band + 1) + self.band + j - i;
                let value = factor.rows[place] - dot;
                factor.rows[place] = if j < i {
                    value / factor.rows[self.place(j)]
                } else {
                    let pivot = value + extra;
                    if pivot.is_nan() || pivot <= 0.0 {
                        return None;
                    }
                    pivot.sqrt()
                };
            }
        }
        let mut x = b.to_vec();
        for i in 0..self.size {
            let first = i.saturating_sub(self.band);
            let row = factor.row(i);
            let known: f64 = row.iter().zip(&x[first..i]).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - known) / row[row.len() - 1];
        }
        for i in (0..self.size).rev() {
            let first = i.saturating_sub(self.band);
            let row = factor.row(i);
            x[i] /= row[row.len() - 1];
            let at = x[i];
            for (value, known) in row.iter().zip(&mut x[first..i]) {
                *known -= value * at;
            }
        }
        Some(x)
    }

    const fn place(&self, i: usize) -> usize {
        i * (self.band + 1) + self.band
    }

    /// Row i from its first column to its diagonal.
    fn row(&self, i: usize) -> &[f64] {
        self.part(i, i.saturating_sub(self.band), i + 1)
    }

    /// Columns `from..to` of row i.
    fn part(&self, i: usize, from: usize, to: usize) -> &[f64] {
        let shift = i * (self.band + 1) + self.band;
        &self.rows[shift + from - i..shift + to - i]
    }
}

/// Systems that are solved at most. Interior-point methods need 10 to 30, whatever the size.
const MOST_STEPS: usize = 80;

/// Solves the program to a gap of at most `gap`; none where that is not reached.
///
/// Mehrotra's predictor-corrector method (S. Mehrotra, SIAM J. Optim. 2, 575, 1992). The gap does not rest on the
/// method: with the gradient r at x, no point of the box has a value below f(x) − Σ (r·x + |r|), because the program is
/// convex.
pub fn solve(h: &Band, g: &[f64], gap: f64) -> Option<Vec<f64>> {
    let n = g.len();
    let mut x = vec![0.0; n];
    let start = g.iter().fold(1e-3_f64, |largest, g| largest.max(g.abs()));
    let (mut low, mut high) = (vec![start; n], vec![start; n]);
    for _ in 0..MOST_STEPS {
        let gradient: Vec<f64> = h.times(&x).iter().zip(g).map(|(hx, g)| hx + g).collect();
        let reached: f64 = gradient.iter().zip(&x).map(|(r, x)| r * x + r.abs()).sum();
        if reached <= gap {
            return Some(x);
        }
        let complement: f64 = (0..n).map(|i| low[i] * (1.0 + x[i]) + high[i] * (1.0 - x[i])).sum();
        let mean = complement / (2 * n) as f64;
        let diagonal: Vec<f64> = (0..n).map(|i| low[i] / (1.0 + x[i]) + high[i] / (1.0 - x[i])).collect();
        // Direction for a target of the products, with the second-order term of an earlier direction.
        let direction = |target: f64, second: Option<&Step>| -> Option<Step> {
            let product = |i: usize| {
                second.map_or((target, target), |step| {
                    (target - step.x[i] * step.low[i], target + step.x[i] * step.high[i])
                })
            };
            let right: Vec<f64> = (0..n)
                .map(|i| {
                    let (at_low, at_high) = product(i);
                    -gradient[i] + at_low / (1.0 + x[i]) - at_high / (1.0 - x[i])
                })
                .collect();
            let dx = h.solve_with(&diagonal, &right)?;
            let (mut d_low, mut d_high) = (vec![0.0; n], vec![0.0; n]);
            for i in 0..n {
                let (at_low, at_high) = product(i);
                d_low[i] = (at_low - low[i] * dx[i]) / (1.0 + x[i]) - low[i];
                d_high[i] = (at_high + high[i] * dx[i]) / (1.0 - x[i]) - high[i];
            }
            Some(Step {
                x: dx,
                low: d_low,
                high: d_high,
            })
        };
        let longest = |step: &Step| -> (f64, f64) {
            let (mut primal, mut dual) = (1.0_f64, 1.0_f64);
            for i in 0..n {
                if step.x[i] < 0.0 {
                    primal = primal.min(-(1.0 + x[i]) / step.x[i]);
                } else if step.x[i] > 0.0 {
                    primal = primal.min((1.0 - x[i]) / step.x[i]);
                }
                if step.low[i] < 0.0 {
                    dual = dual.min(-low[i] / step.low[i]);
                }
                if step.high[i] < 0.0 {
                    dual = dual.min(-high[i] / step.high[i]);
                }
            }
            (primal, dual)
        };
        let predictor = direction(0.0, None)?;
        let (primal, dual) = longest(&predictor);
        let after: f64 = (0..n)
            .map(|i| {
                let at = x[i] + primal * predictor.x[i];
                (low[i] + dual * predictor.low[i]) * (1.0 + at) + (high[i] + dual * predictor.high[i]) * (1.0 - at)
            })
            .sum();
        let centring = (after / complement).powi(3);
        let step = direction(centring * mean, Some(&predictor))?;
        let (primal, dual) = longest(&step);
        // One length for all: the dual residual then falls with every step, as H couples both sides.
        let length = (0.995 * primal.min(dual)).min(1.0);
        for i in 0..n {
            x[i] += length * step.x[i];
            low[i] += length * step.low[i];
            high[i] += length * step.high[i];
        }
    }
    None
}

struct Step {
    x: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long-known way that shares nothing with the method above: projected gradient, step by step to the end.
    fn projected_gradient(h: &Band, g: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; g.len()];
        for _ in 0..200_000 {
            let hx = h.times(&x);
            for i in 0..x.len() {
                x[i] = (x[i] - (hx[i] + g[i]) / 100.0_f64).clamp(-1.0, 1.0);
            }
        }
        x
    }

    #[test]
    fn finds_the_least_value_in_the_box() {
        // Third differences of 30 values that are rounded to whole numbers.
        let exact: Vec<f64> = (0..30).map(|i| 20.0 * (f64::from(i) * 0.3).sin()).collect();
        let shown: Vec<f64> = exact.iter().map(|value| value.round()).collect();
        let mut h = Band::zero(30, 3);
        let mut g = vec![0.0; 30];
        for first in 0..27 {
            let terms: Vec<(usize, f64)> = [-1.0, 3.0, -3.0, 1.0]
                .iter()
                .enumerate()
                .map(|(k, w)| (first + k, *w))
                .collect();
            let value: f64 = terms.iter().map(|(i, w)| w * shown[*i]).sum();
            h.add_square(&terms.iter().map(|(i, w)| (*i, 0.5 * w)).collect::<Vec<_>>());
            for (i, w) in &terms {
                g[*i] += 0.5 * w * value;
            }
        }
        for i in 0..30 {
            h.add_square(&[(i, 0.3)]);
        }
        let x = solve(&h, &g, 1e-12).unwrap();
        let expected = projected_gradient(&h, &g);
        assert!(
            expected.iter().any(|x| x.abs() == 1.0),
            "the box is not felt: {expected:?}"
        );
        for (x, expected) in x.iter().zip(&expected) {
            assert!((x - expected).abs() < 1e-5 && x.abs() <= 1.0, "{x} {expected}");
        }
    }
}
