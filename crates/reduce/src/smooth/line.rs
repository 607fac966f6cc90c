//! The smooth values of one line of directions: a symmetric system with a narrow band.

/// Places between the directions that one difference joins, at most: four neighbours, on both sides of the line in
/// turn.
const BAND: usize = 6;

/// The sum Σ (D x)²/v + Σ ((x − y)/s)² of one line, to be made least.
///
/// The unknowns are z = (x − y)/s, so that the matrix is 1 and what the differences add to it; a direction without
/// uncertainty (s = 0) keeps its value.
pub struct Line {
    u: Vec<f64>,
    /// `lower[i][k]` is the entry (i, i − k).
    lower: Vec<[f64; BAND + 1]>,
    right: Vec<f64>,
}

impl Line {
    /// A line of directions with these standard uncertainties, neighbours close together, without any difference.
    pub fn new(u: Vec<f64>) -> Self {
        let mut one = [0.0; BAND + 1];
        one[0] = 1.0;
        Self {
            lower: vec![one; u.len()],
            right: vec![0.0; u.len()],
            u,
        }
    }

    /// Adds the square of a difference with these terms (direction and weight, a direction may stand twice), which has
    /// this value in y.
    pub fn add(&mut self, terms: [(usize, f64); 4], value: f64, variance: f64) {
        let sharpness = 1.0 / variance.sqrt();
        let scaled = terms.map(|(node, weight)| (node, weight * self.u[node] * sharpness));
        for (i, a) in scaled {
            self.right[i] -= a * value * sharpness;
            for (j, b) in scaled {
                if j <= i {
                    self.lower[i][i - j] += a * b;
                }
            }
        }
    }

    /// The changes x − y and the shares dx/dy that each direction's own y has in its x, by Cholesky's method; none where
    /// a number is too large or too small for it.
    pub fn solve(mut self) -> Option<(Vec<f64>, Vec<f64>)> {
        for i in 0..self.lower.len() {
            let reach = BAND.min(i);
            let mut row = self.lower[i];
            for k in (1..=reach).rev() {
                let column = &self.lower[i - k];
                let known: f64 = (k + 1..=reach).map(|p| row[p] * column[p - k]).sum();
                row[k] = (row[k] - known) / column[0];
            }
            let known: f64 = (1..=reach).map(|p| row[p] * row[p]).sum();
            let pivot = row[0] - known;
            if !(pivot.is_finite() && pivot > 0.0) {
                return None;
            }
            row[0] = pivot.sqrt();
            self.lower[i] = row;
            let known: f64 = (1..=reach).map(|k| row[k] * self.right[i - k]).sum();
            self.right[i] = (self.right[i] - known) / row[0];
        }
        for i in (0..self.lower.len()).rev() {
            let row = self.lower[i];
            self.right[i] /= row[0];
            let solved = self.right[i];
            for (k, entry) in row.iter().enumerate().take(BAND.min(i) + 1).skip(1) {
                self.right[i - k] -= entry * solved;
            }
        }
        let changes = self.right.iter().zip(&self.u).map(|(z, u)| z * u);
        Some((changes.collect(), self.diagonal_of_inverse()))
    }

    /// The diagonal of the inverse of L·Lᵀ, of which `lower` has the factor L: as far as the band reaches, each entry of
    /// the inverse follows from those below it (K. Takahashi, J. Fagan, M.-S. Chin, 8th PICA Conference, 63, 1973).
    fn diagonal_of_inverse(&self) -> Vec<f64> {
        let count = self.lower.len();
        // `inverse[i][k]` is the entry (i, i + k).
        let mut inverse = vec![[0.0; BAND + 1]; count];
        for i in (0..count).rev() {
            let reach = BAND.min(count - 1 - i);
            let pivot = self.lower[i][0];
            for k in (0..=reach).rev() {
                let below = (1..=reach).map(|p| {
                    let (near, far) = (p.min(k), p.max(k));
                    // The entry (i + p, i + k); that of the row itself is symmetric to one above.
                    let entry = if k == 0 {
                        inverse[i][p]
                    } else {
                        inverse[i + near][far - near]
                    };
                    self.lower[i + p][p] * entry
                });
                let own = if k == 0 { 1.0 / pivot } else { 0.0 };
                let below: f64 = below.sum();
                inverse[i][k] = (own - below) / pivot;
            }
        }
        inverse.iter().map(|row| row[0]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Third differences of 30 values that are rounded to whole numbers, against the same sum made least step by step
    /// (gradient), which shares nothing with the method above.
    #[test]
    fn finds_the_least_sum() {
        let shown: Vec<f64> = (0..30).map(|i| (20.0 * (f64::from(i) * 0.3).sin()).round()).collect();
        let u: Vec<f64> = (0..30).map(|i| 0.3 + 0.01 * f64::from(i)).collect();
        // Along a line whose two halves are neighbours at its start, as a meridian's are at a pole: 29 … 3 1 0 2 … 28.
        let order: Vec<usize> = (0..15).rev().map(|i| 2 * i + 1).chain((0..15).map(|i| 2 * i)).collect();
        let rows: Vec<[(usize, f64); 4]> = order
            .windows(4)
            .map(|four| [(four[0], -1.0), (four[1], 3.0), (four[2], -3.0), (four[3], 1.0)])
            .collect();
        let value =
            |x: &[f64], row: &[(usize, f64); 4]| row.iter().map(|(node, weight)| weight * x[*node]).sum::<f64>();
        let mut line = Line::new(u.clone());
        for row in &rows {
            line.add(*row, value(&shown, row), 0.7);
        }
        let (change, shares) = line.solve().unwrap();
        let mut x = shown.clone();
        for _ in 0..200_000 {
            let mut gradient: Vec<f64> = (0..30).map(|i| (x[i] - shown[i]) / u[i].powi(2)).collect();
            for row in &rows {
                let value = value(&x, row) / 0.7;
                for (node, weight) in row {
                    gradient[*node] += weight * value;
                }
            }
            x.iter_mut()
                .zip(gradient)
                .for_each(|(x, gradient)| *x -= 0.005 * gradient);
        }
        assert!(change.iter().any(|change| change.abs() > 0.1), "{change:?}");
        for i in [0, 7, 29] {
            let mut moved = shown.clone();
            moved[i] += 0.5;
            let mut line = Line::new(u.clone());
            for row in &rows {
                line.add(*row, value(&moved, row), 0.7);
            }
            let share = 1.0 + (line.solve().unwrap().0[i] - change[i]) / 0.5;
            assert!((share - shares[i]).abs() < 1e-9, "{i}: {share} {}", shares[i]);
        }
        for i in 0..30 {
            assert!(
                (shown[i] + change[i] - x[i]).abs() < 1e-9,
                "{i}: {} {}",
                change[i],
                x[i] - shown[i]
            );
        }
    }

    #[test]
    fn a_value_without_uncertainty_stays_and_one_beyond_all_numbers_is_said() {
        let row = [(0, -1.0), (1, 3.0), (2, -3.0), (3, 1.0)];
        let mut line = Line::new(vec![1.0, 0.0, 1.0, 1.0]);
        line.add(row, 5.0, 1.0);
        let (change, shares) = line.solve().unwrap();
        assert_eq!(shares[1], 1.0);
        assert!(change[1] == 0.0 && change[2] > 0.0, "{change:?}");
        let mut line = Line::new(vec![1e200; 4]);
        line.add(row, 5.0, 1e-9);
        assert_eq!(line.solve(), None);
    }
}
