//! What counting rays does to a map: standard errors, the maximum that noise alone makes, and what is left without it.

use rayon::prelude::*;

use crate::random::ln_factorial;
use crate::sum::{self, Sum};

/// A quantity with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Interval {
    /// Half of all runs lie below.
    pub median: f64,
    /// 2.5 % of all runs lie below.
    pub lo95: f64,
    /// 97.5 % of all runs lie below.
    pub hi95: f64,
}

/// Mean, extremes and spread of a map; sums are compensated, so that they are exact to rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Mean.
    pub mean: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Standard deviation, divided by n.
    pub std: f64,
}

/// Values of which one thread at a time makes a sum, so that no sum depends on the threads.
const RUN: usize = 1 << 15;

/// The moments of `values`; `None` for no values.
pub fn moments(values: &[f64]) -> Option<Moments> {
    let n = values.len() as f64;
    let whole = |of: &(dyn Fn(&[f64]) -> f64 + Sync)| {
        let runs: Vec<f64> = values.par_chunks(RUN).map(of).collect();
        sum(runs.into_iter())
    };
    let mean = whole(&sum::of_values) / n;
    let square = whole(&|run| sum::of_squares(run, mean));
    let (min, max) = extremes(values)?;
    Some(Moments {
        mean,
        min,
        max,
        std: (square / n).sqrt(),
    })
}

/// The smallest and the largest of `values`; `None` for no values.
fn extremes(values: &[f64]) -> Option<(f64, f64)> {
    let of = |run: &[f64]| {
        // Lanes side by side: maps have millions of pixels.
        let (mut lows, mut highs) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
        let (eights, rest) = run.as_chunks::<8>();
        for eight in eights {
            for lane in 0..8 {
                let value = eight[lane];
                lows[lane] = if value < lows[lane] { value } else { lows[lane] };
                highs[lane] = if value > highs[lane] { value } else { highs[lane] };
            }
        }
        let low = lows.iter().chain(rest).copied().fold(f64::INFINITY, f64::min);
        (low, highs.iter().chain(rest).copied().fold(f64::NEG_INFINITY, f64::max))
    };
    values
        .par_chunks(RUN)
        .map(of)
        .reduce_with(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Compensated sum (Neumaier), whatever the length.
pub fn sum(values: impl Iterator<Item = f64>) -> f64 {
    let mut total = Sum::default();
    for value in values {
        total.add(value);
    }
    total.value()
}

/// Upper limit at 95 % for the expected rays of a pixel that caught `count`: 3.0 for none, not 0 (exact Poisson limit
/// by bisection on P(n ≤ count) = 5 %).
pub fn upper_limit_95(count: u64) -> f64 {
    let k = count as f64;
    let (mut low, mut high) = (k, k + 5.0 * (k + 1.0).sqrt() + 5.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if poisson_cdf(k, middle) > 0.05 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// P(count ≤ k) for Poisson mean `lambda`.
pub fn poisson_cdf(k: f64, lambda: f64) -> f64 {
    if k < 0.0 {
        return 0.0;
    }
    if lambda <= 0.0 {
        return 1.0;
    }
    // Sum the smaller tail from its largest term.
    let upper = k > lambda;
    let mut i = if upper { k.floor() + 1.0 } else { k.floor() };
    let mut term = (i * lambda.ln() - lambda - ln_factorial(i)).exp();
    let mut total = 0.0;
    while term > 1e-18 * total && term > 0.0 {
        total += term;
        if upper {
            i += 1.0;
            term *= lambda / i;
        } else {
            if i == 0.0 {
                break;
            }
            term *= i / lambda;
            i -= 1.0;
        }
    }
    if upper { 1.0 - total } else { total.min(1.0) }
}

/// Bins of equal λ.
const BINS: usize = 1000;

/// The law of the largest count over pixels with the expected counts `lambda`: P(max ≤ k) = Π F(k; λ_i).
///
/// Pixels are gathered into bins of equal λ (to 1/1000 of the largest), which moves no quantile of a whole number.
pub fn largest_count(lambda: &[f64]) -> Interval {
    let top = extremes(lambda).map_or(0.0, |(_, top)| top);
    if top <= 0.0 {
        return Interval {
            median: 0.0,
            lo95: 0.0,
            hi95: 0.0,
        };
    }
    let bins = |run: &[f64]| {
        // Neighbours often fall into one bin: four sets, so that no sum waits for the one before it.
        let mut bins = vec![[(0_u64, 0.0); 4]; BINS + 1];
        for four in run.chunks(4) {
            for (set, &value) in four.iter().enumerate() {
                let bin = (value / top * BINS as f64).max(0.0) as usize;
                let (pixels, total) = &mut bins[bin.min(BINS)][set];
                *pixels += 1;
                *total += value;
            }
        }
        bins
    };
    let runs: Vec<_> = lambda.par_chunks(16 * RUN).map(bins).collect();
    let (mut pixels, mut mean) = (vec![0_u64; BINS + 1], vec![0.0; BINS + 1]);
    for run in runs {
        for (bin, sets) in run.into_iter().enumerate() {
            for (count, total) in sets {
                pixels[bin] += count;
                mean[bin] += total;
            }
        }
    }
    let ln_below = |k: f64| -> f64 {
        pixels
            .iter()
            .zip(&mean)
            .filter(|(n, _)| **n > 0)
            .map(|(&n, total)| n as f64 * ln_cdf(k, total / n as f64))
            .sum()
    };
    let quantile = |p: f64| {
        let (mut low, mut high) = (-1.0, (top + 12.0 * top.sqrt() + 30.0).floor());
        while high - low > 1.0 {
            let middle = (0.5 * (low + high)).floor();
            if ln_below(middle) >= p.ln() {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    };
    Interval {
        median: quantile(0.5),
        lo95: quantile(0.025),
        hi95: quantile(0.975),
    }
}

fn ln_cdf(k: f64, lambda: f64) -> f64 {
    let below = poisson_cdf(k, lambda);
    if below < 0.5 {
        below.ln()
    } else {
        (-(1.0 - below)).ln_1p()
    }
}

/// Spread without the rays' own noise: std² = std²_light + mean·(value of one ray). Zero where noise explains it all.
pub fn std_without_noise(moments: &Moments, value_per_ray: f64) -> f64 {
    (moments.std * moments.std - moments.mean * value_per_ray)
        .max(0.0)
        .sqrt()
}

/// Rays over the whole sphere that bring the standard error of a mean pixel down to `relative`.
pub fn rays_needed(relative: f64, share_on_sensor: f64, pixels: usize) -> f64 {
    pixels as f64 / (share_on_sensor * relative * relative)
}

/// Whether two means differ more than their noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Difference over its standard uncertainty.
    pub sigma: f64,
    /// Probability of such a difference or a larger one without any real one (two-sided, normal).
    pub p_value: f64,
}

/// Probability below which a difference counts as more than noise.
pub const SIGNIFICANT: f64 = 0.01;

/// Compares two means with standard errors. Equal means do not differ, however sure they are.
pub fn difference(a: (f64, f64), b: (f64, f64)) -> Difference {
    let sigma = if a.0 == b.0 { 0.0 } else { (a.0 - b.0) / a.1.hypot(b.1) };
    Difference {
        sigma,
        p_value: libm::erfc(sigma.abs() / std::f64::consts::SQRT_2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_pixel_is_not_known_to_zero_percent() {
        assert!((upper_limit_95(0) - 20.0_f64.ln()).abs() < 1e-9);
        assert!((upper_limit_95(3) - 7.753_656_5).abs() < 1e-5);
    }

    #[test]
    fn sums_hold_what_single_precision_loses() {
        // 4.2 million pixels of 5.24 and one part in 1e12 on top.
        let n = 1 << 22;
        let exact = f64::from(n) * 0.1 + 1e-9;
        let total = sum((0..n).map(|_| 0.1).chain([1e-9]));
        assert!((total - exact).abs() <= 1e-9 * 0.1, "{total} {exact}");
        let naive: f32 = (0..n).map(|_| 0.1_f32).sum();
        assert!(
            (f64::from(naive) / exact - 1.0).abs() > 0.01,
            "a float sum would not have shown it: {naive}"
        );
    }

    #[test]
    fn the_largest_of_many_counts_follows_its_law() {
        // Published case: 1.16 rays in each of 2048² pixels, one ray 4.59 W/m²: about 45.9 W/m², ten rays.
        let law = largest_count(&vec![1.157; 1 << 22]);
        assert!((9.0..=11.0).contains(&law.median), "{law:?}");
        let law = largest_count(&vec![1000.0; 1024]);
        assert!((law.median / 1000.0 - 1.10).abs() < 0.01, "{law:?}");
        let law = largest_count(&vec![1.0; 1024]);
        assert!((law.median - 5.4).abs() < 0.7, "{law:?}");
    }

    #[test]
    fn poisson_cdf_against_closed_forms() {
        assert!((poisson_cdf(0.0, 2.0) - (-2.0_f64).exp()).abs() < 1e-15);
        assert!((poisson_cdf(2.0, 2.0) - 5.0 * (-2.0_f64).exp()).abs() < 1e-14);
        assert!((poisson_cdf(150.0, 100.0) - 0.999_998_6).abs() < 2e-6);
    }

    #[test]
    fn five_sigma_is_five_sigma() {
        let verdict = difference((5.38, 0.0024), (5.25, 0.0024));
        assert!(verdict.sigma > 38.0 && verdict.p_value < 1e-300);
        assert_eq!(difference((1.0, 0.0), (1.0, 0.0)).p_value.round(), 1.0);
        assert!((difference((1.0, 0.1), (0.0, 0.5)).p_value - 0.0498).abs() < 1e-3);
    }
}
