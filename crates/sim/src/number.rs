//! The two number formats in which maps are written, and the polynomial that fills a run of pixels in each.

/// Coefficients of a polynomial in s on [−1, 1], lowest power first.
pub(crate) const TERMS: usize = 8;

/// Pixels that a vector of f32 holds; runs are filled in whole vectors, a few pixels too far.
pub(crate) const RUN: usize = 16;

/// What a pixel's value is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Care {
    /// For itself.
    Itself,
    /// For a polynomial through it, which would show the rules' own errors as structure.
    Node,
    /// For a polynomial in single precision.
    Single,
}

/// A format in which maps are filled: `f64` is the reference, `f32` the form in which maps are stored.
pub trait Number: Format {}

impl Number for f64 {}
impl Number for f32 {}

/// What the solvers need of a format; nobody else's business.
pub trait Format: Copy + Default + Send + Sync + 'static {
    /// Rounds.
    fn of(value: f64) -> Self;
    /// The same value.
    fn wide(self) -> f64;
    /// Relative error of what is not proven smaller: a few roundings of the format.
    const ROUNDING: f64;
    /// Relative error that a map in this format aims at, roundings and kinks within a pixel not counted.
    const AIM: f64;
    /// Relative error that a kink within a pixel may make.
    const KINK: f64;
    /// Care that a polynomial's values need.
    const NODE: Care;
    /// Fills `out` with Σ c_k·s^k at s = first + step·(0, 1, 2 …).
    fn fill(coefficients: &[f64; TERMS], first: f64, step: f64, out: &mut [Self]);
}

impl Format for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn wide(self) -> f64 {
        self
    }
    const ROUNDING: f64 = 1e-14;
    const AIM: f64 = 1e-7;
    const KINK: f64 = 3e-8;
    const NODE: Care = Care::Node;
    fn fill(coefficients: &[f64; TERMS], first: f64, step: f64, out: &mut [Self]) {
        fill_wide(coefficients, first, step, out);
    }
}

impl Format for f32 {
    fn of(value: f64) -> Self {
        value as Self
    }
    fn wide(self) -> f64 {
        self.into()
    }
    const ROUNDING: f64 = 3e-7;
    const AIM: f64 = 3e-7;
    const KINK: f64 = 4e-7;
    const NODE: Care = Care::Single;
    fn fill(coefficients: &[f64; TERMS], first: f64, step: f64, out: &mut [Self]) {
        fill_single(&coefficients.map(|c| c as Self), first as Self, step as Self, out);
    }
}

macro_rules! filler {
    ($name:ident, $number:ty) => {
        #[multiversion::multiversion(targets(
            "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
            "x86_64+avx2+fma",
            "aarch64+neon"
        ))]
        fn $name(coefficients: &[$number; TERMS], first: $number, step: $number, out: &mut [$number]) {
            let [c0, c1, c2, c3, c4, c5, c6, c7] = *coefficients;
            // One rounding for two where the units have it; elsewhere it would be a call.
            let fused = multiversion::target::target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64"));
            let step_up = |sum: $number, s: $number, c: $number| if fused { sum.mul_add(s, c) } else { sum * s + c };
            let at = |s: $number| {
                let high = step_up(step_up(step_up(c7, s, c6), s, c5), s, c4);
                step_up(step_up(step_up(step_up(high, s, c3), s, c2), s, c1), s, c0)
            };
            let mut s = [first; RUN];
            for (lane, s) in s.iter_mut().enumerate() {
                *s += step * lane as $number;
            }
            let stride = step * RUN as $number;
            let whole = out.len() / RUN * RUN;
            let (body, rest) = out.split_at_mut(whole);
            let mut turn: $number = 0.0;
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
    };
}

filler!(fill_wide, f64);
filler!(fill_single, f32);

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
            let (mut wide, mut single) = (vec![0.0_f64; length], vec![0.0_f32; length]);
            f64::fill(&wanted, -0.9, 0.04, &mut wide);
            f32::fill(&wanted, -0.9, 0.04, &mut single);
            for (k, (wide, single)) in wide.iter().zip(&single).enumerate() {
                let truth = at(-0.9 + 0.04 * k as f64);
                assert!((wide / truth - 1.0).abs() < f64::ROUNDING, "{length} {k}");
                assert!((f64::from(*single) / truth - 1.0).abs() < f32::ROUNDING, "{length} {k}");
            }
        }
    }
}
