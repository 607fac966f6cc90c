//! The variance that the light's own differences have, from the raw ones.

/// Half-planes to either side, and γ, over which the variance of the light is taken.
const AROUND: (usize, usize) = (3, 4);

/// Least variance of the light's differences, relative to that of rounding and scatter.
const LEAST_VARIANCE: f64 = 1e-3;

/// A difference as it was read.
#[derive(Debug, Clone, Copy, Default)]
pub struct Difference {
    pub value: f64,
    /// Variance that rounding and scatter give it; 0 where there is no difference or where it is exact.
    pub noise2: f64,
}

/// The variance of the light's differences at each of `differences` `[ic * gammas + ig]`: how much larger the squares
/// around it are than rounding and scatter make them, with `doubt` standard deviations of that estimate; 0 where there
/// is no difference.
pub fn variances(differences: &[Difference], gammas: usize, doubt: f64) -> Vec<f64> {
    let planes = differences.len() / gammas;
    // Squares in units of rounding and scatter, and how many, over the γ around each place.
    let mut along = vec![(0.0, 0.0); differences.len()];
    for (ic, row) in differences.chunks(gammas).enumerate() {
        for ig in 0..gammas {
            let near = &row[ig.saturating_sub(AROUND.1)..=(ig + AROUND.1).min(gammas - 1)];
            let sum = &mut along[ic * gammas + ig];
            for difference in near.iter().filter(|near| near.noise2 > 0.0) {
                sum.0 += difference.value.powi(2) / difference.noise2;
                sum.1 += 1.0;
            }
        }
    }
    let wide = AROUND.0.min((planes - 1) / 2);
    let mut variances = vec![0.0; differences.len()];
    for (ic, row) in variances.chunks_mut(gammas).enumerate() {
        for (ig, variance) in row.iter_mut().enumerate() {
            let noise2 = differences[ic * gammas + ig].noise2;
            if noise2 > 0.0 {
                let near = (0..=2 * wide).map(|d| along[(ic + planes + d - wide) % planes * gammas + ig]);
                let (sum, count) = near.fold((0.0, 0.0), |sum, near| (sum.0 + near.0, sum.1 + near.1));
                let excess: f64 = sum / count - 1.0 + doubt * f64::sqrt(2.0 / count);
                *variance = noise2 * excess.max(LEAST_VARIANCE);
            }
        }
    }
    variances
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_what_differences_have_beyond_their_noise() {
        let (planes, gammas) = (12, 20);
        let of = |ic: usize, ig: usize| Difference {
            value: if (5..8).contains(&ic) && ig > 12 { 30.0 } else { 2.0 },
            noise2: 4.0,
        };
        let differences: Vec<Difference> = (0..planes * gammas).map(|at| of(at / gammas, at % gammas)).collect();
        let found = variances(&differences, gammas, 0.0);
        // Far from it the squares are what noise makes them; in the middle of it all nine γ and three of seven planes.
        assert!((found[0] - 4.0 * LEAST_VARIANCE).abs() < 1e-12);
        let excess = (900.0 / 4.0 * 3.0 + 4.0) / 7.0 - 1.0;
        assert!((found[6 * gammas + 19] / 4.0 - excess).abs() < 1e-9);
        // In doubt it counts as larger by so many standard deviations of the mean of 63 squares.
        let doubtful = variances(&differences, gammas, 2.0);
        assert!((doubtful[10] / 4.0 - 2.0 * f64::sqrt(2.0 / 63.0)).abs() < 1e-9);
        let none = vec![Difference::default(); planes * gammas];
        assert!(variances(&none, gammas, 2.0).iter().all(|variance| *variance == 0.0));
    }
}
