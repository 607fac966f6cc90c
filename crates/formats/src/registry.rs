//! All formats in one table, and from a file's bytes and name to its content.
//!
//! A new format is a module of its own and a row of [`FORMATS`].

use std::cell::OnceCell;

use crate::content::Content;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::parsed::{Beside, Format, LARGEST_FILE, Parsed, ReadOptions, Written};
use crate::spectral::file::SpectrumFile;
use crate::spectral::{cgats, jcamp, json, macam, spdx, speos, table};
use crate::text::Text;
use crate::write::{self, WriteOptions};
use crate::{eulumdat, gldf, ies, rotational, spectral, tm33};

/// A file as the table looks at it.
struct Source<'b> {
    bytes: &'b [u8],
    /// In lower case, without its point.
    extension: String,
    options: ReadOptions,
    beside: Beside<'b>,
    /// The first lines.
    head: OnceCell<Text<'b>>,
    /// The whole text, and what its decoding found.
    text: OnceCell<(Text<'b>, Findings)>,
}

impl<'b> Source<'b> {
    fn new(bytes: &'b [u8], file_name: &str, options: ReadOptions, beside: Beside<'b>) -> Self {
        Self {
            bytes,
            extension: file_name
                .rsplit_once('.')
                .map_or(String::new(), |(_, end)| end.to_ascii_lowercase()),
            options,
            beside,
            head: OnceCell::new(),
            text: OnceCell::new(),
        }
    }

    fn head(&self) -> &Text<'b> {
        let first = &self.bytes[..self.bytes.len().min(64 * 1024)];
        self.head.get_or_init(|| Text::decode(first, &mut Findings::new()))
    }

    fn decoded(&self) -> &(Text<'b>, Findings) {
        self.text.get_or_init(|| {
            let mut findings = Findings::new();
            let text = Text::decode(self.bytes, &mut findings);
            (text, findings)
        })
    }

    fn text(&self) -> &Text<'b> {
        &self.decoded().0
    }

    fn is_xml(&self) -> bool {
        self.text().content().trim_start().starts_with('<')
    }

    fn named(&self, extensions: &[&str]) -> bool {
        extensions.contains(&self.extension.as_str())
    }
}

type WriteDistribution = fn(&Distribution, &WriteOptions) -> Result<Written, Finding>;

/// Everything that was read from a file.
type Found = Vec<Parsed<Content>>;

/// One format.
struct Row {
    format: Format,
    /// Its name for people.
    title: &'static str,
    /// In lower case, without their points.
    extensions: &'static [&'static str],
    /// Whether the file is one of these, by its content, then by its name.
    detect: fn(&Source<'_>) -> bool,
    /// None where the file turns out to be something else.
    read: fn(&Source<'_>) -> Option<Found>,
    write_distribution: Option<WriteDistribution>,
    write_spectrum: Option<fn(&SpectrumFile) -> Written>,
}

/// All formats, in the order in which a file is held against them.
const FORMATS: [Row; 14] = [
    Row {
        format: Format::Tm25,
        title: "TM-25",
        extensions: &["tm25ray"],
        detect: |source| source.bytes.starts_with(b"TM25"),
        read: |_| Some(refused(Some(Format::Tm25), rays())),
        write_distribution: None,
        write_spectrum: None,
    },
    Row {
        format: Format::Gldf,
        title: "GLDF",
        extensions: &["gldf"],
        detect: |source| gldf::looks_like(source.bytes),
        read: |source| {
            let inner = |bytes: &[u8], name: &str| read_any_with(bytes, name, source.options);
            Some(gldf::read(source.bytes, &inner))
        },
        write_distribution: None,
        write_spectrum: None,
    },
    Row {
        format: Format::Ies,
        title: "IES LM-63",
        extensions: &["ies"],
        detect: |source| {
            let named = || source.extension == "ies" && !eulumdat::looks_like(source.head());
            ies::looks_like(source.head()) || named()
        },
        read: |source| Some(light(ies::read_beside(source.bytes, source.options, source.beside))),
        write_distribution: Some(write::lm63),
        write_spectrum: None,
    },
    Row {
        format: Format::Tm33,
        title: "TM-33",
        extensions: &["xml", "tm33", "atla"],
        detect: |source| tm33::looks_like(source.head()),
        read: |source| Some(light(tm33::read(source.bytes))),
        write_distribution: Some(write::tm33),
        write_spectrum: None,
    },
    Row {
        format: Format::Csv,
        title: "table",
        extensions: &[],
        detect: |source| rotational::looks_like(source.head()),
        read: |source| Some(light(rotational::read(source.bytes))),
        write_distribution: None,
        write_spectrum: None,
    },
    Row {
        format: Format::Jcamp,
        title: "JCAMP-DX",
        extensions: &["jdx", "dx", "jcamp"],
        detect: |source| jcamp::looks_like(source.text()) || source.named(&["jdx", "dx", "jcamp"]),
        read: |source| Some(spectrum(source, jcamp::read)),
        write_distribution: None,
        write_spectrum: None,
    },
    Row {
        format: Format::Json,
        title: "isolux JSON",
        extensions: &["json"],
        detect: |source| json::looks_like(source.text()),
        read: |source| {
            let (text, findings) = source.decoded();
            Some(vec![json::read(text, findings.clone()).map(content)])
        },
        write_distribution: Some(write::json),
        write_spectrum: Some(spectral::write::json),
    },
    Row {
        format: Format::Spdx,
        title: "TM-27 .spdx",
        extensions: &["spdx"],
        detect: |source| spdx::looks_like(source.text()) || source.extension == "spdx",
        read: |source| Some(spectrum(source, spdx::read)),
        write_distribution: None,
        write_spectrum: Some(spectral::write::tm27),
    },
    Row {
        format: Format::Spectrum,
        title: "Speos",
        extensions: &["spectrum"],
        detect: |source| !source.is_xml() && (speos::looks_like(source.text()) || source.extension == "spectrum"),
        read: |source| Some(spectrum(source, speos::read)),
        write_distribution: None,
        write_spectrum: Some(spectral::write::spectrum),
    },
    Row {
        format: Format::Macam,
        title: "Macam",
        extensions: &[],
        detect: |source| !source.is_xml() && macam::looks_like(source.text()),
        read: |source| Some(spectrum(source, macam::read)),
        write_distribution: None,
        write_spectrum: None,
    },
    Row {
        format: Format::Sp,
        title: "CGATS",
        extensions: &["sp"],
        detect: |source| !source.is_xml() && (cgats::looks_like(source.text()) || source.extension == "sp"),
        read: |source| {
            if cgats::looks_like(source.text()) {
                Some(spectrum(source, cgats::read))
            } else {
                columns(source, Format::Sp)
            }
        },
        write_distribution: None,
        write_spectrum: Some(spectral::write::cgats),
    },
    Row {
        format: Format::Spd,
        title: "pairs of wavelength and value",
        extensions: &["spd"],
        detect: |source| !source.is_xml() && source.extension == "spd",
        read: |source| columns(source, Format::Spd),
        write_distribution: None,
        write_spectrum: Some(spectral::write::pairs),
    },
    Row {
        format: Format::Csv,
        title: "table",
        extensions: &["csv"],
        detect: |source| !source.is_xml() && !source.named(&["ldt", "eul", "ies", "xml", "gldf", "tm33", "atla"]),
        read: |source| columns(source, Format::Csv),
        write_distribution: None,
        write_spectrum: Some(spectral::write::table),
    },
    Row {
        format: Format::Eulumdat,
        title: "EULUMDAT",
        extensions: &["ldt", "eul"],
        detect: |source| source.named(&["ldt", "eul"]) || eulumdat::looks_like(source.head()),
        read: |source| {
            let (text, findings) = source.decoded();
            Some(light(eulumdat::read_text(text, findings.clone(), source.options)))
        },
        write_distribution: Some(write::eulumdat),
        write_spectrum: None,
    },
];

fn content(file: SpectrumFile) -> Content {
    Content::Spectrum(Box::new(file))
}

fn light(parsed: Parsed<Distribution>) -> Found {
    vec![parsed.map(|read| Content::Distribution(Box::new(read)))]
}

fn spectrum(source: &Source<'_>, read: fn(&Text<'_>, Findings) -> Parsed<SpectrumFile>) -> Found {
    let (text, findings) = source.decoded();
    vec![read(text, findings.clone()).map(content)]
}

/// A text of columns. Under a name of no spectral format it must show that it is a spectrum, also a damaged one.
fn columns(source: &Source<'_>, format: Format) -> Option<Found> {
    let (text, findings) = source.decoded();
    let asked = source.options.columns;
    let (parsed, rising) = table::read(text, findings.clone(), format, asked);
    let named = source.named(&["spd", "sp", "csv", "tsv"]) || table::looks_like_vendor_text(text) || asked.is_some();
    (named || rising >= 8).then(|| vec![parsed.map(content)])
}

fn rays() -> Finding {
    let message = "a ray file holds rays, neither a distribution nor a spectrum";
    Finding::error("tm25-rays", message).fix("`isolux inspect` says what it holds")
}

fn refused(format: Option<Format>, finding: Finding) -> Found {
    vec![Parsed::refused(format, None, finding.into())]
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
pub fn read_any_beside(
    bytes: &[u8],
    file_name: &str,
    options: ReadOptions,
    beside: Beside<'_>,
) -> Vec<Parsed<Content>> {
    let source = Source::new(bytes, file_name, options, beside);
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
    let mut rows = FORMATS.iter().filter(|row| (row.detect)(&source));
    rows.find_map(|row| (row.read)(&source)).unwrap_or_else(|| {
        let message = "this is no photometric or spectral format that is known here";
        let known = "known are .ldt, .ies, TM-33 .xml, .gldf, .spdx, .spd, .sp, .spectrum and .csv";
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
    let write = FORMATS
        .iter()
        .filter(|row| row.format == format)
        .find_map(|row| row.write_distribution)?;
    Some(write(distribution, options))
}

/// Writes a spectrum in `format`; none where that holds no spectrum.
pub fn write_spectrum(file: &SpectrumFile, format: Format) -> Option<Written> {
    let write = FORMATS
        .iter()
        .filter(|row| row.format == format)
        .find_map(|row| row.write_spectrum)?;
    Some(write(file))
}

impl Format {
    /// Its name for people.
    pub fn title(self) -> &'static str {
        FORMATS
            .iter()
            .find(|row| row.format == self)
            .map_or("", |row| row.title)
    }

    /// The format that a file extension (lower case, no point) stands for.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let row = FORMATS.iter().find(|row| row.extensions.contains(&extension))?;
        Some(row.format)
    }
}
