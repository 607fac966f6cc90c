//! What is said of one photometry or spectrum.

use isolux_formats::{Content, Finding, Format, Kind, Severity};
use serde::Serialize;
use serde_json::{Map, Value};

use super::mismatch::Meter;

/// What is said of one photometry or spectrum; serialises to the object of `inspect --json`.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// The file, `outer!inner` inside a container.
    pub file: String,
    /// The format that was recognised.
    pub format: Option<Format>,
    /// What it describes.
    pub kind: Option<Kind>,
    /// Whether its content can be used: `convert` writes it, or all its rays are there.
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
    /// What it is, in words: content and format.
    pub fn what(&self) -> String {
        let kind = match self.kind {
            Some(Kind::Distribution) => "luminous intensity distribution",
            Some(Kind::Spectrum) => "spectrum",
            Some(Kind::Rays) => "ray file",
            None => "",
        };
        let words = match (kind, self.format) {
            ("", _) => "of no known format".to_owned(),
            (kind, Some(format)) => format!("{kind}, {}", format.title()),
            (kind, None) => kind.to_owned(),
        };
        let end = if self.readable { "" } else { ", not readable" };
        format!("{words}{end}")
    }

    /// Whether any finding is an error.
    pub fn has_error(&self) -> bool {
        self.findings.iter().any(|finding| finding.severity == Severity::Error)
    }

    /// Adds to a spectrum's quantities what `meter` makes of it: `spectral_mismatch`, null where it cannot be had, and
    /// why; and what was found in the meter's own files.
    pub fn seen_by(&mut self, meter: &Meter) {
        let Some(Content::Spectrum(file)) = &self.content else {
            return;
        };
        let Ok(source) = file.spectrum() else {
            return;
        };
        self.findings.extend_from_slice(meter.findings());
        let factor = match meter.mismatch(&source) {
            Ok(factor) => Value::from(factor),
            Err(why) => {
                self.findings.push(
                    Finding::warning(
                        "meter-no-factor",
                        format!("there is no spectral mismatch correction factor: {why}"),
                    )
                    .fix("check that the responsivity is this meter's, over the wavelengths of this light"),
                );
                Value::Null
            }
        };
        self.quantities.insert("spectral_mismatch".to_owned(), factor);
    }
}
