//! Sine and cosine without a call, so that loops over them stay in the vector units.

use std::f64::consts::{FRAC_PI_2, PI};

/// (1 − cos x)/x² and sin x/x as series in x².
pub(crate) const SERIES: [[f64; 9]; 2] = {
    let mut series = [[0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0; 9]];
    let mut k = 1;
    while k < 9 {
        let even = 2.0 * k as f64;
        series[0][k] = -series[0][k - 1] / ((even + 1.0) * (even + 2.0));
        series[1][k] = -series[1][k - 1] / (even * (even + 1.0));
        k += 1;
    }
    series
};

/// The same for angles up to 0.11.
const SHORT: [[f64; 5]; 2] = {
    let mut short = [[0.0; 5]; 2];
    let mut k = 0;
    while k < 5 {
        short[0][k] = SERIES[0][k];
        short[1][k] = SERIES[1][k];
        k += 1;
    }
    short
};

/// Sine and versine (1 − cos) by `series`: products alone, so that nothing divides in the vector units.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub(crate) fn sin_versine<const N: usize>(x: f64, series: &[[f64; N]; 2]) -> (f64, f64) {
    let y = x * x;
    let (mut versine, mut sin) = (series[0][N - 1], series[1][N - 1]);
    for k in (0..N - 1).rev() {
        versine = versine * y + series[0][k];
        sin = sin * y + series[1][k];
    }
    (x * sin, y * versine)
}

/// Sine and versine of an angle up to 0.11.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub(crate) fn small_sin_versine(x: f64) -> (f64, f64) {
    sin_versine(x, &SHORT)
}

/// Sine and cosine by quarters and series, without a call.
#[inline]
pub(crate) fn sin_cos(angle: f64) -> (f64, f64) {
    let quarter = (angle * (2.0 / PI)).round();
    let (sin, versine) = sin_versine(angle - quarter * FRAC_PI_2, &SERIES);
    let cos = 1.0 - versine;
    match (quarter as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_those_of_the_library() {
        for k in -400..=800 {
            let angle = 0.013 * f64::from(k);
            let ((s, c), (sin, cos)) = (sin_cos(angle), angle.sin_cos());
            assert!((s - sin).abs() < 2e-15 && (c - cos).abs() < 2e-15, "{angle}");
        }
    }
}
