//! Spectral files.

use serde_json::{Map, Value};

use crate::Parsed;

/// A spectrum as a file holds it: wavelengths rising, in nm.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumFile {
    /// Wavelengths in nm, strictly rising.
    pub wavelength_nm: Vec<f64>,
    /// The first series, one value a wavelength.
    pub value: Vec<f64>,
    /// All series by name, where the file has several.
    pub series: Vec<(String, Vec<f64>)>,
    /// What the values are ("irradiance", "relative", …), where the file says so.
    pub quantity: Option<String>,
    /// Their unit, where the file says so.
    pub unit: Option<String>,
    /// Every other field that was read, and `encoding`.
    pub header: Map<String, Value>,
}

/// The spectrum in a file; none when its content and name are those of no spectral format.
pub fn read(_bytes: &[u8], _file_name: &str) -> Option<Parsed<SpectrumFile>> {
    None
}
