//! The files that a station names for what its laboratory has found of the spectroradiometer.

use camino::Utf8Path;
use isolux_device::Identity;
use isolux_record::document::{DocumentError, Fault, read_text};
use isolux_record::spectra::{Linearity, Scatter, SpectralCorrections, WavelengthScale};
use isolux_record::station::Station;

use crate::Failure;

/// A file that cannot be used.
pub(super) enum Unusable {
    /// It is not there: the key that names it.
    Missing(Fault),
    /// It is wrong.
    Wrong(DocumentError),
}

/// Reads those that `station`, the file `beside`, names.
pub(super) fn load(station: &Station, beside: &Utf8Path) -> Result<SpectralCorrections, Unusable> {
    let mut corrections = SpectralCorrections::default();
    let Some(spectro) = station.spectroradiometer() else {
        return Ok(corrections);
    };
    let folder = beside.parent().unwrap_or(Utf8Path::new("."));
    let text = |key: &str, name: &str| {
        read_text(&folder.join(name)).map_err(|error| {
            let path = format!("spectroradiometer.{key}");
            Unusable::Missing(Fault::new(path, error.to_string()))
        })
    };
    if let Some(name) = &spectro.wavelengths {
        let scale = WavelengthScale::parse(&folder.join(name), &text("wavelengths", name)?);
        corrections.wavelengths = Some(scale.map_err(Unusable::Wrong)?);
    }
    if let Some(name) = &spectro.scatter {
        let scatter = Scatter::parse(&folder.join(name), &text("scatter", name)?);
        corrections.scatter = Some(scatter.map_err(Unusable::Wrong)?);
    }
    if let Some(name) = &spectro.linearity {
        let linearity = Linearity::parse(&folder.join(name), &text("linearity", name)?);
        corrections.linearity = Some(linearity.map_err(Unusable::Wrong)?);
    }
    Ok(corrections)
}

/// That they were made of the instrument that answers.
///
/// # Errors
/// Bad input (exit 2) with key, both names and what to do.
pub(super) fn of_this_one(corrections: &SpectralCorrections, found: &Identity) -> Result<(), Failure> {
    let name = format!("{} {}", found.model, found.serial.as_deref().unwrap_or(""));
    for (key, made) in corrections.made() {
        if made.instrument != name.trim() {
            return Err(Failure::bad_input(format!(
                "spectroradiometer.{key}: the file is of {}, {} at {} answers",
                made.instrument,
                name.trim(),
                found.target
            ))
            .help("name the file of this instrument, or remove the key"));
        }
    }
    Ok(())
}
