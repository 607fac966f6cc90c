//! Texts of columns: pairs of wavelength and value, and tables.

use super::{table, write};
use crate::content::Content;
use crate::file_format::{FileFormat, Found, Source, distribution};
use crate::parsed::Format;
use crate::rotational;

pub(crate) const PAIRS: FileFormat = FileFormat {
    format: Format::SPD,
    title: "pairs of wavelength and value",
    extensions: &["spd"],
    detect: |source| !source.is_xml() && source.extension == "spd",
    read: |source| read(source, Format::SPD),
    write_distribution: None,
    write_spectrum: Some(write::pairs),
};

/// The last but one that a text is held against: its columns must show that it is a spectrum, or a distribution.
pub(crate) const TABLE: FileFormat = FileFormat {
    format: Format::CSV,
    title: "table",
    extensions: &["csv"],
    detect: |source| !source.is_xml() && !source.named(&["ldt", "eul"]),
    read: |source| {
        if rotational::looks_like(source.head()) {
            distribution(rotational::read(source.bytes))
        } else {
            read(source, Format::CSV)
        }
    },
    write_distribution: None,
    write_spectrum: Some(write::table),
};

/// A text of columns. Under a name of no spectral format it must show that it is a spectrum, also a damaged one.
pub(crate) fn read(source: &Source<'_>, format: Format) -> Found {
    let (text, findings) = source.decoded();
    let requested = source.options.columns;
    let (parsed, rising) = table::read(text, findings, format, requested);
    let named =
        source.named(&["spd", "sp", "csv", "tsv"]) || table::looks_like_vendor_text(text) || requested.is_some();
    if named || rising >= 8 {
        vec![parsed.map(Content::spectrum)]
    } else {
        Vec::new()
    }
}
