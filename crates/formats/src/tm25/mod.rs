//! Ray files of IES TM-25-13: 36 288 bytes of header, tables and texts that the header announces, then little-endian
//! float32 rays. Section numbers in comments are those of the standard.
//!
//! [`Reader`] takes any stream and keeps one block of rays, whatever the file's size; [`Survey`] says what a file
//! holds; [`write()`] makes one.

mod error;
mod header;
mod reader;
mod survey;
mod write;

pub use error::Tm25Error;
pub use header::{Columns, Doubt, Header, Spectral, Table};
pub use reader::{Ray, Reader};
pub use survey::{Damage, Survey};
pub use write::{RaySet, write};
