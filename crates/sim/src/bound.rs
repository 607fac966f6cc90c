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
}

impl Bound {
    /// The bound of a map that was multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            mean_lx: factor * self.mean_lx,
            largest: self.largest,
            largest_lx: factor * self.largest_lx,
        }
    }

    /// Adds `pixels` that are off by `error` lx on the mean, by no more than `most` lx, and by no more than `relative` of
    /// themselves. While a map is filled, `mean_lx` holds their sum.
    pub(crate) fn add(&mut self, pixels: f64, error: f64, most: f64, relative: f64) {
        self.mean_lx += pixels * error;
        self.largest_lx = self.largest_lx.max(most);
        self.largest = self.largest.max(relative);
    }

    /// One pixel.
    pub(crate) fn add_one(&mut self, one: Estimate) {
        let relative = if one.value == 0.0 {
            0.0
        } else {
            one.error / one.value.abs()
        };
        self.add(1.0, one.error, one.error, relative);
    }

    pub(crate) fn joined(self, other: Self) -> Self {
        Self {
            mean_lx: self.mean_lx + other.mean_lx,
            largest: self.largest.max(other.largest),
            largest_lx: self.largest_lx.max(other.largest_lx),
        }
    }
}
