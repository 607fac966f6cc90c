//! What a person may decide for readers and writers, and how a reader opens another file.

use crate::finding::Finding;
use crate::ies::photometry::Photometry;
use crate::parsed::Format;

/// What a person may decide for a reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ReadOptions {
    /// A table is a spectrum: the columns, counted from 1, of its wavelengths and of its values.
    pub columns: Option<[usize; 2]>,
    /// EULUMDAT symmetry 3 stored with C90 first, against the format's description.
    pub isym3_c90_first: bool,
    /// IES 1995 and 2002: multiply by the field that these editions keep for future use.
    pub apply_future_use: bool,
}

/// Another file that the file names, opened.
#[derive(Debug, Clone)]
pub struct Opened {
    /// Where it was found, as a person would name it.
    pub path: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Opens a file by the name that stands in the one that is read, or says why not. Readers do no input of their own.
pub type Beside<'b> = &'b dyn Fn(&str) -> Result<Opened, String>;

/// What a person may decide of a file that is written.
#[derive(Debug, Clone, Default)]
pub struct WriteOptions {
    /// Edition: `2002`, `2019` for IES; `2018`, `2023` for TM-33.
    pub edition: Option<String>,
    /// File generation type of LM-63-2019; without it the source's own, or undefined.
    pub generation: Option<String>,
    /// Coordinates of an IES file; without it those of the source.
    pub photometry: Option<Photometry>,
    /// The light is no longer that of the file which was read.
    pub edited: bool,
}

impl WriteOptions {
    /// Decisions that the format does not know are no mistake to be passed over.
    pub(crate) fn only_for(&self, format: Format) -> Result<(), Finding> {
        let (lm63, editions) = (format == Format::IES, matches!(format, Format::IES | Format::TM33));
        let requested = [
            (
                self.photometry.is_some() && !lm63,
                "only IES files have photometry of types A and B",
                "write an .ies, or leave --photometry out",
            ),
            (
                self.generation.is_some() && !lm63,
                "--generation: only IES files have a file generation type",
                "write an .ies, or leave --generation out",
            ),
            (
                self.edition.is_some() && !editions,
                "--edition: only IES and TM-33 files have editions",
                "write an .ies or .xml, or leave --edition out",
            ),
        ];
        match requested.into_iter().find(|(wrong, ..)| *wrong) {
            Some((_, message, fix)) => Err(Finding::error("convert-option", message).fix(fix)),
            None => Ok(()),
        }
    }
}
