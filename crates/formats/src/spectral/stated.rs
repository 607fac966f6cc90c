//! What holds for a spectral text of any format: exponents that stand alone, and limits that its heading states.

use super::file::SpectrumFile;
use super::{exponents, limits};
use crate::finding;
use crate::parsed::Parsed;
use crate::text::Text;

/// Adds to what a reader found.
pub(crate) fn checked(text: &Text<'_>, mut parsed: Parsed<SpectrumFile>) -> Parsed<SpectrumFile> {
    parsed.findings.extend(exponents::alone(text));
    let limits = parsed.document.as_ref().map(|file| limits::check(text, file));
    parsed.findings.extend(limits.unwrap_or_default());
    finding::sort(&mut parsed.findings);
    parsed
}
