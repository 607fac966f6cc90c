//! Photometric and spectral files: bytes to documents with findings, documents to exact bytes.
//!
//! A reader never refuses a good file and never accepts a damaged one in silence: what it assumed, and what it cannot
//! trust, stands in [`Finding`]s with line, column and the text itself. A damaged number is never dropped, shifted or
//! replaced. [`read_any`] recognises a format by its content, then by its name.

mod describe;
pub mod distribution;
mod edit;
pub mod eulumdat;
pub mod finding;
mod gldf;
pub mod ies;
mod number;
mod plausible;
mod quantities;
mod ratings;
mod read;
mod slip;
pub mod spectral;
pub mod text;
pub mod tm33;
mod xml;

pub use distribution::Distribution;
pub use edit::Edit;
pub use finding::{Finding, Findings, Place, Severity};
pub use isolux_photometry::Symmetry;
pub use number::significant;
pub use read::{
    Beside, Content, Format, Kind, LARGEST_FILE, Opened, Parsed, ReadOptions, read_any, read_any_beside, read_any_with,
};

/// Whether nothing but blanks stands there.
pub(crate) fn text_is_blank(text: &str) -> bool {
    matches!(number::read(text), Err(number::NotANumber::Blank))
}
