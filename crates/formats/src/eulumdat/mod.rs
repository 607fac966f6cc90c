//! EULUMDAT (`.ldt`), after the field descriptions of DIAL and AGI32.
//!
//! One value a line: 26 header lines, six lines a lamp set, ten direct ratios, Mc angles C, Ng angles γ, then the
//! stored planes × Ng intensities in cd/klm. Symmetry 3 stores C270 through C0 to C90 (planes 3·Mc/4+1 onwards), which
//! several programs write the other way round.

pub(crate) mod document;
mod expand;
pub(crate) mod fields;
mod from_distribution;
mod header;
mod json;
mod layout;
mod light;
mod read;
mod write;

pub use document::{Document, Header, LampSet, ROOM_INDICES};
pub use read::{looks_like, read, read_document};
pub use write::{rewrite, write, write_document};

use crate::file_format::{self, FileFormat};
use crate::parsed::Format;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::EULUMDAT,
    title: "EULUMDAT",
    extensions: &["ldt", "eul"],
    detect: |source| source.named(&["ldt", "eul"]) || looks_like(source.head()),
    read: |source| {
        let (text, findings) = source.decoded();
        file_format::distribution(read::read_text(text, findings, source.options))
    },
    write_distribution: Some(from_distribution::encode),
    write_spectrum: None,
};
