//! Spectra as observations: `spectra.toml` beside `spectra.csv`.

use std::collections::HashMap;

use camino::{Utf8Path, Utf8PathBuf};
use serde::Deserialize;

use super::need::Need;
use crate::ReadingKind;
use crate::document::Fault;
use crate::document::bounds::within;
use crate::table::{ObservationError, Problem};
use crate::table::{Table, parse_toml, read_text, wrong_key};

/// One wavelength of one spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumRow {
    /// One-based line in the file.
    pub line: u64,
    /// The index as written: the number of the spectrum or of the row.
    pub index: i64,
    /// What the spectrometer could see.
    pub kind: ReadingKind,
    /// Wavelength as the instrument has it.
    pub wavelength_nm: f64,
    /// What was measured; present with [`Need::Values`].
    pub value: Option<f64>,
    /// Its standard uncertainty.
    pub u: Option<f64>,
}

/// Standard uncertainties of what all values of a file of spectra share: its table `[u]`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SharedErrors {
    /// Relative, of one factor on all values: calibration, distance, stray light.
    pub gain_rel: Option<f64>,
    /// Relative, of the ratios of 700 nm to 400 nm and of 550 nm to both.
    pub shape_rel: Option<f64>,
    /// Of the wavelength scale.
    pub wavelength_nm: Option<f64>,
}

/// Spectra of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectraSet {
    path: Utf8PathBuf,
    /// What was measured, in the file's words: `irradiance`, `counts`, `relative`, …
    pub quantity: String,
    /// Its unit in the file's words: `W/m2/nm`, …
    pub unit: String,
    /// From the light centre to the spectrometer.
    pub distance_mm: f64,
    /// Half-plane.
    pub c_deg: f64,
    /// Polar angle.
    pub gamma_deg: f64,
    /// The spectroradiometer and its calibration, in words that are the same whenever they are.
    pub instrument: Option<String>,
    /// Errors that all values share, where the file states them.
    pub shared: SharedErrors,
    header: Vec<String>,
    text: Vec<Vec<String>>,
    rows: Vec<SpectrumRow>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    quantity: String,
    unit: String,
    distance_mm: f64,
    #[serde(default)]
    c_deg: f64,
    #[serde(default)]
    gamma_deg: f64,
    instrument: Option<String>,
    #[serde(default)]
    u: SharedErrors,
}

impl Document {
    fn check(&self) -> Result<(), Fault> {
        within("distance_mm", self.distance_mm, 1e-3..=1e6, " mm")?;
        within("c_deg", self.c_deg, -720.0..=720.0, "°")?;
        within("gamma_deg", self.gamma_deg, -360.0..=360.0, "°")?;
        within("u.gain_rel", self.u.gain_rel, 0.0..=10.0, " (a fraction)")?;
        within("u.shape_rel", self.u.shape_rel, 0.0..=10.0, " (a fraction)")?;
        within("u.wavelength_nm", self.u.wavelength_nm, 0.0..=1000.0, " nm")
    }
}

impl SpectraSet {
    /// Spectra from `spectra.toml` and the CSV of the same name beside it.
    ///
    /// # Errors
    /// [`ObservationError`] with file and line.
    pub fn open(path: &Utf8Path, need: Need) -> Result<Self, ObservationError> {
        let text = read_text(path)?;
        let document: Document = parse_toml(path, &text)?;
        document.check().map_err(wrong_key(path, &text))?;
        let csv_path = path.with_extension("csv");
        let table = Table::parse(&csv_path, &read_text(&csv_path)?, false)?;
        let values: &[&'static str] = if need == Need::Values { &["value", "u"] } else { &[] };
        let columns = table.columns_with(&csv_path, &[&["index", "kind", "wavelength_nm"], values].concat())?;
        let mut rows = Vec::new();
        let mut seen: HashMap<(i64, ReadingKind, u64), u64> = HashMap::new();
        for fields in table.rows(&csv_path, &columns) {
            let kind = fields.word("kind")?;
            let index = fields
                .whole("index")?
                .ok_or_else(|| fields.error(Problem::Empty("index")))?;
            let wavelength_nm = fields.positive("wavelength_nm")?;
            if let Some(first) = seen.insert((index, kind, wavelength_nm.to_bits()), fields.line()) {
                let what = format!("{wavelength_nm} nm of spectrum {index}");
                return Err(fields.error(Problem::Duplicate { what, first }));
            }
            let (value, u) = match need {
                Need::Values => (Some(fields.number("value")?), Some(fields.positive("u")?)),
                Need::Coordinates => (None, None),
            };
            rows.push(SpectrumRow {
                line: fields.line(),
                index,
                kind,
                wavelength_nm,
                value,
                u,
            });
        }
        if rows.is_empty() {
            return Err(ObservationError::new(&csv_path, None, Problem::NoRows("spectra")));
        }
        let (header, text) = table.into_text();
        Ok(Self {
            path: csv_path,
            quantity: document.quantity,
            unit: document.unit,
            distance_mm: document.distance_mm,
            c_deg: document.c_deg,
            gamma_deg: document.gamma_deg,
            instrument: document.instrument,
            shared: document.u,
            header,
            text,
            rows,
        })
    }

    /// Whether its values are spectral irradiance: those of others have no level.
    pub fn is_irradiance(&self) -> bool {
        self.quantity.to_ascii_lowercase().contains("irradiance")
    }

    /// The CSV file.
    pub fn path(&self) -> &Utf8Path {
        &self.path
    }

    /// Column names as written.
    pub fn header(&self) -> &[String] {
        &self.header
    }

    /// The fields of each row as written, in the order of [`header`](Self::header).
    pub fn text(&self) -> &[Vec<String>] {
        &self.text
    }

    /// One row a wavelength, in file order.
    pub fn rows(&self) -> &[SpectrumRow] {
        &self.rows
    }
}
