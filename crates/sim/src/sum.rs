//! Sums without loss.

/// Sums side by side, as the vector units take them.
const LANES: usize = 16;

/// The sum of `of` each value, as exact as [`Sum`]. The error of an addition comes from Knuth's two-sum, which asks for
/// no comparison.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
fn side_by_side(values: &[f64], of: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut lost) = ([0.0; LANES], [0.0; LANES]);
    let (runs, rest) = values.as_chunks::<LANES>();
    for run in runs {
        for lane in 0..LANES {
            let term = of(run[lane]);
            let next = sum[lane] + term;
            let before = next - term;
            lost[lane] += (sum[lane] - before) + (term - (next - before));
            sum[lane] = next;
        }
    }
    let mut total = Sum::default();
    let rest = rest.iter().map(|value| of(*value));
    sum.into_iter().chain(lost).chain(rest).for_each(|term| total.add(term));
    total.value()
}

/// The sum of `values`.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn of_values(values: &[f64]) -> f64 {
    side_by_side(values, |value| value)
}

/// The sum of the squares of what `values` are away from `middle`.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn of_squares(values: &[f64], middle: f64) -> f64 {
    side_by_side(values, |value| (value - middle) * (value - middle))
}

/// Neumaier's compensated sum: exact to rounding, whatever the order of magnitude of the terms.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sum {
    sum: f64,
    lost: f64,
}

impl Sum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        self.lost += if self.sum.abs() >= term.abs() {
            (self.sum - next) + term
        } else {
            (term - next) + self.sum
        };
        self.sum = next;
    }

    /// The sum.
    pub fn value(self) -> f64 {
        self.sum + self.lost
    }
}
