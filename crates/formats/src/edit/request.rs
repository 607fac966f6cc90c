//! What a person asks to be changed.

use isolux_photometry::Symmetry;

/// One change that a person asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Edit {
    /// The light turned about the axis: what was at C is at C + this many degrees.
    RotateC(f64),
    /// Every direction gets the mean of its images under the symmetry.
    Symmetrize(Symmetry),
    /// Another grid: steps of C and of γ in degrees, bilinear between the directions of the file.
    Resample(f64, f64),
    /// Intensities, and the lamps' flux with them, scaled so that the integral over the sphere is this flux in lm.
    ScaleFlux(f64),
    /// One entry of the description, `luminaire.name`, and its new text.
    Set(String, String),
}
