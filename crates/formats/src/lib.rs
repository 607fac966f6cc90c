//! Photometric and spectral files: bytes to documents with findings, documents to exact bytes.
//!
//! A reader never refuses a good file and never accepts a damaged one in silence: what it assumed, and what it cannot
//! trust, stands in [`Finding`]s with line, column and the text itself. A damaged number is never dropped, shifted or
//! replaced. [`read_any`] recognises a format by its content, then by its name.

mod content;
mod describe;
pub mod distribution;
mod edit;
pub mod eulumdat;
pub mod finding;
mod gldf;
pub mod ies;
mod number;
mod parsed;
mod plausible;
mod quantities;
mod registry;
mod rotational;
pub mod spectral;
pub mod text;
pub mod tm25;
pub mod tm33;
mod unfinished;
mod write;
mod xml;

pub use content::Content;
pub use distribution::Distribution;
pub use edit::Edit;
pub use finding::{Also, Finding, Findings, Place, Severity};
pub use isolux_photometry::Symmetry;
pub use number::significant;
pub use parsed::{Beside, Format, Kind, LARGEST_FILE, Opened, Parsed, ReadOptions, Written};
pub use registry::{read_any, read_any_beside, read_any_with, write_distribution, write_spectrum};
pub use write::WriteOptions;
