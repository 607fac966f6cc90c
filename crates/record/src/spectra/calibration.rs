//! The calibration of a spectroradiometer that does not store its own.

use camino::Utf8Path;

use crate::table::{ObservationError, Problem, Table};

/// Begin of the comment that says by what the standard of a calibration was corrected.
const CORRECTED_BY: &str = "# Corrected by: ";

/// By which corrections of the instrument the standard of this calibration was corrected, as
/// [`SpectralCorrections::name`](super::SpectralCorrections::name) has it; none where it says nothing.
pub fn corrected_by(text: &str) -> Option<&str> {
    let mut comments = text.lines().take_while(|line| line.starts_with('#'));
    Some(comments.find_map(|line| line.strip_prefix(CORRECTED_BY))?.trim())
}

/// A calibration: spectral irradiance of one linear count per second over wavelength, in the columns `wavelength_nm`
/// and `factor` of a CSV. A line that begins with `#` is a comment.
///
/// # Errors
/// [`ObservationError`] with line for a missing column, numbers that are none, wavelengths that do not rise.
pub fn parse_calibration(file: &Utf8Path, text: &str) -> Result<Vec<(f64, f64)>, ObservationError> {
    let without_comments = |line| if str::starts_with(line, '#') { "" } else { line };
    let text: Vec<&str> = text.lines().map(without_comments).collect();
    let table = Table::parse(file, &text.join("\n"), false)?;
    let columns = table.columns_with(file, &["wavelength_nm", "factor"])?;
    let mut curve: Vec<(f64, f64)> = Vec::new();
    for fields in table.rows(file, &columns) {
        let wavelength_nm = fields.within("wavelength_nm", 100.0, 10_000.0, "within 100 to 10000 nm")?;
        if let Some(last) = curve.last() {
            fields.above("wavelength_nm", last.0)?;
        }
        // A count a second of a real instrument is far below a W/(m² nm).
        let factor = fields.within("factor", 0.0, 1e3, "within 0 to 1000 W/(m² nm) of one count a second")?;
        curve.push((wavelength_nm, factor));
    }
    if curve.len() < 2 {
        return Err(ObservationError::new(file, None, Problem::NoRows("two wavelengths")));
    }
    if curve.iter().all(|(_, factor)| *factor == 0.0) {
        let problem = Problem::OutOfRange {
            column: "factor",
            found: 0.0,
            expected: "above zero at some wavelength",
        };
        return Err(ObservationError::new(file, None, problem));
    }
    Ok(curve)
}
