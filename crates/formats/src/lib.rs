#![doc = include_str!("../README.md")]
//!
//! A reader never refuses a good file and never accepts a damaged one in silence: what it assumed, and what it cannot
//! trust, stands in [`Finding`]s with line, column and the text itself. A damaged number is never dropped, shifted or
//! replaced. [`read_any`] recognises a format by its content, then by its name.

mod content;
pub mod distribution;
mod edit;
pub mod eulumdat;
mod file_format;
pub mod finding;
mod formats;
mod gldf;
pub mod ies;
mod json;
mod lost;
mod luminaire;
mod number;
mod options;
mod parsed;
mod plausible;
mod quantities;
mod rotational;
pub mod spectral;
pub mod text;
pub mod tm25;
pub mod tm33;
mod unfinished;
mod xml;

pub use content::Content;
pub use distribution::Distribution;
pub use edit::Edit;
pub use file_format::FileFormat;
pub use finding::{Also, Finding, Findings, Place, Severity};
pub use formats::{
    distribution_targets, formats, read_any, read_any_beside, read_any_with, spectrum_targets, write_distribution,
    write_spectrum,
};
pub use isolux_photometry::Symmetry;
pub use options::{Beside, Opened, ReadOptions, WriteOptions};
pub use parsed::{Format, Kind, LARGEST_FILE, Parsed, Written};
pub use quantities::{GlareTable, LuminanceTable, Outdoor, Quantities, SCREEN_LIMITS_CD_M2, SCREEN_LUMINANCE_CD_M2};
