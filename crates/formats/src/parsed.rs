//! What every reader takes and gives: options, the file's format and kind, its content with findings.

use serde::Serialize;

use crate::finding::{Finding, Findings};

/// Files above this are refused: the finest goniophotometer grid fits several times, an accident does not.
pub const LARGEST_FILE: usize = 64 * 1024 * 1024;

/// A file format, named as `inspect --json` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// EULUMDAT, `.ldt`.
    Eulumdat,
    /// IES LM-63 of any edition.
    Ies,
    /// TM-33 / ATLA S001.
    Tm33,
    /// GLDF container.
    Gldf,
    /// TM-27 spectrum.
    Spdx,
    /// Pairs of wavelength and value.
    Spd,
    /// CGATS spectrum.
    Sp,
    /// JCAMP-DX spectrum.
    Jcamp,
    /// Macam spectroradiometers.
    Macam,
    /// Speos spectrum.
    Spectrum,
    /// Comma-separated values, a distribution or a spectrum.
    Csv,
    /// The JSON that `convert` writes.
    Json,
    /// TM-25 rays; they are no photometry and are read elsewhere.
    Tm25,
}

/// What a file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A luminous intensity distribution.
    Distribution,
    /// A spectrum.
    Spectrum,
    /// Rays.
    Rays,
}

/// One photometry or spectrum out of a file, or why there is none.
#[derive(Debug, Clone)]
pub struct Parsed<T> {
    /// Name inside a container; none for the file itself.
    pub inner: Option<String>,
    /// The format, if it was recognised.
    pub format: Option<Format>,
    /// What it describes, if that is known.
    pub kind: Option<Kind>,
    /// The content; none when nothing trustworthy enough to hand on could be read.
    pub document: Option<T>,
    /// What the reader found, by line.
    pub findings: Vec<Finding>,
}

impl<T> Parsed<T> {
    /// Content of `format` with its findings.
    pub fn new(format: Format, kind: Kind, document: Option<T>, findings: Findings) -> Self {
        Self {
            inner: None,
            format: Some(format),
            kind: Some(kind),
            document,
            findings: findings.into_vec(),
        }
    }

    /// No content, and why.
    pub fn refused(format: Option<Format>, kind: Option<Kind>, findings: Findings) -> Self {
        Self {
            inner: None,
            format,
            kind,
            document: None,
            findings: findings.into_vec(),
        }
    }

    /// The same with its document changed.
    pub fn map<U>(self, into: impl FnOnce(T) -> U) -> Parsed<U> {
        Parsed {
            inner: self.inner,
            format: self.format,
            kind: self.kind,
            document: self.document.map(into),
            findings: self.findings,
        }
    }
}

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

/// A file's bytes, and what the format could not hold of what was to be written.
#[derive(Debug, Clone)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was cut, rounded or left out.
    pub findings: Vec<Finding>,
}
