//! A row of the table of formats, and a file as the table looks at it.

use std::cell::OnceCell;

use crate::content::Content;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::options::{Beside, ReadOptions, WriteOptions};
use crate::parsed::{Format, Parsed, Written};
use crate::spectral::file::SpectrumFile;
use crate::text::Text;

/// Everything that was read from a file.
pub(crate) type Found = Vec<Parsed<Content>>;

/// Writes a distribution.
pub(crate) type WriteDistribution = fn(&Distribution, &WriteOptions) -> Result<Written, Finding>;

/// One format. Its module states it as a constant, and [`formats`](crate::formats()) lists it.
#[derive(Debug)]
pub struct FileFormat {
    /// What programs call it.
    pub format: Format,
    /// Its name for people.
    pub title: &'static str,
    /// In lower case, without their points; the first is the one to write.
    pub extensions: &'static [&'static str],
    /// Whether the file is one of these, by its content, then by its name.
    pub(crate) detect: fn(&Source<'_>) -> bool,
    /// Empty where the file turns out to be something else.
    pub(crate) read: fn(&Source<'_>) -> Found,
    /// Writes a distribution; none where the format holds none.
    pub(crate) write_distribution: Option<WriteDistribution>,
    /// Writes a spectrum; none where the format holds none.
    pub(crate) write_spectrum: Option<fn(&SpectrumFile) -> Written>,
}

/// A file as the table looks at it.
pub(crate) struct Source<'b> {
    pub bytes: &'b [u8],
    /// In lower case, without its point.
    pub extension: String,
    pub options: ReadOptions,
    pub beside: Beside<'b>,
    /// Reads a file inside this one, from its bytes and name.
    pub read_inner: fn(&[u8], &str, ReadOptions) -> Found,
    /// The first lines.
    head: OnceCell<Text<'b>>,
    /// The whole text, and what its decoding found.
    text: OnceCell<(Text<'b>, Findings)>,
}

impl<'b> Source<'b> {
    pub fn new(
        bytes: &'b [u8],
        file_name: &str,
        options: ReadOptions,
        beside: Beside<'b>,
        read_inner: fn(&[u8], &str, ReadOptions) -> Found,
    ) -> Self {
        let extension = file_name.rsplit_once('.').map_or("", |(_, end)| end);
        Self {
            bytes,
            extension: extension.to_ascii_lowercase(),
            options,
            beside,
            read_inner,
            head: OnceCell::new(),
            text: OnceCell::new(),
        }
    }

    pub fn head(&self) -> &Text<'b> {
        let first = &self.bytes[..self.bytes.len().min(64 * 1024)];
        self.head.get_or_init(|| Text::decode(first, &mut Findings::new()))
    }

    /// The whole text, and what its decoding found.
    pub fn decoded(&self) -> (&Text<'b>, Findings) {
        let (text, findings) = self.text.get_or_init(|| {
            let mut findings = Findings::new();
            let text = Text::decode(self.bytes, &mut findings);
            (text, findings)
        });
        (text, findings.clone())
    }

    pub fn text(&self) -> &Text<'b> {
        self.decoded().0
    }

    pub fn is_xml(&self) -> bool {
        self.text().content().trim_start().starts_with('<')
    }

    pub fn named(&self, extensions: &[&str]) -> bool {
        extensions.contains(&self.extension.as_str())
    }

    /// Reads the text as a spectrum.
    pub fn spectrum(&self, read: fn(&Text<'_>, Findings) -> Parsed<SpectrumFile>) -> Found {
        let (text, findings) = self.decoded();
        vec![read(text, findings).map(Content::spectrum)]
    }
}

/// A file of one distribution.
pub(crate) fn distribution(parsed: Parsed<Distribution>) -> Found {
    vec![parsed.map(Content::distribution)]
}

/// A file without content, and why.
pub(crate) fn refused(format: Option<Format>, finding: Finding) -> Found {
    vec![Parsed::refused(format, None, finding.into())]
}
