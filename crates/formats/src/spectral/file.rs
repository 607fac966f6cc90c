//! A spectrum with what its file says beside the numbers.

use isolux_spectrum::{Quantities, Spectrum, SpectrumError};
use serde_json::{Map, Value, json};

/// The name of the document that `convert` writes as JSON.
pub(super) const FORMAT: &str = "isolux-spectrum/1";

/// A spectrum as a file holds it: wavelengths rising, in nm.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumFile {
    /// Wavelengths in nm, strictly rising.
    pub wavelength_nm: Vec<f64>,
    /// The first series, one value a wavelength.
    pub value: Vec<f64>,
    /// All series, the first among them, where the file has several; else empty.
    pub series: Vec<Series>,
    /// What the values are ("irradiance", "relative", …), where the file says so.
    pub quantity: Option<String>,
    /// Their unit, where the file says so.
    pub unit: Option<String>,
    /// Every other field that was read, and `encoding`.
    pub header: Map<String, Value>,
}

/// One of several columns over the same wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name in the file.
    pub name: String,
    /// One value a wavelength; none where the file leaves it blank.
    pub value: Vec<Option<f64>>,
}

impl SpectrumFile {
    /// A file with one series.
    pub fn new(spectrum: &Spectrum, quantity: Option<&str>, unit: Option<&str>) -> Self {
        Self {
            wavelength_nm: spectrum.wavelength_nm().to_vec(),
            value: spectrum.value().to_vec(),
            series: Vec::new(),
            quantity: quantity.map(str::to_owned),
            unit: unit.map(str::to_owned),
            header: Map::new(),
        }
    }

    /// The first series as a spectrum.
    ///
    /// # Errors
    /// [`SpectrumError`] for a hand-made file whose fields contradict each other; what was read never does.
    pub fn spectrum(&self) -> Result<Spectrum, SpectrumError> {
        Spectrum::new(self.wavelength_nm.clone(), self.value.clone())
    }

    /// The file with the series `name` as its values; none where there is no such series or it has blanks.
    pub fn with_series(&self, name: &str) -> Option<Self> {
        let series = self.series.iter().find(|series| series.name == name)?;
        Some(Self {
            value: series.value.iter().copied().collect::<Option<Vec<f64>>>()?,
            series: Vec::new(),
            ..self.clone()
        })
    }

    /// Colorimetric and radiometric quantities of the first series.
    pub fn quantities(&self) -> Option<Quantities> {
        self.spectrum().ok().map(|s| isolux_spectrum::quantities(&s))
    }

    /// The document `isolux-spectrum/1` that `convert` writes.
    pub fn to_json(&self) -> Value {
        let mut document = json!({
            "format": FORMAT,
            "wavelength_nm": self.wavelength_nm,
            "value": self.value,
            "quantity": self.quantity,
            "unit": self.unit,
            "header": self.header,
        });
        if !self.series.is_empty() {
            document["series"] = self
                .series
                .iter()
                .map(|series| json!({ "name": series.name, "value": series.value }))
                .collect();
        }
        document
    }
}
