//! What can be wrong with the counts of a spectrum.

/// Counts that cannot be made into irradiance.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// The non-linearity polynomial has no meaning there.
    #[error("the non-linearity polynomial is {value} at {wavelength_nm} nm")]
    Polynomial {
        /// Wavelength of the pixel.
        wavelength_nm: f64,
        /// Value of the polynomial.
        value: f64,
    },
}
