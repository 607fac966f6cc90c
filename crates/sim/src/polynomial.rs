//! The polynomials that fill runs of pixels, and how they are made from values at Chebyshev points.

/// Coefficients of a polynomial in s on [−1, 1], lowest power first.
pub(crate) const TERMS: usize = 8;

/// Pixels that are filled side by side.
const RUN: usize = 16;

/// Relative error that a polynomial's own arithmetic does not exceed.
pub(crate) const ROUNDING: f64 = 1e-14;

/// Fills `out` with Σ c_k·s^k at s = first + step·(0, 1, 2 …).
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn fill(coefficients: &[f64; TERMS], first: f64, step: f64, out: &mut [f64]) {
    let [c0, c1, c2, c3, c4, c5, c6, c7] = *coefficients;
    // One rounding for two where the units have it; elsewhere it would be a call.
    let fused = multiversion::target::target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64"));
    let step_up = |sum: f64, s: f64, c: f64| if fused { sum.mul_add(s, c) } else { sum * s + c };
    let at = |s: f64| {
        let high = step_up(step_up(step_up(c7, s, c6), s, c5), s, c4);
        step_up(step_up(step_up(step_up(high, s, c3), s, c2), s, c1), s, c0)
    };
    let mut s = [first; RUN];
    for (lane, s) in s.iter_mut().enumerate() {
        *s += step * lane as f64;
    }
    let stride = step * RUN as f64;
    let whole = out.len() / RUN * RUN;
    let (body, rest) = out.split_at_mut(whole);
    let mut turn = 0.0;
    for run in body.chunks_exact_mut(RUN) {
        for lane in 0..RUN {
            // From the start each time: steps that were added up would add up their roundings.
            let s = s[lane] + stride * turn;
            run[lane] = at(s);
        }
        turn += 1.0;
    }
    for (value, s) in rest.iter_mut().zip(s) {
        let s = s + stride * turn;
        *value = at(s);
    }
}

/// Chebyshev points on [−1, 1], rising.
pub(crate) fn nodes() -> [f64; TERMS] {
    std::array::from_fn(|k| -(std::f64::consts::PI * (k as f64 + 0.5) / TERMS as f64).cos())
}

/// From values at [`nodes`] to coefficients: `[power][node]`, and the last two Chebyshev coefficients.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// `[node][power]`.
    power: [[f64; TERMS]; TERMS],
    /// `[Chebyshev polynomial][node]` of the two highest.
    tail: [[f64; TERMS]; 2],
}

impl Fit {
    pub fn new() -> Self {
        let nodes = nodes();
        // Chebyshev coefficient a = 2/n Σ f(x_k) T_a(x_k), half of it for a = 0.
        let chebyshev: [[f64; TERMS]; TERMS] = std::array::from_fn(|a| {
            nodes.map(|x| {
                let weight = if a == 0 { 1.0 } else { 2.0 } / TERMS as f64;
                weight * (a as f64 * x.acos()).cos()
            })
        });
        let mut powers = [[0.0; TERMS]; TERMS];
        powers[0][0] = 1.0;
        powers[1][1] = 1.0;
        for a in 2..TERMS {
            for k in 0..TERMS {
                let raised = if k > 0 { 2.0 * powers[a - 1][k - 1] } else { 0.0 };
                powers[a][k] = raised - powers[a - 2][k];
            }
        }
        let power = std::array::from_fn(|node| {
            std::array::from_fn(|k| (0..TERMS).map(|a| powers[a][k] * chebyshev[a][node]).sum())
        });
        Self {
            power,
            tail: [chebyshev[TERMS - 2], chebyshev[TERMS - 1]],
        }
    }

    /// Coefficients of the polynomial through `values`, and the sum of its two highest Chebyshev coefficients.
    pub fn polynomial(&self, values: &[f64; TERMS]) -> ([f64; TERMS], f64) {
        let mut coefficients = [0.0; TERMS];
        let tail = transform(&self.power, &self.tail, values, &mut coefficients);
        (coefficients, tail)
    }
}

#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn transform(
    power: &[[f64; TERMS]; TERMS],
    tail: &[[f64; TERMS]; 2],
    values: &[f64; TERMS],
    out: &mut [f64; TERMS],
) -> f64 {
    let mut sum = [0.0; TERMS];
    for (row, value) in power.iter().zip(values) {
        for k in 0..TERMS {
            sum[k] += row[k] * value;
        }
    }
    *out = sum;
    let mut last = [0.0; 2];
    for (sum, row) in last.iter_mut().zip(tail) {
        for k in 0..TERMS {
            *sum += row[k] * values[k];
        }
    }
    last[0].abs() + last[1].abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_through_its_own_values_is_itself() {
        let wanted = [3.0, -1.0, 0.5, 0.25, -0.125, 0.3, 0.0, 0.07];
        let at = |s: f64| wanted.iter().rev().fold(0.0, |sum, c| sum * s + c);
        let (found, tail) = Fit::new().polynomial(&nodes().map(at));
        for (a, b) in wanted.iter().zip(found) {
            assert!((a - b).abs() < 1e-12, "{wanted:?} {found:?}");
        }
        // x⁷ holds 1/64 of T₇.
        assert!((tail - 0.07 / 64.0).abs() < 1e-14, "{tail}");
        for length in [1, 15, 16, 37] {
            let mut values = vec![0.0; length];
            fill(&wanted, -0.9, 0.04, &mut values);
            for (k, value) in values.iter().enumerate() {
                let truth = at(-0.9 + 0.04 * k as f64);
                assert!((value / truth - 1.0).abs() < ROUNDING, "{length} {k}");
            }
        }
    }
}
