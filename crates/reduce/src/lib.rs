//! From the record of a scan to a luminous intensity distribution and a spectrum.
//!
//! Every correction is a switch, and every result keeps where its uncertainty comes from: an independent part per point and
//! named common parts (dark, drift, digit, distance, calibration) that act on all points at once. A result that is a weighted
//! sum of points (flux, maximum, mean irradiance) combines them with their correlation: independent parts add in squares,
//! a common part adds its weighted effects first and is squared then (GUM 5.2).

mod correction;
mod distribution;
mod drift;
mod error;
mod level;
mod point;
mod results;
mod spectral;
mod uncertainty;

pub use correction::{Correction, Switches, UnknownCorrection};
pub use distribution::{Closing, Reduction, reduce};
pub use drift::Drift;
pub use error::ReduceError;
pub use level::{Level, Levels};
pub use results::{Description, LuminaireFiles, ResultFile, budget, luminaire_files};
pub use spectral::{SpectralReduction, reduce_spectrum};
pub use uncertainty::{Combined, CommonPart, Part};
