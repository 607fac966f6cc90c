//! What readers and writers give: the file's format and kind, its content or bytes, findings.

use serde::Serialize;

use crate::finding::{Finding, Findings};

/// Files above this are refused: the finest goniophotometer grid fits several times, an accident does not.
pub const LARGEST_FILE: usize = 64 * 1024 * 1024;

/// A file format, by the name that `inspect --json` gives it. The rows of [`formats`](crate::formats()) say the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Format(pub(crate) &'static str);

/// Formats that other code names. A format that only the table knows names itself in its own module.
impl Format {
    /// EULUMDAT, `.ldt`.
    pub const EULUMDAT: Self = Self("eulumdat");
    /// IES LM-63 of any edition.
    pub const IES: Self = Self("ies");
    /// TM-33 / ATLA S001.
    pub const TM33: Self = Self("tm33");
    /// GLDF container.
    pub const GLDF: Self = Self("gldf");
    /// TM-27 spectrum.
    pub const SPDX: Self = Self("spdx");
    /// Pairs of wavelength and value.
    pub const SPD: Self = Self("spd");
    /// CGATS spectrum.
    pub const SP: Self = Self("sp");
    /// JCAMP-DX spectrum.
    pub const JCAMP: Self = Self("jcamp");
    /// Macam spectroradiometers.
    pub const MACAM: Self = Self("macam");
    /// Speos spectrum.
    pub const SPECTRUM: Self = Self("spectrum");
    /// Comma-separated values, a distribution or a spectrum.
    pub const CSV: Self = Self("csv");
    /// The JSON that `convert` writes.
    pub const JSON: Self = Self("json");
    /// TM-25 rays; they are no photometry and are read elsewhere.
    pub const TM25: Self = Self("tm25");
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

/// A file's bytes, and what the format could not hold of what was to be written.
#[derive(Debug, Clone)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was cut, rounded or left out.
    pub findings: Vec<Finding>,
}
