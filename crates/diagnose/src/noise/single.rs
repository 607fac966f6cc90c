//! Single readings: one that is further off than outliers are, and values that come again where noise would change
//! them.

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::{OUTLIERS, TIES, WIDEST};
use super::residuals::Residuals;
use super::series::{Series, robust};
use crate::table::{Coordinate, Light};

fn finding(kind: Kind, range: [f64; 2], sigma: f64, p_value: f64, note: String) -> Finding {
    let strongest = Strongest {
        half_square: 0.5 * sigma * sigma,
        place: 0,
    };
    Finding {
        p_value,
        ..Finding::new(kind, Coordinate::Index, range, strongest, note)
    }
}

/// The widest residuals, against outliers that count as noise: however rare they are, none is as wide as it likes.
pub(super) fn widest(series: &Series<'_>) -> Option<Finding> {
    let (share, width) = OUTLIERS;
    let one = robust(&series.plain);
    let mut off: Vec<(usize, f64)> = (0..series.len())
        .map(|i| (i, (series.plain[i] / one).abs()))
        .filter(|(_, off)| off.is_finite())
        .collect();
    off.sort_by(|a, b| b.1.total_cmp(&a.1));
    off.truncate(WIDEST);
    let chance = |(k, (_, off)): (usize, &(usize, f64))| {
        let expected = series.len() as f64 * share * libm::erfc(off / width / std::f64::consts::SQRT_2);
        as_many(k + 1, expected.max(f64::MIN_POSITIVE))
    };
    let (count, p_value) = off
        .iter()
        .enumerate()
        .map(|one| (one.0 + 1, chance(one)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    off.truncate(count);
    let numbers: Vec<f64> = off.iter().map(|(i, _)| series.index[*i]).collect();
    let range = numbers
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(*at), high.max(*at)]
        });
    let least = off.last()?.1;
    let note = match numbers.as_slice() {
        [at] => format!(
            "the reading of index {at} is off by {} times the scatter of the others",
            digits(least)
        ),
        several => format!(
            "{} readings (index {} … {}) are off by {} times the scatter of the others or more",
            several.len(),
            range[0],
            range[1],
            digits(least)
        ),
    };
    let sigma = off.iter().map(|(_, off)| off * off).sum::<f64>().sqrt();
    let p_value = (WIDEST as f64 * p_value).min(1.0);
    Some(finding(Kind::Outlier, range, sigma, p_value, note))
}

/// Lit readings that show the value of the one before, against how often noise and light let them: a meter that holds
/// its last value. None where no digit is known.
pub(super) fn repeated(residuals: &Residuals<'_>, series: &Series<'_>) -> Option<Finding> {
    let (mut expected, mut ties) = (0.0, Vec::new());
    for k in 1..series.len() {
        let (before, row) = (series.rows[k - 1], series.rows[k]);
        if !series.follows[k] || before.light != Light::Lit || row.light != Light::Lit || row.digit <= 0.0 {
            continue;
        }
        // A difference of two readings: normal about the change of the light.
        let sigma = residuals.scale * before.u.hypot(row.u);
        let change = (series.level[k] - series.level[k - 1]) / sigma;
        let density = (-0.5 * change * change).exp() / (sigma * std::f64::consts::TAU.sqrt());
        expected += (row.digit.max(before.digit) * density).min(1.0);
        if row.measured == before.measured {
            ties.push(k);
        }
    }
    let (&first, &last) = (ties.first()?, ties.last()?);
    if ties.len() < TIES {
        return None;
    }
    let p_value = as_many(ties.len(), expected.max(1e-9));
    let note = format!(
        "{} readings repeat the value before them, where noise and light let about {}",
        ties.len(),
        digits(expected)
    );
    let range = [series.index[first], series.index[last]];
    let sigma = (-2.0 * p_value.max(f64::MIN_POSITIVE).ln()).sqrt();
    let explained = ties.iter().map(|&k| series.plain[k].powi(2)).sum();
    Some(finding(Kind::Repeated, range, sigma, p_value, note).explaining(explained))
}

/// Probability of `count` or more where `expected` are (Poisson).
fn as_many(count: usize, expected: f64) -> f64 {
    let k = count as f64;
    let mut term = (k * expected.ln() - expected - libm::lgamma(k + 1.0)).exp();
    let (mut sum, mut next) = (0.0, k + 1.0);
    while term > 1e-12 * sum || next < expected {
        sum += term;
        term *= expected / next;
        next += 1.0;
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::as_many;

    #[test]
    fn poisson_tails_are_those_of_the_tables() {
        // 1 − e⁻³·(1 + 3 + 4.5); 1 − e^−0.1·(1 + 0.1).
        assert!((as_many(3, 3.0) - 0.576_809_918_873_156).abs() < 1e-12);
        assert!((as_many(2, 0.1) - 0.004_678_840_160_444_9).abs() < 1e-12);
        assert!((as_many(2, 400.0) - 1.0).abs() < 1e-9);
    }
}
