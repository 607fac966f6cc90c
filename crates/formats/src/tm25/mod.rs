//! Ray files of IES TM-25-13: 36 288 bytes of header, tables and texts that the header announces, then little-endian
//! float32 rays. Section numbers in comments are those of the standard.
//!
//! [`Reader`] takes any stream and keeps one block of rays, whatever the file's size; [`Survey`] says what a file
//! holds; [`write()`] makes one.

mod doubts;
mod error;
mod header;
mod reader;
mod survey;
mod write;

pub use doubts::Doubt;
pub use error::Tm25Error;
pub use header::{Columns, Header, Spectral, Table};
pub use reader::{Ray, Reader};
pub use survey::{Damage, Survey};
pub use write::{RaySet, write};

use crate::file_format::{FileFormat, refused};
use crate::finding::Finding;
use crate::parsed::Format;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::TM25,
    title: "TM-25",
    extensions: &["tm25ray"],
    detect: |source| source.bytes.starts_with(b"TM25"),
    read: |_| {
        let message = "a ray file holds rays, neither a distribution nor a spectrum";
        let finding = Finding::error("tm25-rays", message).fix("`isolux inspect` says what it holds");
        refused(Some(Format::TM25), finding)
    },
    write_distribution: None,
    write_spectrum: None,
};
