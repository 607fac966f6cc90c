//! What a person asks to be changed.

use isolux_photometry::Symmetry;

use crate::distribution::symmetry_name;
use crate::number::shortest;

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

impl Edit {
    /// A few words in ASCII, for formats with little room.
    pub(super) fn brief(&self) -> String {
        match self {
            Self::RotateC(deg) => format!("turned {} deg", shortest(*deg, 6)),
            Self::Symmetrize(symmetry) => format!("symmetry {}", symmetry_name(*symmetry)),
            Self::Resample(c_deg, gamma_deg) => format!("steps {c_deg} x {gamma_deg} deg"),
            Self::ScaleFlux(flux_lm) => format!("flux {} lm", shortest(*flux_lm, 6)),
            Self::Set(key, _) => format!("{} set", key.trim_start_matches("luminaire.")),
        }
    }
}
