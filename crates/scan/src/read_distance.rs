//! The distance at which a block is read.

use isolux_record::Station;
use isolux_record::plan::{Block, Instrument};

/// The distance at which a block is read.
pub fn distance_mm(station: &Station, block: &Block) -> f64 {
    block
        .distance_mm
        .unwrap_or_else(|| own_distance_mm(station, block.instrument))
}

/// That of the station for an instrument.
pub(crate) fn own_distance_mm(station: &Station, instrument: Instrument) -> f64 {
    match (instrument, station.spectroradiometer()) {
        (Instrument::Spectroradiometer, Some(spectro)) => spectro.distance_mm,
        _ => station.bench().distance_mm,
    }
}
