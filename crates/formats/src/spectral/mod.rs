//! Spectral files: TM-27 `.spdx`, pairs `.spd`, CGATS `.sp`, Speos `.spectrum`, CSV and vendors' text.

mod axis;
mod cgats;
mod density;
pub(crate) mod embedded;
mod exponents;
mod jcamp;
mod json;
mod limits;
mod macam;
mod places;
mod points;
mod resample;
mod spdx;
mod speos;
mod table;
mod table_wide;
mod write;

use isolux_spectrum::{Quantities, Spectrum, SpectrumError};
use serde_json::{Map, Value, json};

use crate::finding::{self, Findings};
use crate::read::{Format, Kind, Parsed, ReadOptions};
use crate::text::Text;

pub use resample::Interpolation;
pub use write::write;

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
            "format": json::FORMAT,
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

/// The spectrum in a file; none when its content and name are those of no spectral format.
pub fn read(bytes: &[u8], file_name: &str, options: ReadOptions) -> Option<Parsed<SpectrumFile>> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    let mut parsed = read_text(&text, findings, file_name, options)?;
    if !json::looks_like(&text) {
        parsed.findings.extend(exponents::alone(&text));
        let limits = parsed.document.as_ref().map(|file| limits::check(&text, file));
        parsed.findings.extend(limits.unwrap_or_default());
        finding::sort(&mut parsed.findings);
    }
    Some(parsed)
}

fn read_text(
    text: &Text<'_>,
    findings: Findings,
    file_name: &str,
    options: ReadOptions,
) -> Option<Parsed<SpectrumFile>> {
    let extension = file_name
        .rsplit_once('.')
        .map_or(String::new(), |(_, end)| end.to_ascii_lowercase());
    let extension = extension.as_str();
    let is = |names: &[&str]| names.contains(&extension);
    if jcamp::looks_like(text) || is(&["jdx", "dx", "jcamp"]) {
        return Some(jcamp::read(text, findings));
    }
    if json::looks_like(text) {
        return Some(json::read(text, findings));
    }
    if spdx::looks_like(text) || extension == "spdx" {
        return Some(spdx::read(text, findings));
    }
    if text.content().trim_start().starts_with('<') {
        return None;
    }
    if speos::looks_like(text) || extension == "spectrum" {
        return Some(speos::read(text, findings));
    }
    if cgats::looks_like(text) {
        return Some(cgats::read(text, findings));
    }
    if macam::looks_like(text) {
        return Some(macam::read(text, findings));
    }
    if is(&["ldt", "eul", "ies", "xml", "gldf", "tm33", "atla"]) {
        return None;
    }
    let format = match extension {
        "spd" => Format::Spd,
        "sp" => Format::Sp,
        _ => Format::Csv,
    };
    let (parsed, rising) = table::read(text, findings, format, options.columns);
    // A text under another name must show that it is a spectrum, also a damaged one; EULUMDAT content is none.
    let named = is(&["spd", "sp", "csv", "tsv"]) || table::looks_like_vendor_text(text) || options.columns.is_some();
    (named || rising >= 8).then_some(parsed)
}

/// The outcome of a reader that gave up.
fn refused(format: Option<Format>, findings: Findings) -> Parsed<SpectrumFile> {
    Parsed {
        inner: None,
        format,
        kind: format.map(|_| Kind::Spectrum),
        document: None,
        findings: findings.into_vec(),
    }
}
