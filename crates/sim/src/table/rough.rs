//! What is known of the interpolant at one line of its grid.

/// How the interpolant runs at one line of constant γ and in the cells above it, the worst over C.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rough {
    /// Change of slope in γ, cd/rad.
    pub jump: f64,
    /// Slope in γ above the line, cd/rad.
    pub steep: f64,
    /// Slope in C over sin γ, cd/rad.
    pub turn: f64,
    /// Largest change of slope in C, and their sum round the circle, cd/rad.
    pub jump_c: f64,
    pub round: f64,
}
