//! Mean, quantiles and the comparison of two samples.

/// Mean and standard deviation (n − 1).
pub(crate) fn middle_of(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (square / (n - 1.0).max(1.0)).sqrt())
}

/// The nearest of the sorted values.
pub(crate) fn quantile(values: &[f64], p: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * p).round() as usize]
}

/// Five significant digits.
pub(crate) fn significant(value: f64) -> String {
    let digits = 4 - value.abs().max(1e-12).log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 9) as usize)
}

/// Probability of a largest distance between two empirical laws as great as this one, if they are one law (asymptotic;
/// ties make it too large, never too small).
pub(crate) fn smirnov(a: &[f64], b: &[f64]) -> f64 {
    let below =
        |values: &[f64], at: f64| values.iter().filter(|value| **value <= at).count() as f64 / values.len() as f64;
    let distance = a
        .iter()
        .chain(b)
        .map(|at| (below(a, *at) - below(b, *at)).abs())
        .fold(0.0, f64::max);
    let n = (a.len() * b.len()) as f64 / (a.len() + b.len()) as f64;
    let x = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    let series: f64 = (1..100)
        .map(f64::from)
        .map(|k| (if k % 2.0 == 1.0 { 2.0 } else { -2.0 }) * (-2.0 * k * k * x * x).exp())
        .sum();
    if x < 0.2 { 1.0 } else { series.clamp(0.0, 1.0) }
}
