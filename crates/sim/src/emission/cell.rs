//! A cell of a refined grid, from which rays are drawn by inverting exact integrals.

use glam::DVec3;

use crate::random::unit32;
use crate::sines::small_sin_versine;

/// Newton's steps that bring γ to the last digit in any cell.
pub(crate) const MOST_STEPS: usize = 3;

/// A thousandth of the step between two random numbers of 32 bits, less a margin for places between those looked at.
const UNMOVED: f64 = 1e-13;

/// Numbers for which steps are counted.
const LOOKS: u32 = 16;

/// One cell of a refined grid.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    pub(super) part: u32,
    pub(super) gamma: f64,
    pub(crate) d_gamma: f64,
    pub(crate) sin_gamma: f64,
    pub(crate) cos_gamma: f64,
    pub(crate) sin_c: f64,
    pub(crate) cos_c: f64,
    pub(crate) d_c: f64,
    /// Intensities at (C, γ) corners: low-low, low-high γ, high-low, high-high.
    pub(crate) corner: [f64; 4],
    /// Mean over C at the lower and the upper γ, sine of the upper γ, and the integral of (linear × sine) between them.
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) end_sine: f64,
    pub(crate) whole: f64,
}

impl Cell {
    /// Direction for two numbers in (0, 1).
    #[inline]
    pub(super) fn direction(&self, u: f64, w: f64) -> DVec3 {
        let [ll, lh, hl, hh] = self.corner;
        let (t, sin_gamma, cos_gamma) = self.gamma(u);
        // C: linear between the values at this γ.
        let s = linear(w, ll + t * (lh - ll), hl + t * (hh - hl));
        let (sin, versine) = small_sin_versine(s * self.d_c);
        let cos = 1.0 - versine;
        let (sin_c, cos_c) = (self.sin_c * cos + self.cos_c * sin, self.cos_c * cos - self.sin_c * sin);
        DVec3::new(sin_gamma * cos_c, sin_gamma * sin_c, cos_gamma)
    }

    /// Inverts ∫ (low + (high − low)·t)·sin γ by Newton, kept in [0, 1], from the inverse of the linear density through
    /// its ends. Returns t, sin γ and cos γ.
    #[inline]
    fn gamma(&self, u: f64) -> (f64, f64, f64) {
        let mut t = self.start(u);
        for _ in 0..MOST_STEPS {
            t = self.newton(u, t);
        }
        let (sin, versine) = small_sin_versine(t * self.d_gamma);
        let cos = 1.0 - versine;
        (
            t,
            self.sin_gamma * cos + self.cos_gamma * sin,
            self.cos_gamma * cos - self.sin_gamma * sin,
        )
    }

    /// The inverse of the linear density through the ends of the cell.
    #[inline]
    fn start(&self, u: f64) -> f64 {
        linear(u, self.low * self.sin_gamma, self.high * self.end_sine)
    }

    #[inline]
    fn newton(&self, u: f64, t: f64) -> f64 {
        let (h, low, high) = (self.d_gamma, self.low, self.high);
        let slope = (high - low) / h;
        let (sin, versine) = small_sin_versine(t * h);
        let cos = 1.0 - versine;
        let sin_gamma = self.sin_gamma * cos + self.cos_gamma * sin;
        let cos_gamma = self.cos_gamma * cos - self.sin_gamma * sin;
        // cos γ0 − cos γ and sin γ − sin γ0 without cancellation.
        let fall = self.sin_gamma * sin + self.cos_gamma * versine;
        let rise = self.cos_gamma * sin - self.sin_gamma * versine;
        let value = low * fall + slope * (rise - t * h * cos_gamma);
        let density = (low + (high - low) * t) * sin_gamma * h;
        (t - (value - u * self.whole) / density.max(1e-300)).clamp(0.0, 1.0)
    }

    /// Newton's steps after which γ is as good as after [`MOST_STEPS`]: the next one moves it by less than
    /// [`UNMOVED`] of the cell's width.
    pub(crate) fn newton_steps(&self) -> usize {
        let looks = (0..LOOKS).map(|k| (f64::from(k) + 0.5) / f64::from(LOOKS));
        let looks = looks.chain([0, u32::MAX].map(unit32));
        looks.map(|u| self.steps_at(u)).max().unwrap_or(MOST_STEPS)
    }

    fn steps_at(&self, u: f64) -> usize {
        let mut t = self.start(u);
        for steps in 0..MOST_STEPS {
            let next = self.newton(u, t);
            if (next - t).abs() < UNMOVED {
                return steps;
            }
            t = next;
        }
        MOST_STEPS
    }
}

/// Inverse CDF on [0, 1] of a density linear from `a` to `b`.
#[inline]
fn linear(u: f64, a: f64, b: f64) -> f64 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    let sum = a + root;
    if sum > 0.0 {
        (u * (a + b) / sum).clamp(0.0, 1.0)
    } else {
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cell at `gamma` whose intensity rises from 1 to `high`.
    fn cell(gamma: f64, d_gamma: f64, high: f64) -> Cell {
        let (sin_gamma, cos_gamma) = gamma.sin_cos();
        let end = gamma + d_gamma;
        let rise = (high - 1.0) / d_gamma;
        // ∫ (1 + rise·(γ − γ0))·sin γ dγ
        let whole = cos_gamma - high * end.cos() + rise * (end.sin() - sin_gamma);
        Cell {
            part: 0,
            gamma,
            d_gamma,
            sin_gamma,
            cos_gamma,
            sin_c: 0.0,
            cos_c: 1.0,
            d_c: 0.1,
            corner: [1.0, high, 1.0, high],
            low: 1.0,
            high,
            end_sine: end.sin(),
            whole,
        }
    }

    #[test]
    fn steps_that_are_left_out_would_move_no_ray() {
        let mut counted = [0; MOST_STEPS + 1];
        for (gamma, d_gamma) in [
            (0.0, 0.05),
            (0.0, 1e-3),
            (1e-3, 1e-3),
            (0.03, 1e-3),
            (0.6, 0.01),
            (1.5, 0.05),
        ] {
            for high in [1.0, 0.999, 0.9, 0.2, 4.0] {
                let cell = cell(gamma, d_gamma, high);
                let steps = cell.newton_steps();
                counted[steps] += 1;
                for k in 0..=4000 {
                    let u = unit32((f64::from(k) / 4000.0 * f64::from(u32::MAX)) as u32);
                    let after = |steps: usize| (0..steps).fold(cell.start(u), |t, _| cell.newton(u, t));
                    let moved = (after(steps) - after(MOST_STEPS)).abs();
                    assert!(moved < 1e-12, "{gamma} {d_gamma} {high} {u}: {steps} steps, {moved:e}");
                }
            }
        }
        assert!(counted[1] > 0 && counted[2] > 0, "{counted:?}");
    }
}
