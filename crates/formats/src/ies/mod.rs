//! IES LM-63: 1986, 1991, 1995, 2002 and 2019.

mod write;

use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::read::{Format, Kind, Parsed, ReadOptions};
use crate::text::Text;

pub use write::{Facts, write};

/// An edition of LM-63.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// LM-63-1986: no version line.
    E1986,
    /// LM-63-1991.
    E1991,
    /// LM-63-1995.
    E1995,
    /// LM-63-2002.
    E2002,
    /// LM-63-2019.
    E2019,
}

/// Whether this is LM-63: a version line, or a line that begins with `TILT=`.
pub fn looks_like(head: &Text<'_>) -> bool {
    let first = head.line(0).trim_start().to_ascii_uppercase();
    first.starts_with("IESNA") || first.starts_with("IES:") || head.lines().any(is_tilt)
}

fn is_tilt(line: &str) -> bool {
    let line = line.trim_start();
    line.len() >= 5 && line.is_char_boundary(5) && line[..5].eq_ignore_ascii_case("TILT=")
}

/// Reads bytes to absolute candela.
pub fn read(_bytes: &[u8], _options: ReadOptions) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    findings.push(Finding::error("ies-unread", "LM-63 files are written, not yet read"));
    Parsed::new(Format::Ies, Kind::Distribution, None, findings)
}
