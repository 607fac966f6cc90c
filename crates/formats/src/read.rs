//! From a file's bytes and name to its content, whatever its format.

use serde::Serialize;

use crate::distribution::{self, Distribution};
use crate::finding::{Finding, Findings};
use crate::spectral::{self, SpectrumFile};
use crate::text::Text;
use crate::{eulumdat, gldf, ies, tm33};

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

/// A distribution or a spectrum.
#[derive(Debug, Clone)]
pub enum Content {
    /// A luminous intensity distribution.
    Distribution(Box<Distribution>),
    /// A spectrum.
    Spectrum(Box<SpectrumFile>),
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

/// Everything that a file holds: one entry for most files, one a photometry or spectrum for a container, and one with
/// findings alone for a file that cannot be read. `file_name` is used where the content does not decide.
pub fn read_any(bytes: &[u8], file_name: &str) -> Vec<Parsed<Content>> {
    read_any_with(bytes, file_name, ReadOptions::default())
}

/// [`read_any`] with a person's decisions.
pub fn read_any_with(bytes: &[u8], file_name: &str, options: ReadOptions) -> Vec<Parsed<Content>> {
    read_any_beside(bytes, file_name, options, &|_| {
        Err("only the file itself was given".to_owned())
    })
}

/// [`read_any_with`], and `beside` opens the other files that it names (the tilt file of LM-63).
pub fn read_any_beside(
    bytes: &[u8],
    file_name: &str,
    options: ReadOptions,
    beside: Beside<'_>,
) -> Vec<Parsed<Content>> {
    let extension = file_name
        .rsplit_once('.')
        .map_or(String::new(), |(_, end)| end.to_ascii_lowercase());
    let refused = |format: Option<Format>, finding: Finding| {
        vec![Parsed {
            inner: None,
            format,
            kind: None,
            document: None,
            findings: vec![finding],
        }]
    };
    if bytes.len() > LARGEST_FILE {
        let message = format!(
            "the file has {} bytes; more than {LARGEST_FILE} are not read",
            bytes.len()
        );
        return refused(
            None,
            Finding::error("file-too-large", message).fix("check that this is a photometric file"),
        );
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let format = Format::of_extension(&extension);
        return refused(
            format,
            Finding::error("file-empty", "the file is empty").fix("fetch the file again"),
        );
    }
    if bytes.starts_with(b"TM25") {
        return refused(
            Some(Format::Tm25),
            Finding::error(
                "tm25-rays",
                "a ray file holds rays, neither a distribution nor a spectrum",
            )
            .fix("`isolux inspect` says what it holds"),
        );
    }
    let distribution = |parsed: Parsed<Distribution>| vec![parsed.map(|d| Content::Distribution(Box::new(d)))];
    if gldf::is_workbook(bytes) {
        let finding = Finding::error("format-workbook", "this is an Excel workbook");
        return refused(None, finding.fix("save the sheet with the data as CSV"));
    }
    if gldf::looks_like(bytes) {
        return gldf::read(bytes, options);
    }
    let head = Text::decode(&bytes[..bytes.len().min(64 * 1024)], &mut Findings::new());
    if ies::looks_like(&head) || (extension == "ies" && !eulumdat::looks_like(&head)) {
        return distribution(ies::read_beside(bytes, options, beside));
    }
    if tm33::looks_like(&head) {
        return distribution(tm33::read(bytes));
    }
    if distribution::looks_like_csv(&head) {
        return distribution(distribution::read_csv(bytes));
    }
    if let Some(parsed) = spectral::read(bytes, file_name, options) {
        return vec![parsed.map(|spectrum| Content::Spectrum(Box::new(spectrum)))];
    }
    if extension == "ldt" || extension == "eul" || eulumdat::looks_like(&head) {
        return distribution(eulumdat::read(bytes, options));
    }
    refused(
        None,
        Finding::error(
            "format-unknown",
            "this is no photometric or spectral format that is known here",
        )
        .fix("known are .ldt, .ies, TM-33 .xml, .gldf, .spdx, .spd, .sp, .spectrum and .csv"),
    )
}

impl Format {
    /// Its name for people.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Eulumdat => "EULUMDAT",
            Self::Ies => "IES LM-63",
            Self::Tm33 => "TM-33",
            Self::Gldf => "GLDF",
            Self::Spdx => "TM-27 .spdx",
            Self::Spd => "pairs of wavelength and value",
            Self::Sp => "CGATS",
            Self::Spectrum => "Speos",
            Self::Csv => "table",
            Self::Json => "isolux JSON",
            Self::Tm25 => "TM-25",
        }
    }

    /// The format that a file extension (lower case, no point) stands for.
    pub fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "ldt" | "eul" => Self::Eulumdat,
            "ies" => Self::Ies,
            "xml" | "tm33" | "atla" => Self::Tm33,
            "gldf" => Self::Gldf,
            "spdx" => Self::Spdx,
            "spd" => Self::Spd,
            "sp" => Self::Sp,
            "spectrum" => Self::Spectrum,
            "csv" => Self::Csv,
            "json" => Self::Json,
            "tm25ray" => Self::Tm25,
            _ => return None,
        })
    }
}
