//! A smooth curve through given points that adds no maximum and no minimum which the points do not show.
//!
//! Between two points it is the cubic with their values and slopes (Hermite). A slope is the derivative of the
//! polynomial through the five nearest points (fourth order), limited as Huynh does ("Accurate monotone cubic
//! interpolation", SIAM J. Numer. Anal. 30, 1993, scheme M3): where the points rise or fall, the curve does, so that it
//! does not overshoot an edge. Fritsch and Carlson's limit sets the slope to zero at every largest point and so cuts
//! off a maximum between two points; here a maximum may lie between them, but only where the second differences at the
//! four points about it have one sign, that is, where the points show the maximum to be smooth. Huynh asks two points,
//! which lets the top of a step of two points bulge.

/// Points of the polynomial whose derivative is the slope.
const STENCIL: usize = 5;
/// Points beyond either end of a curve that its slopes and limits need.
pub(crate) const BEYOND: usize = 3;

/// The curve through points of rising `x`.
#[derive(Debug)]
pub(crate) struct Curve {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Curve {
    /// The curve through `x`, `y`. Points beyond the part that is asked for belong to it where the curve goes on there
    /// (around the circle, through a pole): at an end of the points a slope is one-sided.
    pub fn through(x: Vec<f64>, y: Vec<f64>) -> Self {
        let slope = slopes(&x, &y);
        Self { x, y, slope }
    }

    /// Value at `x` within the points; never below zero between two points that are not.
    pub fn at(&self, x: f64) -> f64 {
        let last = self.x.len() - 1;
        if x >= self.x[last] {
            return self.y[last];
        }
        let from = self.x.partition_point(|at| *at <= x).max(1) - 1;
        let width = self.x[from + 1] - self.x[from];
        let t = (x - self.x[from]) / width;
        let [low, high] = [self.y[from], self.y[from + 1]];
        let [a, b] = [self.slope[from], self.slope[from + 1]].map(|slope| slope * width);
        let rise = high - low;
        let value = low + t * (a + t * (3.0 * rise - 2.0 * a - b + t * (a + b - 2.0 * rise)));
        value.max(low.min(high).min(0.0))
    }

    /// Points `from` and `from + 1`.
    pub fn ends(&self, from: usize) -> [(f64, f64); 2] {
        [from, from + 1].map(|i| (self.x[i], self.y[i]))
    }

    /// Largest magnitude of the second derivative between points `from` and `from + 1`.
    pub fn largest_bend(&self, from: usize) -> f64 {
        let width = self.x[from + 1] - self.x[from];
        let secant = (self.y[from + 1] - self.y[from]) / width;
        let [a, b] = [self.slope[from], self.slope[from + 1]];
        let ends = [6.0 * secant - 4.0 * a - 2.0 * b, 2.0 * a + 4.0 * b - 6.0 * secant];
        ends[0].abs().max(ends[1].abs()) / width
    }
}

fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len();
    let secant: Vec<f64> = (1..count).map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1])).collect();
    // Half the second derivative at each inner point.
    let second = |i: usize| (secant[i] - secant[i - 1]) / (x[i + 1] - x[i - 1]);
    // The same for the interval that begins at point i: the least of the four points about it. Of an interval at an end
    // nothing is known beyond it, and it gets no maximum of its own.
    let within = |i: usize| {
        if i == 0 || i + 2 == count {
            return 0.0;
        }
        let about = i.saturating_sub(1).max(1)..=(i + 2).min(count - 2);
        about.map(second).reduce(minmod).unwrap_or(0.0)
    };
    (0..count)
        .map(|i| {
            let slope = derivative(x, y, i);
            if i == 0 || i == count - 1 {
                return minmod(slope, 3.0 * secant[i.saturating_sub(1)]);
            }
            let (before, after) = (secant[i - 1], secant[i]);
            // Slopes here of the parabolas over the intervals before and after.
            let from_before = before + within(i - 1) * (x[i] - x[i - 1]);
            let from_after = after - within(i) * (x[i + 1] - x[i]);
            let parabola = minmod(from_before, from_after);
            let largest = (3.0 * minmod(before, after).abs()).max(1.5 * parabola.abs());
            minmod(slope, parabola.signum() * largest)
        })
        .collect()
}

/// Derivative at point `i` of the polynomial through the nearest points.
fn derivative(x: &[f64], y: &[f64], i: usize) -> f64 {
    let count = STENCIL.min(x.len());
    let first = i.saturating_sub(count / 2).min(x.len() - count);
    let stencil = || (first..first + count).filter(move |k| *k != i);
    // Σ yₖ·Lₖ'(xᵢ), with L' of the point itself from the sum of all being zero.
    stencil()
        .map(|k| {
            let others = || stencil().filter(move |other| *other != k);
            let above: f64 = others().map(|other| x[i] - x[other]).product();
            let below: f64 = others().map(|other| x[k] - x[other]).product();
            (y[k] - y[i]) * above / (below * (x[k] - x[i]))
        })
        .sum()
}

/// The one nearer to zero of two of the same sign; zero where their signs differ.
fn minmod(a: f64, b: f64) -> f64 {
    if a * b <= 0.0 {
        0.0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn through(y: &[f64]) -> Curve {
        Curve::through((0..y.len()).map(|i| i as f64).collect(), y.to_vec())
    }

    /// Largest error of the curve through samples of `f`, `step` apart, over −1 to 1.
    fn error(step: f64, f: impl Fn(f64) -> f64) -> f64 {
        let x: Vec<f64> = (-10..=(2.0 / step) as i32 + 10)
            .map(|i| -1.0 + f64::from(i) * step)
            .collect();
        let y = x.iter().map(|x| f(*x)).collect();
        let curve = Curve::through(x, y);
        (0..2000)
            .map(|i| -1.0 + 1e-3 * f64::from(i))
            .map(|x| (curve.at(x) - f(x)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_maximum_between_two_points_keeps_the_order() {
        // The maximum at 0.3 lies between points at every step.
        let bell = |x: f64| (-(x - 0.3).powi(2)).exp();
        let (coarse, fine) = (error(0.2, bell), error(0.1, bell));
        assert!(coarse < 1e-4, "{coarse}");
        assert!(coarse / fine > 14.0, "fourth order: {coarse} {fine}");
    }

    #[test]
    fn edges_do_not_overshoot() {
        for y in [
            &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0][..],
            &[0.0, 0.0, 0.3, 1.0, 1.0, 1.0],
            &[0.0, 0.0, 1.0, 1.0, 0.0, 0.0],
            &[0.0, 0.0, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0],
            &[0.0, 0.0, 1.0, 0.0, 0.0],
            &[9.0, 9.1, 9.0, 9.1, 9.0, 0.0, 0.1, 0.0, 0.1],
        ] {
            let curve = through(y);
            for i in 0..y.len() - 1 {
                for t in 0..=20 {
                    let value = curve.at(i as f64 + f64::from(t) * 0.05);
                    let (low, high) = (y[i].min(y[i + 1]), y[i].max(y[i + 1]));
                    assert!(value >= low - 1e-15 && value <= high + 1e-15, "{y:?} at {i}: {value}");
                }
            }
        }
    }

    #[test]
    fn a_parabola_is_itself_wherever_its_points_lie() {
        let x = vec![0.0, 0.5, 0.8, 2.0, 2.5, 3.1, 4.0];
        let f = |x: f64| 5.0 + 3.0 * x - x * x;
        let curve = Curve::through(x.clone(), x.iter().map(|x| f(*x)).collect());
        for i in 0..=400 {
            let x = 0.01 * f64::from(i);
            assert!((curve.at(x) - f(x)).abs() < 1e-12, "{x}");
        }
        assert!((0..6).all(|i| (curve.largest_bend(i) - 2.0).abs() < 1e-9));
    }

    #[test]
    fn a_smooth_minimum_above_zero_stays_above_it() {
        let curve = through(&[4.1, 1.1, 0.01, 0.01, 1.1, 4.1]);
        assert_eq!(curve.at(2.5), 0.0);
    }

    proptest! {
        #[test]
        fn rises_where_the_points_rise(mut y in prop::collection::vec(0.0..10.0f64, 4..12)) {
            y.sort_by(f64::total_cmp);
            let curve = through(&y);
            let mut before = curve.at(0.0);
            for i in 1..=20 * (y.len() - 1) {
                let value = curve.at(0.05 * i as f64);
                prop_assert!(value >= before - 1e-12, "{value} after {before}");
                before = value;
            }
        }

        #[test]
        fn goes_through_its_points(y in prop::collection::vec(-5.0..10.0f64, 2..12)) {
            let curve = through(&y);
            for (i, y) in y.iter().enumerate() {
                prop_assert!((curve.at(i as f64) - y).abs() < 1e-14);
            }
        }
    }
}
