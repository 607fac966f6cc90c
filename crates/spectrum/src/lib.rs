//! Spectra, photopic weighting and colour.
