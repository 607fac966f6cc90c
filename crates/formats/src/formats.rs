//! All formats in one table, and from a file's bytes and name to its content.
//!
//! A new format is a module of its own with a constant of the type [`FileFormat`], and its line in [`FORMATS`].

use crate::content::Content;
use crate::distribution::Distribution;
use crate::file_format::{FileFormat, Found, Source, refused};
use crate::finding::Finding;
use crate::options::{Beside, ReadOptions, WriteOptions};
use crate::parsed::{Format, LARGEST_FILE, Parsed, Written};
use crate::spectral::file::SpectrumFile;
use crate::spectral::{cgats, columns, jcamp, macam, spdx, speos};
use crate::{eulumdat, gldf, ies, json, tm25, tm33};

/// All formats, in the order in which a file is held against them.
static FORMATS: [FileFormat; 13] = [
    tm25::FORMAT,
    gldf::FORMAT,
    ies::FORMAT,
    tm33::FORMAT,
    jcamp::FORMAT,
    json::FORMAT,
    spdx::FORMAT,
    speos::FORMAT,
    macam::FORMAT,
    cgats::FORMAT,
    columns::PAIRS,
    columns::TABLE,
    eulumdat::FORMAT,
];

/// All formats: what they are called, how they are recognised, read and written.
pub fn formats() -> impl Iterator<Item = &'static FileFormat> {
    FORMATS.iter()
}

/// The first extensions of the formats that hold a distribution, or a spectrum, and can be written.
fn written(of: impl Fn(&FileFormat) -> bool) -> String {
    let extensions = FORMATS
        .iter()
        .filter(|row| of(row))
        .filter_map(|row| row.extensions.first());
    let names: Vec<String> = extensions.map(|extension| format!(".{extension}")).collect();
    names.join(" ")
}

/// What files a distribution can be written to, for people: `.ies .xml …`.
pub fn distribution_targets() -> String {
    written(|row| row.write_distribution.is_some())
}

/// What files a spectrum can be written to, for people: `.spdx .csv …`.
pub fn spectrum_targets() -> String {
    written(|row| row.write_spectrum.is_some())
}

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
pub fn read_any_beside(bytes: &[u8], file_name: &str, options: ReadOptions, beside: Beside<'_>) -> Found {
    let source = Source::new(bytes, file_name, options, beside, read_any_with);
    if bytes.len() > LARGEST_FILE {
        let size = bytes.len();
        let message = format!("the file has {size} bytes; more than {LARGEST_FILE} are not read");
        let finding = Finding::error("file-too-large", message);
        return refused(None, finding.fix("check that this is a photometric file"));
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let format = Format::of_extension(&source.extension);
        let finding = Finding::error("file-empty", "the file is empty");
        return refused(format, finding.fix("fetch the file again"));
    }
    if gldf::is_workbook(bytes) {
        let finding = Finding::error("format-workbook", "this is an Excel workbook");
        return refused(None, finding.fix("save the sheet with the data as CSV"));
    }
    let rows = FORMATS.iter().filter(|row| (row.detect)(&source));
    let mut found = rows.map(|row| (row.read)(&source)).filter(|found| !found.is_empty());
    found.next().unwrap_or_else(|| {
        let message = "this is no photometric or spectral format that is known here";
        let known = format!("known are {}", written(|_| true));
        refused(None, Finding::error("format-unknown", message).fix(known))
    })
}

impl Distribution {
    /// The one distribution in a file, for commands that need exactly that; findings travel with it.
    ///
    /// # Errors
    /// The findings, when the file holds none, more than one, or a spectrum.
    pub fn load(bytes: &[u8], file_name: &str) -> Result<(Self, Vec<Finding>), Vec<Finding>> {
        let mut parsed = read_any(bytes, file_name);
        if parsed.len() != 1 {
            let many = format!(
                "the file holds {} photometries or spectra; one distribution is needed",
                parsed.len()
            );
            return Err(vec![
                Finding::error("distribution-one", many).fix("convert the one that is meant first"),
            ]);
        }
        let only = parsed.remove(0);
        match only.document {
            Some(Content::Distribution(distribution)) => Ok((*distribution, only.findings)),
            Some(Content::Spectrum(_)) => Err(vec![Finding::error(
                "distribution-none",
                "the file holds a spectrum, not a distribution",
            )]),
            None => Err(only.findings),
        }
    }
}

/// Writes a distribution in `format`.
///
/// # Errors
/// A finding that says why it cannot be written so; none is there for a format that holds no distribution.
pub fn write_distribution(
    distribution: &Distribution,
    format: Format,
    options: &WriteOptions,
) -> Option<Result<Written, Finding>> {
    let write = FORMATS.iter().find(|row| row.format == format)?.write_distribution?;
    Some(write(distribution, options))
}

/// Writes a spectrum in `format`; none where that holds no spectrum.
pub fn write_spectrum(file: &SpectrumFile, format: Format) -> Option<Written> {
    let write = FORMATS.iter().find(|row| row.format == format)?.write_spectrum?;
    Some(write(file))
}

impl Format {
    /// Its name for people.
    pub fn title(self) -> &'static str {
        let row = FORMATS.iter().find(|row| row.format == self);
        row.map_or("", |row| row.title)
    }

    /// The format that a file extension (lower case, no point) stands for.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let row = FORMATS.iter().find(|row| row.extensions.contains(&extension))?;
        Some(row.format)
    }
}
