//! TM-33-18 (ATLA S001, UNI 11733) and TM-33-23.
//!
//! Read after the published schema of ATLA S001 and after samples of TM-33-23 (root `IESTM33-22`); the standards
//! themselves are not free, so writing TM-33-23 is marked experimental.

mod read;
mod table;
mod write;

pub use read::{looks_like, read};
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
