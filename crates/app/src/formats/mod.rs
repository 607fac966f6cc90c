//! Photometric and spectral files: converted, inspected, drawn.

pub mod convert;
pub mod dropped;
pub mod inspect;
pub mod plot;

// Findings and reader options, for front ends.
pub use isolux_formats::spectral::SpectrumFile;
pub use isolux_formats::{Content, Distribution, Finding, Kind, Place, ReadOptions, Severity, WriteOptions};
pub use isolux_photometry::IntensityDistribution;
pub use isolux_report::content::pictures;
pub use isolux_spectrum::Spectrum;
