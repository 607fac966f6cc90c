//! Quadrature rules on [0, 1].

/// Gauss–Legendre rules of 1 to 24 points, made once.
pub fn gauss(n: usize) -> &'static [(f64, f64)] {
    static RULES: std::sync::LazyLock<Vec<Vec<(f64, f64)>>> = std::sync::LazyLock::new(|| {
        let on_unit = |n| -> Vec<(f64, f64)> {
            let rule = isolux_model::gauss_legendre(n).into_iter();
            rule.map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight)).collect()
        };
        (1..=24).map(on_unit).collect()
    });
    &RULES[n.clamp(1, 24) - 1]
}

/// A Gauss–Kronrod pair on [−1, 1]: abscissae ≥ 0 with Kronrod weight and Gauss weight (0 where the Gauss rule has no
/// node).
pub type Pair = &'static [(f64, f64, f64)];

/// The pair G3–K7 (the Kronrod rule is exact to degree 11).
pub const K7: Pair = &[
    (0.0, 0.450_916_538_658_474, 0.888_888_888_888_889),
    (0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (
        0.774_596_669_241_483_4,
        0.268_488_089_868_333_4,
        0.555_555_555_555_555_6,
    ),
    (0.960_491_268_708_020_3, 0.104_656_226_026_467_3, 0.0),
];

/// The pair G7–K15.
pub const K15: Pair = &[
    (0.0, 0.209_482_141_084_727_8, 0.417_959_183_673_469_4),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
    (
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_67,
    ),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0),
    (
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_55,
        0.129_484_966_168_869_7,
    ),
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0),
];

/// An integral and the bound of its error that its rule gives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// The integral.
    pub value: f64,
    /// Absolute error that is not exceeded as far as the rule can tell.
    pub error: f64,
}

impl Estimate {
    /// Adds another integral and its bound.
    pub fn add(&mut self, other: Self) {
        self.value += other.value;
        self.error += other.error;
    }
}

/// Integrates `f` over the rising `panels` with `pair`, halving each until the rules agree to `relative` of the whole
/// or to `floor` (absolute), or `depth` halvings are used up.
pub fn adaptive(
    f: &mut dyn FnMut(f64) -> f64,
    pair: Pair,
    panels: &[f64],
    relative: f64,
    floor: f64,
    depth: u32,
) -> Estimate {
    let first: Vec<([f64; 2], Estimate)> = panels
        .windows(2)
        .filter(|window| window[1] - window[0] > 1e-13)
        .map(|window| ([window[0], window[1]], once(f, pair, window[0], window[1])))
        .collect();
    let whole: f64 = first.iter().map(|(_, found)| found.value).sum();
    let tolerance = floor.max(relative * whole.abs());
    let mut total = Estimate::default();
    for ([a, b], found) in first {
        total.add(refine(f, pair, a, b, found, tolerance, depth));
    }
    total
}

fn once(f: &mut dyn FnMut(f64) -> f64, pair: Pair, a: f64, b: f64) -> Estimate {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut kronrod, mut gauss) = (0.0, 0.0);
    for &(x, wk, wg) in pair {
        let y = if x == 0.0 {
            f(middle)
        } else {
            f(middle - half * x) + f(middle + half * x)
        };
        kronrod += wk * y;
        gauss += wg * y;
    }
    Estimate {
        value: kronrod * half,
        error: ((kronrod - gauss) * half).abs(),
    }
}

/// The Kronrod rule is far better than its distance from the Gauss rule: a distance of ten tolerances is taken as one,
/// and beyond that halving and agreeing is the witness.
fn refine(
    f: &mut dyn FnMut(f64) -> f64,
    pair: Pair,
    a: f64,
    b: f64,
    whole: Estimate,
    tolerance: f64,
    depth: u32,
) -> Estimate {
    if whole.error <= 10.0 * tolerance || depth == 0 {
        return Estimate {
            value: whole.value,
            error: 0.1 * whole.error,
        };
    }
    let middle = 0.5 * (a + b);
    let (left, right) = (once(f, pair, a, middle), once(f, pair, middle, b));
    let agreed = (left.value + right.value - whole.value).abs();
    if agreed <= tolerance {
        return Estimate {
            value: left.value + right.value,
            // Halves that agree by chance are betrayed by the pairs.
            error: agreed.max(0.02 * whole.error).max(0.1 * (left.error + right.error)),
        };
    }
    let left = refine(f, pair, a, middle, left, tolerance, depth - 1);
    let right = refine(f, pair, middle, b, right, tolerance, depth - 1);
    Estimate {
        value: left.value + right.value,
        error: left.error + right.error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_is_exact_to_its_degree() {
        for n in 1..=16 {
            let degree = 2 * n as i32 - 1;
            let sum: f64 = gauss(n).iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "{n} points: {sum}");
        }
    }

    #[test]
    fn kronrod_pairs_are_exact_to_their_degree() {
        for (pair, degree) in [(K7, 10), (K15, 22)] {
            let sum: f64 = pair
                .iter()
                .map(|&(x, w, _)| w * x.powi(degree) * if x == 0.0 { 1.0 } else { 2.0 })
                .sum();
            assert!(
                (sum - 2.0 / f64::from(degree + 1)).abs() < 1e-14,
                "degree {degree}: {sum}"
            );
        }
    }

    #[test]
    fn halving_finds_a_kink_and_bounds_its_error() {
        let exact = 0.5 * (0.3_f64.powi(2) + 0.7_f64.powi(2));
        let found = adaptive(&mut |x: f64| (x - 0.3).abs(), K7, &[0.0, 1.0], 1e-9, 0.0, 40);
        assert!(
            (found.value - exact).abs() <= found.error.max(1e-8),
            "{found:?} against {exact}"
        );
    }
}
