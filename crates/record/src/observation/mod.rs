//! What was observed, whatever file it comes from: readings, sensor maps, spectra.
//!
//! A file of observations is also a file of coordinates: with [`Need::Coordinates`] the measured values may be absent,
//! because `predict` asks only *where* something would be read.

mod image;
mod maps;
mod need;
mod pair;
mod readings;
mod spectra;

use camino::Utf8Path;

pub use crate::table::{ObservationError, Problem};
pub use maps::{Cell, MapPose, MapSet, MapUnit};
pub use need::Need;
pub use pair::OneOrTwo;
pub use readings::{ReadingCoordinates, ReadingRow, Readings};
pub use spectra::{SharedErrors, SpectraSet, SpectrumRow};

/// Observations of one kind from one place.
#[derive(Debug, Clone, PartialEq)]
pub enum Observations {
    /// Goniometer readings.
    Readings(Readings),
    /// Maps of a sensor.
    Maps(MapSet),
    /// Spectra.
    Spectra(SpectraSet),
}

/// Opens a run directory, a readings CSV, a `maps.toml` or a `spectra.toml`.
///
/// # Errors
/// [`ObservationError`] with file and line of the first thing that is wrong.
pub fn open(path: &Utf8Path, need: Need) -> Result<Observations, ObservationError> {
    if path.is_dir() {
        return Readings::open_run(path, need).map(Observations::Readings);
    }
    // The readings of a run by their own name are still those of the run.
    if path.file_name() == Some("readings.csv")
        && let Some(run) = path.parent()
        && run.join("run.toml").is_file()
    {
        return Readings::open_run(run, need).map(Observations::Readings);
    }
    match path.extension() {
        Some("toml") => {
            let text = crate::table::read_text(path)?;
            let document: toml::Table = crate::table::parse_toml(path, &text)?;
            if document.contains_key("map") || document.contains_key("sensor_mm") {
                MapSet::open(path, need).map(Observations::Maps)
            } else if document.contains_key("format") {
                Err(ObservationError::new(path, None, Problem::NotObservations))
            } else {
                SpectraSet::open(path, need).map(Observations::Spectra)
            }
        }
        _ => Readings::open(path, need).map(Observations::Readings),
    }
}
