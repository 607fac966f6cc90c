//! What was observed, whatever file it comes from: readings, sensor maps, spectra.
