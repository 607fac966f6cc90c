//! TM-33-18 (ATLA S001, UNI 11733) and TM-33-23.
//!
//! After the published schema of ATLA S001 and that of the annex of TM-33-23 (root `IESTM33-22`); samples of TM-33-23
//! by others that name their elements otherwise are read too.

mod parts;
mod read;
mod schema_2023;
mod spectra;
mod table;
mod write;

pub use read::{looks_like, read};
pub use schema_2023::{Spectra, write_2023};
pub use spectra::{OfDirection, spectra};
pub use write::{Edition, write};

use crate::file_format::{self, FileFormat};
use crate::parsed::Format;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::TM33,
    title: "TM-33",
    extensions: &["xml", "tm33", "atla"],
    detect: |source| looks_like(source.head()),
    read: |source| file_format::distribution(read(source.bytes)),
    write_distribution: Some(write::encode),
    write_spectrum: None,
};
