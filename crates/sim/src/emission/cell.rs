//! A cell of a refined grid, from which rays are drawn by inverting exact integrals.

use glam::DVec3;

use crate::sines::small_sin_versine;

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
        let (h, low, high) = (self.d_gamma, self.low, self.high);
        let slope = (high - low) / h;
        let aim = u * self.whole;
        let mut t = linear(u, low * self.sin_gamma, high * self.end_sine);
        for _ in 0..3 {
            let (sin, versine) = small_sin_versine(t * h);
            let cos = 1.0 - versine;
            let sin_gamma = self.sin_gamma * cos + self.cos_gamma * sin;
            let cos_gamma = self.cos_gamma * cos - self.sin_gamma * sin;
            // cos γ0 − cos γ and sin γ − sin γ0 without cancellation.
            let fall = self.sin_gamma * sin + self.cos_gamma * versine;
            let rise = self.cos_gamma * sin - self.sin_gamma * versine;
            let value = low * fall + slope * (rise - t * h * cos_gamma);
            let density = (low + (high - low) * t) * sin_gamma * h;
            t = (t - (value - aim) / density.max(1e-300)).clamp(0.0, 1.0);
        }
        let (sin, versine) = small_sin_versine(t * h);
        let cos = 1.0 - versine;
        (
            t,
            self.sin_gamma * cos + self.cos_gamma * sin,
            self.cos_gamma * cos - self.sin_gamma * sin,
        )
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
