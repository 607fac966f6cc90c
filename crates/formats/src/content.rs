//! A distribution or a spectrum: what one file or one part of a container holds.

use crate::distribution::Distribution;
use crate::spectral::file::SpectrumFile;

/// A distribution or a spectrum.
#[derive(Debug, Clone)]
pub enum Content {
    /// A luminous intensity distribution.
    Distribution(Box<Distribution>),
    /// A spectrum.
    Spectrum(Box<SpectrumFile>),
}
