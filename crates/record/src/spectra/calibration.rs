//! The calibration of a spectroradiometer that does not store its own.

use camino::Utf8Path;

use super::error::SpectrumError;

/// A calibration: spectral irradiance of one linear count per second over wavelength, `wavelength_nm,factor` in a CSV.
///
/// # Errors
/// [`SpectrumError::Content`] with line for a wrong header, numbers that are none, wavelengths that do not rise.
pub fn parse_calibration(file: &Utf8Path, text: &str) -> Result<Vec<(f64, f64)>, SpectrumError> {
    let fault = |line: usize, column: &str, message: String| SpectrumError::Content {
        file: file.to_owned(),
        line,
        column: column.to_owned(),
        message,
    };
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    match lines.next() {
        Some((_, header)) if header.trim() == "wavelength_nm,factor" => {}
        Some((place, _)) => {
            return Err(fault(
                place + 1,
                "wavelength_nm",
                "expected the header `wavelength_nm,factor`".to_owned(),
            ));
        }
        None => return Err(fault(1, "wavelength_nm", "the file is empty".to_owned())),
    }
    let mut table: Vec<(f64, f64)> = Vec::new();
    for (place, line) in lines {
        let (wavelength, factor) = line.split_once(',').unwrap_or((line, ""));
        let number = |column: &str, field: &str| match field.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(fault(place + 1, column, format!("`{field}` is no finite number"))),
        };
        let (wavelength, factor) = (number("wavelength_nm", wavelength)?, number("factor", factor)?);
        if table.last().is_some_and(|last| last.0 >= wavelength) {
            return Err(fault(
                place + 1,
                "wavelength_nm",
                "the wavelengths do not rise".to_owned(),
            ));
        }
        if !(100.0..=10_000.0).contains(&wavelength) {
            let message = format!("is {wavelength:e}, expected 100 to 10000 nm");
            return Err(fault(place + 1, "wavelength_nm", message));
        }
        // A count a second of a real instrument is far below a W/(m² nm).
        if !(0.0..=1e3).contains(&factor) {
            let message = format!("is {factor:e}, expected 0 to 1000 W/(m² nm) of one count a second");
            return Err(fault(place + 1, "factor", message));
        }
        table.push((wavelength, factor));
    }
    if table.len() < 2 {
        return Err(fault(1, "wavelength_nm", "needs at least two wavelengths".to_owned()));
    }
    if table.iter().all(|(_, factor)| *factor == 0.0) {
        return Err(fault(1, "factor", "is zero at every wavelength".to_owned()));
    }
    Ok(table)
}
