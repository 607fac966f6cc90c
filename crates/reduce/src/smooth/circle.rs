//! The half-planes around a circle of equal γ: their third differences, and the orders that smoothing leaves alone.

use super::differences::third_difference;

/// Half-planes further apart than this do not tell of each other.
const LARGEST_STEP_C_DEG: f64 = 45.0;

/// Half-planes that a circle has at least, so that its differences are of different directions.
const LEAST_PLANES: usize = 6;

/// Half-planes for each order that is kept: a third difference is less than half of an amplitude then.
const PLANES_PER_ORDER: usize = 8;

/// What is the same on every circle.
pub struct CircleDifferences {
    /// The weights of the differences, of each half-plane and its three next.
    pub differences: Vec<[f64; 4]>,
    /// Orthonormal values over the half-planes that span the mean and the orders that are kept.
    kept: Vec<Vec<f64>>,
}

impl CircleDifferences {
    /// None where the half-planes are too few or too far apart.
    pub fn of(c_deg: &[f64]) -> Option<Self> {
        let planes = c_deg.len();
        let step = |ic: usize| (c_deg[(ic + 1) % planes] - c_deg[ic]).rem_euclid(360.0);
        if planes < LEAST_PLANES || (0..planes).any(|ic| step(ic) > LARGEST_STEP_C_DEG) {
            return None;
        }
        let weights = |ic: usize| {
            let at = |k: usize| c_deg[(ic + k) % planes] + 360.0 * ((ic + k) / planes) as f64;
            third_difference([at(0), at(1), at(2), at(3)])
        };
        let mut kept: Vec<Vec<f64>> = Vec::new();
        let orders = (1..=planes / PLANES_PER_ORDER).flat_map(|order| [(order, 0.0), (order, 90.0)]);
        for (order, turn_deg) in std::iter::once((0, 0.0)).chain(orders) {
            let wave = |c_deg: &f64| (order as f64 * c_deg - turn_deg).to_radians().cos();
            let mut values: Vec<f64> = c_deg.iter().map(wave).collect();
            for before in &kept {
                take_out(before, &mut values);
            }
            let norm = values.iter().map(|value| value * value).sum::<f64>().sqrt();
            for value in &mut values {
                *value /= norm;
            }
            kept.push(values);
        }
        Some(Self {
            differences: (0..planes).map(weights).collect(),
            kept,
        })
    }

    /// What `values`, one a half-plane, are beside the kept orders.
    pub fn without_kept(&self, mut values: Vec<f64>) -> Vec<f64> {
        for order in &self.kept {
            take_out(order, &mut values);
        }
        values
    }

    /// The share that a half-plane has in its kept orders.
    pub fn kept_share(&self) -> f64 {
        self.kept.len() as f64 / self.differences.len() as f64
    }
}

/// Takes from `values` their part along `unit`, of length 1.
fn take_out(unit: &[f64], values: &mut [f64]) {
    let part: f64 = unit.iter().zip(values.iter()).map(|(unit, value)| unit * value).sum();
    for (value, unit) in values.iter_mut().zip(unit) {
        *value -= part * unit;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_needs_neighbours() {
        let even = |planes: usize| -> Vec<f64> { (0..planes).map(|k| 360.0 * k as f64 / planes as f64).collect() };
        assert!(CircleDifferences::of(&even(4)).is_none());
        assert!(CircleDifferences::of(&[0.0, 10.0, 20.0, 30.0, 40.0, 50.0]).is_none());
        for weights in CircleDifferences::of(&even(24)).unwrap().differences {
            assert!((weights[3] - 1.0).abs() < 1e-12, "{weights:?}");
        }
    }

    #[test]
    fn the_lowest_orders_are_kept_and_higher_ones_are_left() {
        // Half-planes unevenly apart.
        let c_deg: Vec<f64> = (0..24).map(|k| 15.0 * f64::from(k) + f64::from(k % 3)).collect();
        let circle = CircleDifferences::of(&c_deg).unwrap();
        let wave = |order: f64| -> Vec<f64> {
            let at = |c_deg: &f64| 2.0 + (order * c_deg + 20.0).to_radians().cos();
            c_deg.iter().map(at).collect()
        };
        for order in [1.0, 2.0, 3.0] {
            let fine = circle.without_kept(wave(order));
            assert!(fine.iter().all(|value| value.abs() < 1e-12), "{order}: {fine:?}");
        }
        let fine = circle.without_kept(wave(7.0));
        assert!(fine.iter().map(|value| value * value).sum::<f64>() > 11.0, "{fine:?}");
        assert!((circle.kept_share() - 7.0 / 24.0).abs() < 1e-12);
    }
}
