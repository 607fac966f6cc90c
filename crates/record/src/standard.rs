//! `isolux-standard/1`: the certificate of a standard lamp.

mod document;
mod table;

use camino::{Utf8Path, Utf8PathBuf};

pub use self::document::{Certificate, Conditions, Illuminance, Lamp, SpectralIrradiance, StandardDocument};
pub use self::table::CertifiedRow;
use crate::disk::sha256;
use crate::document::{DocumentError, Fault, SourceText, bounds, read_text};
use crate::station::is_day;
use crate::table::ObservationError;

/// Value of `format` in a certificate.
pub const FORMAT: &str = "isolux-standard/1";

/// Second radiation constant hc/k, nm·K.
pub const C2_NM_K: f64 = 1.438_776_877e7;

/// Lowest and highest colour temperature of a lamp with a filament, K.
const FILAMENT_K: std::ops::RangeInclusive<f64> = 1500.0..=3600.0;
/// A relative standard uncertainty.
const U_REL: std::ops::RangeInclusive<f64> = 0.0..=0.5;

/// A valid certificate: what a laboratory states of a lamp, at one current.
#[derive(Debug, Clone, PartialEq)]
pub struct Standard {
    document: StandardDocument,
    rows: Vec<CertifiedRow>,
    sha256: String,
}

/// A certificate that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StandardError {
    /// The document.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// The table that it names.
    #[error(transparent)]
    Table(#[from] ObservationError),
}

impl Standard {
    /// Reads a certificate and the table that it names, which lies beside it.
    ///
    /// # Errors
    /// [`StandardError`] with file and line.
    pub fn load(file: &Utf8Path) -> Result<Self, StandardError> {
        let beside = |name: &str| {
            let path = beside(file, name);
            read_text(&path).map_err(|error| error.to_string())
        };
        Self::parse(file, &read_text(file)?, &beside)
    }

    /// Validates the text of a certificate; `beside` gives the text of the table that it names.
    ///
    /// # Errors
    /// [`StandardError`] with file and line.
    pub fn parse(
        file: &Utf8Path,
        text: &str,
        read: &dyn Fn(&str) -> Result<String, String>,
    ) -> Result<Self, StandardError> {
        let source = SourceText { file, text };
        let document: StandardDocument = source.parse(FORMAT)?;
        check(&document).map_err(|fault| source.locate(&fault))?;
        let mut hashed = text.as_bytes().to_vec();
        let rows = match &document.spectral_irradiance {
            Some(spectral) => {
                let name = &spectral.table;
                let fault = |why| Fault::new("spectral_irradiance.table", format!("names {name}: {why}"));
                let table = read(name).map_err(|why| source.locate(&fault(why)))?;
                hashed.extend(table.as_bytes());
                table::parse(&beside(file, name), &table, spectral)?
            }
            None => Vec::new(),
        };
        Ok(Self {
            document,
            rows,
            sha256: sha256(&hashed),
        })
    }

    /// What the laboratory states, without the table.
    pub fn document(&self) -> &StandardDocument {
        &self.document
    }

    /// The spectral irradiance with its table, which has at least six rows of rising wavelength.
    pub fn spectral(&self) -> Option<(&SpectralIrradiance, &[CertifiedRow])> {
        Some((self.document.spectral_irradiance.as_ref()?, &self.rows))
    }

    /// The illuminance.
    pub fn illuminance(&self) -> Option<&Illuminance> {
        self.document.illuminance.as_ref()
    }

    /// SHA-256 of the document and, behind it, of the table.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// The lamp and its certificate as a person names them.
    pub fn name(&self) -> String {
        let (lamp, certificate) = (&self.document.lamp, &self.document.certificate);
        format!(
            "{} {}, certificate {} of {}",
            lamp.designation, lamp.number, certificate.number, certificate.laboratory
        )
    }
}

fn beside(file: &Utf8Path, name: &str) -> Utf8PathBuf {
    file.parent().unwrap_or(Utf8Path::new("")).join(name)
}

fn check(document: &StandardDocument) -> Result<(), Fault> {
    let certificate = &document.certificate;
    let words = [
        ("lamp.designation", &document.lamp.designation),
        ("lamp.number", &document.lamp.number),
        ("certificate.number", &certificate.number),
        ("certificate.laboratory", &certificate.laboratory),
        ("conditions.reference_plane", &document.conditions.reference_plane),
    ];
    for (key, text) in words {
        // It stands in the comments of a table, and a line end would end one.
        if text.trim().is_empty() || text.chars().any(char::is_control) {
            return Err(Fault::new(
                key,
                "is empty or more than one line; write what the certificate says",
            ));
        }
    }
    for (key, day) in [("issued", &certificate.issued), ("expires", &certificate.expires)] {
        if !is_day(day) {
            let message = format!("`{day}` is no day, write YYYY-MM-DD");
            return Err(Fault::new(format!("certificate.{key}"), message));
        }
    }
    if certificate.expires < certificate.issued {
        let message = format!("{} is before the issue of {}", certificate.expires, certificate.issued);
        return Err(Fault::new("certificate.expires", message));
    }
    bounds::within("lamp.hours_run", document.lamp.hours_run, 0.0..=1e6, " h")?;
    let conditions = &document.conditions;
    let current_a = conditions.current_a;
    bounds::within("conditions.current_a", current_a, 1e-3..=1e3, " A")?;
    let most_a = 0.01 * current_a;
    let tolerance_a = conditions.current_tolerance_a;
    bounds::above(
        "conditions.current_tolerance_a",
        tolerance_a,
        0.0..=most_a,
        " A, 1 % of the current",
    )?;
    bounds::within("conditions.u_alignment_deg", conditions.u_alignment_deg, 0.0..=5.0, "°")?;
    if document.spectral_irradiance.is_none() && document.illuminance.is_none() {
        let message = "states neither [spectral_irradiance] nor [illuminance]; write what it certifies";
        return Err(Fault::new("certificate", message));
    }
    if let Some(spectral) = &document.spectral_irradiance {
        let key = |name: &str| format!("spectral_irradiance.{name}");
        bounds::within(&key("distance_mm"), spectral.distance_mm, 10.0..=1e5, " mm")?;
        let fraction = " (a fraction: 0.004 is 0.4 %)";
        bounds::within(&key("u_scale_rel"), spectral.u_scale_rel, U_REL, fraction)?;
        bounds::within(
            &key("u_temperature_rel"),
            spectral.u_temperature_rel,
            0.0..=0.05,
            fraction,
        )?;
    }
    if let Some(illuminance) = &document.illuminance {
        let key = |name: &str| format!("illuminance.{name}");
        bounds::within(&key("distance_mm"), illuminance.distance_mm, 10.0..=1e5, " mm")?;
        bounds::above(&key("illuminance_lx"), illuminance.illuminance_lx, 0.0..=1e7, " lx")?;
        bounds::above(&key("u_rel"), illuminance.u_rel, U_REL, " (a fraction)")?;
        let temperature_k = illuminance.colour_temperature_k;
        bounds::within(&key("colour_temperature_k"), temperature_k, FILAMENT_K, " K")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
