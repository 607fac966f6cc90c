//! What a reader asks of a file of observations.

/// What a file of observations must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Where and when alone is enough: `predict`.
    Coordinates,
    /// Measured values with their uncertainties: `diagnose`.
    Values,
}
