//! What a caller may choose of a pixel's computation.

/// Share of the map's largest pixel below which the error that an accuracy allows no longer falls with the pixel.
pub const DIM: f64 = 1e-3;

/// How a single pixel is computed, where that is to be checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// As in a map whose pixels are computed by themselves.
    Chosen,
    /// Flat emitters along their outline wherever that applies, no product rules.
    Outlines,
    /// Chords of pixel and emitter, or lines across the pixel for points.
    Chords,
}
