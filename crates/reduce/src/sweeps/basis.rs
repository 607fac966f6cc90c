//! Cubic B-splines over the γ of a plan (de Boor, A Practical Guide to Splines, chapter X).

use nalgebra::{DMatrix, DVector};

/// Points and weights of Gauss's rule on [0, 1]: exact for a cubic times what a window adds.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_7, 0.173_927_422_568_726_9),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
];

/// The splines with a knot at every γ.
#[derive(Debug, Clone)]
pub struct Basis {
    /// With the first and last one four times.
    knots: Vec<f64>,
}

/// Weights of the splines in a value: of `count` from `first` on.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    pub first: usize,
    pub of: Vec<f64>,
}

impl Basis {
    /// Over rising `gamma_deg`, at least four.
    pub fn over(gamma_deg: &[f64]) -> Self {
        let ends = |at: Option<&f64>| [at.copied().unwrap_or_default(); 3];
        let mut knots = ends(gamma_deg.first()).to_vec();
        knots.extend(gamma_deg);
        knots.extend(ends(gamma_deg.last()));
        Self { knots }
    }

    /// How many splines there are.
    pub fn len(&self) -> usize {
        self.knots.len() - 4
    }

    /// Where spline number `k` has its weight (Greville's abscissa), degrees.
    pub fn centre_deg(&self, k: usize) -> f64 {
        self.knots[k + 1..k + 4].iter().sum::<f64>() / 3.0
    }

    /// First and last γ.
    pub fn range_deg(&self) -> [f64; 2] {
        [self.knots[0], self.knots[self.knots.len() - 1]]
    }

    /// Weights of the value at `x`, held to the range.
    pub fn at(&self, x: f64) -> Weights {
        let (span, x) = self.span(x);
        let of = self.local(span, x, 3);
        Weights { first: span - 3, of }
    }

    /// Weights of the slope at `x`.
    pub fn slope(&self, x: f64) -> Weights {
        let (span, x) = self.span(x);
        let lower = self.local(span, x, 2);
        let knots = &self.knots;
        let mut of = vec![0.0; 4];
        for (k, value) in lower.iter().enumerate() {
            // Of the quadratic spline number span − 2 + k.
            let place = span - 2 + k;
            let share = 3.0 * value / (knots[place + 3] - knots[place]);
            of[k] -= share;
            of[k + 1] += share;
        }
        Weights { first: span - 3, of }
    }

    /// Weights of the mean from `a` to `b`.
    pub fn mean(&self, a: f64, b: f64) -> Weights {
        let (a, b) = (a.min(b), a.max(b));
        let (low, high) = (self.span(a).0, self.span(b).0);
        let first = low - 3;
        let mut of = vec![0.0; high - low + 4];
        let width = b - a;
        if width <= 0.0 {
            return self.at(a);
        }
        for span in low..=high {
            let (from, to) = (a.max(self.knots[span]), b.min(self.knots[span + 1]));
            if to <= from {
                continue;
            }
            for (place, weight) in GAUSS {
                let local = self.local(span, from + place * (to - from), 3);
                for (k, value) in local.iter().enumerate() {
                    of[span - 3 - first + k] += weight * (to - from) / width * value;
                }
            }
        }
        Weights { first, of }
    }

    fn span(&self, x: f64) -> (usize, f64) {
        let [low, high] = self.range_deg();
        let x = x.clamp(low, high);
        let last = self.knots.len() - 5;
        let span = self.knots.partition_point(|knot| *knot <= x).saturating_sub(1);
        (span.clamp(3, last), x)
    }

    /// The `degree` + 1 splines of that degree that are not zero between the knots `span` and `span` + 1.
    fn local(&self, span: usize, x: f64, degree: usize) -> Vec<f64> {
        let knots = &self.knots;
        let mut values = vec![1.0];
        for d in 1..=degree {
            let mut next = vec![0.0; d + 1];
            for (k, value) in values.iter().enumerate() {
                let (left, right) = (knots[span + 1 + k - d], knots[span + 1 + k]);
                let share = value / (right - left);
                next[k] += share * (right - x);
                next[k + 1] += share * (x - left);
            }
            values = next;
        }
        values
    }
}

impl Weights {
    /// The value that they make of `coefficients`.
    pub fn value(&self, coefficients: &DVector<f64>) -> f64 {
        self.of
            .iter()
            .enumerate()
            .map(|(k, weight)| weight * coefficients[self.first + k])
            .sum()
    }

    /// The variance that they make of a covariance.
    pub fn variance(&self, covariance: &DMatrix<f64>) -> f64 {
        let mut sum = 0.0;
        for (i, a) in self.of.iter().enumerate() {
            for (j, b) in self.of.iter().enumerate() {
                sum += a * b * covariance[(self.first + i, self.first + j)];
            }
        }
        sum.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_slopes_and_means_are_those_of_a_cubic() {
        let gamma = [-10.0, -8.0, -5.0, -4.0, 0.0, 1.0, 3.0, 7.0];
        let basis = Basis::over(&gamma);
        assert_eq!(basis.len(), gamma.len() + 2);
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.3 * x * x + 0.05 * x * x * x;
        let slope = |x: f64| -2.0 + 0.6 * x + 0.15 * x * x;
        let whole = |x: f64| x - x * x + 0.1 * x * x * x + 0.0125 * x * x * x * x;
        // Every cubic is a sum of the splines: its coefficients by collocation.
        let places: Vec<f64> = (0..basis.len())
            .map(|k| -10.0 + 17.0 * k as f64 / (basis.len() - 1) as f64)
            .collect();
        let mut matrix = DMatrix::zeros(basis.len(), basis.len());
        for (row, x) in places.iter().enumerate() {
            let weights = basis.at(*x);
            assert!((weights.of.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (k, weight) in weights.of.iter().enumerate() {
                matrix[(row, weights.first + k)] = *weight;
            }
        }
        let right = DVector::from_iterator(places.len(), places.iter().map(|x| cubic(*x)));
        let coefficients = matrix.lu().solve(&right).unwrap();
        for k in 0..60 {
            let x = -9.9 + 0.28 * f64::from(k);
            assert!((basis.at(x).value(&coefficients) - cubic(x)).abs() < 1e-9, "{x}");
            assert!((basis.slope(x).value(&coefficients) - slope(x)).abs() < 1e-9, "{x}");
            let end = (x + 2.7).min(7.0);
            let mean = (whole(end) - whole(x)) / (end - x);
            assert!((basis.mean(end, x).value(&coefficients) - mean).abs() < 1e-9, "{x}");
        }
    }
}
