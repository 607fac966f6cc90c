//! `inspect`: facts, quantities and findings of photometric and spectral files.

mod mismatch;

use camino::Utf8Path;
use isolux_formats::{Content, Finding, Format, Kind, Parsed, ReadOptions, Severity, read_any_with};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::files;

pub use mismatch::Meter;

/// What is said of one photometry or spectrum; serialises to the object of `inspect --json`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// The file, `outer!inner` inside a container.
    pub file: String,
    /// The format that was recognised.
    pub format: Option<Format>,
    /// What it describes.
    pub kind: Option<Kind>,
    /// Whether `convert` writes it.
    pub readable: bool,
    /// What the reader found.
    pub findings: Vec<Finding>,
    /// What follows from the content.
    pub quantities: Map<String, Value>,
    /// The content itself, for pictures.
    #[serde(skip)]
    pub content: Option<Content>,
}

impl Inspection {
    /// Whether any finding is an error.
    pub fn has_error(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Error)
    }
}

/// Looks at one file; a file that cannot be read gives its reason as a finding.
pub fn file(path: &Utf8Path, options: ReadOptions) -> Vec<Inspection> {
    match read(path, options) {
        Ok(parsed) => parsed.into_iter().map(|parsed| inspection(path, parsed)).collect(),
        Err(finding) => vec![Inspection {
            file: path.to_string(),
            format: None,
            kind: None,
            readable: false,
            findings: vec![finding],
            quantities: Map::new(),
            content: None,
        }],
    }
}

impl Inspection {
    /// Adds to a spectrum's quantities what `meter` makes of it: `spectral_mismatch`, null where it cannot be had.
    pub fn seen_by(&mut self, meter: &Meter) {
        if let Some(Content::Spectrum(file)) = &self.content {
            let factor = file.spectrum().ok().and_then(|source| meter.mismatch(&source));
            self.quantities
                .insert("spectral_mismatch".to_owned(), factor.map_or(Value::Null, Value::from));
        }
    }
}

/// The content of one file, refused before it is read when it is too large.
///
/// # Errors
/// A finding that says why there is nothing to parse.
pub fn read(path: &Utf8Path, options: ReadOptions) -> Result<Vec<Parsed<Content>>, Finding> {
    if let Ok(facts) = std::fs::metadata(path)
        && facts.len() > isolux_formats::LARGEST_FILE as u64
    {
        let message = format!(
            "the file has {} bytes; more than {} are not read",
            facts.len(),
            isolux_formats::LARGEST_FILE
        );
        return Err(Finding::error("file-too-large", message).fix("check that this is a photometric file"));
    }
    let bytes = files::read(path).map_err(|failure| Finding::error("file-unreadable", failure.message))?;
    Ok(read_any_with(
        &bytes,
        path.file_name().unwrap_or(path.as_str()),
        options,
    ))
}

fn inspection(path: &Utf8Path, parsed: Parsed<Content>) -> Inspection {
    let file = parsed
        .inner
        .as_ref()
        .map_or_else(|| path.to_string(), |inner| format!("{path}!{inner}"));
    let quantities = match &parsed.document {
        Some(Content::Distribution(distribution)) => distribution.quantities(),
        Some(Content::Spectrum(spectrum)) => match serde_json::to_value(spectrum.quantities()) {
            Ok(Value::Object(quantities)) => quantities,
            _ => Map::new(),
        },
        None => Map::new(),
    };
    Inspection {
        file,
        format: parsed.format,
        kind: parsed.kind,
        readable: parsed.document.is_some(),
        findings: parsed.findings,
        quantities,
        content: parsed.document,
    }
}
