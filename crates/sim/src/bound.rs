//! What a map's errors do not exceed.

use crate::rules::Estimate;

/// What a map's errors do not exceed, as far as the rules can tell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bound {
    /// Mean over the map, lx.
    pub mean_lx: f64,
    /// Of any pixel, relative to itself.
    pub largest: f64,
    /// Of any pixel, lx.
    pub largest_lx: f64,
    /// Of any pixel, as a multiple of what the accuracy that was asked for allows.
    pub of_allowed: f64,
}

impl Bound {
    /// The bound of a map that was multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            mean_lx: factor * self.mean_lx,
            largest_lx: factor * self.largest_lx,
            ..self
        }
    }

    /// Adds `pixels` of at least `least` and at most `most` lx that are off by no more than `error` lx. While a map is
    /// filled, `mean_lx` holds their sum.
    pub(crate) fn add(&mut self, pixels: f64, error: f64, least: f64, allowed: Allowed) {
        self.mean_lx += pixels * error;
        self.largest_lx = self.largest_lx.max(error);
        if error > 0.0 {
            self.largest = self.largest.max(if least > 0.0 { error / least } else { 0.0 });
            self.of_allowed = self.of_allowed.max(error / allowed.at(least));
        }
    }

    /// One pixel.
    pub(crate) fn add_one(&mut self, one: Estimate, allowed: Allowed) {
        self.add(1.0, one.error, one.value.abs(), allowed);
    }

    /// The sum over `pixels` as their mean.
    pub(crate) fn over(self, pixels: usize) -> Self {
        Self {
            mean_lx: self.mean_lx / pixels as f64,
            ..self
        }
    }

    pub(crate) fn joined(self, other: Self) -> Self {
        Self {
            mean_lx: self.mean_lx + other.mean_lx,
            largest: self.largest.max(other.largest),
            largest_lx: self.largest_lx.max(other.largest_lx),
            of_allowed: self.of_allowed.max(other.of_allowed),
        }
    }
}

/// The error that a pixel may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Allowed {
    /// Share of the pixel.
    pub relative: f64,
    /// Light below which the error no longer falls with it, lx.
    pub dim_lx: f64,
}

impl Allowed {
    /// For a pixel of `value` lx, lx.
    pub fn at(self, value: f64) -> f64 {
        self.relative * value.abs().max(self.dim_lx).max(f64::MIN_POSITIVE)
    }
}
