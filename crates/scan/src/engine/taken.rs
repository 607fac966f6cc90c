//! What a visit gives.

use isolux_record::Reading;
use isolux_record::spectra::SpectrumRecord;
use isolux_record::sweeps::SweepRecord;

/// What a visit gave, not yet recorded.
pub(super) enum Taken {
    Readings(Vec<Reading>),
    Spectrum(SpectrumRecord),
    Sweep(SweepRecord),
}
