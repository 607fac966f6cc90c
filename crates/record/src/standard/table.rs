//! The table of a certificate.

use camino::Utf8Path;

use super::SpectralIrradiance;
use crate::table::{ObservationError, Problem, Table};

/// A shape over the visible and its ends needs as many values.
const LEAST_ROWS: usize = 6;
/// The parts of an uncertainty may exceed the whole by what is lost in its last digits.
const ROUNDING_REL: f64 = 0.02;

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CertifiedRow {
    /// Wavelength in air.
    pub wavelength_nm: f64,
    /// Spectral irradiance.
    pub irradiance_w_m2_nm: f64,
    /// Its relative standard uncertainty (k = 1).
    pub u_rel: f64,
}

/// Reads the table of `stated`; lines that begin with `#` are comments.
///
/// # Errors
/// [`ObservationError`] with line.
pub(super) fn parse(
    file: &Utf8Path,
    text: &str,
    stated: &SpectralIrradiance,
) -> Result<Vec<CertifiedRow>, ObservationError> {
    let without_comments = |line| if str::starts_with(line, '#') { "" } else { line };
    let text: Vec<&str> = text.lines().map(without_comments).collect();
    let table = Table::parse(file, &text.join("\n"), false)?;
    let columns = table.columns_with(file, &["wavelength_nm", "irradiance_w_m2_nm", "u_rel"])?;
    let mut rows: Vec<CertifiedRow> = Vec::new();
    for fields in table.rows(file, &columns) {
        let wavelength_nm = fields.within("wavelength_nm", 200.0, 3000.0, "within 200 to 3000 nm")?;
        if let Some(last) = rows.last() {
            fields.above("wavelength_nm", last.wavelength_nm)?;
        }
        let irradiance_w_m2_nm = fields.positive("irradiance_w_m2_nm")?;
        fields.require(
            irradiance_w_m2_nm < 1e4,
            "irradiance_w_m2_nm",
            irradiance_w_m2_nm,
            "below 10⁴ W/(m² nm)",
        )?;
        let u_rel = fields.positive("u_rel")?;
        fields.require(u_rel <= 0.5, "u_rel", u_rel, "a fraction up to 0.5: 0.006 is 0.6 %")?;
        let whole = u_rel * (1.0 + ROUNDING_REL);
        fields.require(
            stated.u_scale_rel <= whole,
            "u_rel",
            u_rel,
            "at least u_scale_rel, which is a part of it",
        )?;
        rows.push(CertifiedRow {
            wavelength_nm,
            irradiance_w_m2_nm,
            u_rel,
        });
    }
    if rows.len() < LEAST_ROWS {
        return Err(ObservationError::new(file, None, Problem::NoRows("six wavelengths")));
    }
    Ok(rows)
}
