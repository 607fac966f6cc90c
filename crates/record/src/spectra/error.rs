//! What can be wrong with a spectrum or its calibration.

use camino::Utf8PathBuf;

/// A spectrum that cannot be read or made into irradiance.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// It cannot be read at all.
    #[error("{file}: {message}")]
    Io {
        /// The file.
        file: Utf8PathBuf,
        /// What the system said.
        message: String,
    },
    /// A line that cannot be.
    #[error("{file}:{line}: column {column}: {message}")]
    Content {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Name of the column.
        column: String,
        /// What is wrong.
        message: String,
    },
    /// The non-linearity polynomial has no meaning there.
    #[error("the non-linearity polynomial is {value} at {wavelength_nm} nm")]
    Polynomial {
        /// Wavelength of the pixel.
        wavelength_nm: f64,
        /// Value of the polynomial.
        value: f64,
    },
}
