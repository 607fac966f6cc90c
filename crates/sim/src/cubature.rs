//! Adaptive integration over rectangles: the rule of Genz and Malik (degree 7 with an embedded degree 5, 17 points),
//! halving the worst cell until the sum of the bounds is met.
//!
//! A. C. Genz, A. A. Malik, J. Comput. Appl. Math. 6 (1980) 295–302.

use std::collections::BinaryHeap;

use crate::rules::Estimate;

/// When an integral is given up, with the bound that it has then.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorkLimit {
    /// Cells in all.
    pub cells: usize,
    /// Tolerances that the bound may still be away by when the first cells have been doubled.
    pub hopeless: f64,
}

/// Integral of `f` over the rectangles `starts` (from and to along each coordinate), until the bound is below
/// `relative` of it or below `floor` (absolute), or `work_limit` ends. `f` is given the rectangle's number too.
pub(crate) fn integral(
    starts: &[[[f64; 2]; 2]],
    relative: f64,
    floor: f64,
    work_limit: WorkLimit,
    mut f: impl FnMut(usize, [f64; 2]) -> f64,
) -> Estimate {
    let mut cells = BinaryHeap::new();
    let (mut bound, mut value) = (0.0, 0.0);
    for (start, [a, b]) in starts.iter().enumerate() {
        let middle = [0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])];
        let half = [0.5 * (a[1] - a[0]), 0.5 * (b[1] - b[0])];
        let cell = Cell::new(start, middle, half, &mut f);
        bound += cell.bound;
        value += cell.value;
        cells.push(cell);
    }
    let look = 2 * cells.len() + 100;
    while bound > floor.max(relative * value.abs()) && cells.len() < work_limit.cells {
        if cells.len() == look && bound > work_limit.hopeless * floor.max(relative * value.abs()) {
            break;
        }
        let Some(worst) = cells.pop() else { break };
        bound -= worst.bound;
        value -= worst.value;
        for cell in worst.halves(&mut f) {
            bound += cell.bound;
            value += cell.value;
            cells.push(cell);
        }
    }
    let mut total = Estimate::default();
    for cell in cells {
        total.value += cell.value;
        total.error += cell.bound;
    }
    total
}

/// Share of the distance between the rules of degree 5 and 3 that a bound is not below: across a kink, two rules can
/// agree by chance, three seldom do.
const NULL: f64 = 0.02;

/// A rectangle of the parameters and its integral.
#[derive(Debug, Clone, Copy)]
struct Cell {
    start: usize,
    middle: [f64; 2],
    half: [f64; 2],
    value: f64,
    /// Distance of the two rules.
    bound: f64,
    /// The side along which the integrand bends most.
    along: usize,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.bound.total_cmp(&other.bound).is_eq()
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl Cell {
    fn new(start: usize, middle: [f64; 2], half: [f64; 2], at: &mut impl FnMut(usize, [f64; 2]) -> f64) -> Self {
        // λ₂, λ₃ = λ₄, λ₅ and the weights of the paper for two dimensions.
        let (near, far, corner) = ((9.0_f64 / 70.0).sqrt(), 0.9_f64.sqrt(), (9.0_f64 / 19.0).sqrt());
        let seven = [
            -3816.0 / 19683.0,
            980.0 / 6561.0,
            1020.0 / 19683.0,
            200.0 / 19683.0,
            6859.0 / 78732.0,
        ];
        let five = [-971.0 / 729.0, 245.0 / 486.0, 65.0 / 1458.0, 25.0 / 729.0];
        let mut value = |s: f64, t: f64| at(start, [middle[0] + s * half[0], middle[1] + t * half[1]]);
        let centre = value(0.0, 0.0);
        let mut pair = |s: f64, t: f64| value(s, t) + value(-s, -t);
        let (near_s, near_t) = (pair(near, 0.0), pair(0.0, near));
        let (far_s, far_t) = (pair(far, 0.0), pair(0.0, far));
        let diagonal = pair(far, far) + pair(far, -far);
        let corners = pair(corner, corner) + pair(corner, -corner);
        // Fourth differences.
        let ratio = near * near / (far * far);
        let bend = |near: f64, far: f64| (near - 2.0 * centre - ratio * (far - 2.0 * centre)).abs();
        let (bend_s, bend_t) = (bend(near_s, far_s), bend(near_t, far_t));
        let area = 4.0 * half[0] * half[1];
        let sum = |w: &[f64]| w[0] * centre + w[1] * (near_s + near_t) + w[2] * (far_s + far_t) + w[3] * diagonal;
        let fifth = area * sum(&five);
        let third = area * (centre + (near_s + near_t - 4.0 * centre) * 35.0 / 27.0);
        let best = area * (sum(&seven) + seven[4] * corners);
        Self {
            start,
            middle,
            half,
            value: best,
            bound: (best - fifth).abs().max(NULL * (fifth - third).abs()),
            along: usize::from(bend_t > bend_s),
        }
    }

    fn halves(self, at: &mut impl FnMut(usize, [f64; 2]) -> f64) -> [Self; 2] {
        let mut half = self.half;
        half[self.along] *= 0.5;
        [-1.0, 1.0].map(|side| {
            let mut middle = self.middle;
            middle[self.along] += side * half[self.along];
            Self::new(self.start, middle, half, at)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: WorkLimit = WorkLimit {
        cells: 1000,
        hopeless: f64::INFINITY,
    };

    #[test]
    fn polynomials_are_exact() {
        // ∫ x⁴y² and ∫ x over [0, 2] × [0, 1].
        for (exact, power) in [(32.0 / 15.0, [4, 2]), (2.0, [1, 0])] {
            let found = integral(&[[[0.0, 2.0], [0.0, 1.0]]], 1e-6, 0.0, PATIENCE, |_, [x, y]| {
                x.powi(power[0]) * y.powi(power[1])
            });
            assert!(
                (found.value - exact).abs() < 1e-12,
                "{power:?}: {found:?} against {exact}"
            );
        }
    }

    #[test]
    fn a_kink_is_found_and_its_bound_holds() {
        // ∫ |x − 0.2| over a unit square round 0.
        let exact = 0.5 * (0.7_f64.powi(2) + 0.3_f64.powi(2));
        let found = integral(&[[[-0.5, 0.5], [-0.5, 0.5]]], 1e-7, 0.0, PATIENCE, |_, [x, _]| {
            (x - 0.2).abs()
        });
        assert!(
            found.error <= 1e-7 && (found.value - exact).abs() <= found.error,
            "{found:?}"
        );
    }
}
