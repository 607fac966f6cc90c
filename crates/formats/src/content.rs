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

impl Content {
    pub(crate) fn distribution(read: Distribution) -> Self {
        Self::Distribution(Box::new(read))
    }

    pub(crate) fn spectrum(read: SpectrumFile) -> Self {
        Self::Spectrum(Box::new(read))
    }
}
