//! What is tabulated along the half-planes of a grid.

use glam::DVec2;

use crate::polynomial::TERMS;
use crate::table::{IntensityTable, Search};

/// Powers of an antiderivative of [`TERMS`] terms times x.
pub(super) const POWERS: usize = TERMS + 2;

/// The integrals over γ of one table.
#[derive(Debug, Clone)]
pub(crate) struct Polar<'a> {
    pub(super) table: &'a IntensityTable,
    /// Rising; the table's lines and others between them, none beyond the horizon.
    pub(super) gamma: Vec<f64>,
    pub(super) search: Search,
    pub(super) strips: Vec<Strip>,
    /// `[half-plane * strips + strip]`.
    pub(super) runs: Vec<Run>,
    /// Whether directions beyond the last line are dark (else they are unknown here).
    pub(super) dark_beyond: bool,
    /// Squares of tan γ at the kinks below the horizon.
    pub(super) cones: Vec<f64>,
    /// Directions of the half-planes with a kink.
    pub(super) planes: Vec<DVec2>,
}

/// Antiderivatives from the start of a strip, in s from −1 to 1 across it: of sin γ, x·sin γ, tan γ sin γ,
/// x·tan γ sin γ, where x is the angle from the start. `[power][function]`.
#[derive(Debug, Clone)]
pub(super) struct Strip {
    pub(super) per_gamma: f64,
    pub(super) of: [[f64; 4]; POWERS],
}

/// A half-plane at the start of a strip: integrals from the first γ up to here, intensity and slope.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Run {
    pub(super) sine: f64,
    pub(super) tangent: f64,
    pub(super) cd: f64,
    pub(super) slope: f64,
}
