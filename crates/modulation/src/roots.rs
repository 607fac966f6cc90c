//! Roots of a polynomial with real coefficients.

use rustfft::num_complex::Complex;

/// Rounds of the iteration; it converges quadratically from the fifth or so on.
const ROUNDS: usize = 200;

/// All roots of Σ cₙ sⁿ (`coefficients` from the constant term on, the last one not zero), by the simultaneous
/// iteration of Durand and Kerner.
pub(crate) fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    let degree = coefficients.len() - 1;
    let lead = coefficients[degree];
    let value = |s: Complex<f64>| {
        let powers = coefficients.iter().rev();
        powers.fold(Complex::new(0.0, 0.0), |sum, c| sum * s + c / lead)
    };
    // Fujiwara's bound of the largest root.
    let radius = coefficients[..degree]
        .iter()
        .enumerate()
        .map(|(power, c)| (c / lead).abs().powf(1.0 / (degree - power) as f64))
        .fold(f64::MIN_POSITIVE, f64::max);
    let mut roots: Vec<Complex<f64>> = (0..degree)
        .map(|k| Complex::from_polar(radius, 0.4 + std::f64::consts::TAU * k as f64 / degree as f64))
        .collect();
    for _ in 0..ROUNDS {
        for k in 0..degree {
            let own = roots[k];
            let others = roots.iter().enumerate().filter(|(other, _)| *other != k);
            let product = others.fold(Complex::new(1.0, 0.0), |product, (_, root)| product * (own - root));
            roots[k] = own - value(own) / product;
        }
    }
    roots
}

/// Real factors of Π (s − root): pairs of conjugate roots and pairs of real ones as [1, b, c] of s² + b s + c, one real
/// root left over as [0, 1, c] of s + c. `roots` of a polynomial with real coefficients.
pub(crate) fn factors(roots: &[Complex<f64>]) -> Vec<[f64; 3]> {
    let largest = roots.iter().map(|root| root.norm()).fold(0.0, f64::max);
    let real = |root: &&Complex<f64>| root.im.abs() <= 1e-9 * largest;
    let mut factors: Vec<[f64; 3]> = roots
        .iter()
        .filter(|root| !real(root) && root.im > 0.0)
        .map(|root| [1.0, -2.0 * root.re, root.norm_sqr()])
        .collect();
    let mut single: Vec<f64> = roots.iter().filter(real).map(|root| root.re).collect();
    single.sort_by(f64::total_cmp);
    for pair in single.chunks(2) {
        factors.push(match pair {
            [a, b] => [1.0, -(a + b), a * b],
            _ => [0.0, 1.0, -pair[0]],
        });
    }
    factors
}
