//! Lines of lamps, and lists of them that a laboratory writes.

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use crate::document::bounds::within;
use crate::document::{DocumentError, Fault, SourceText};

/// Value of `format` in a list.
pub const FORMAT: &str = "isolux-lines/1";

/// Name of the list that needs no file.
pub const MERCURY_ARGON: &str = "mercury_argon";

/// The lines of a lamp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineList {
    /// [`FORMAT`].
    pub format: String,
    /// The lamp.
    pub lamp: String,
    /// Every line of it within the range of the instrument, the weak ones beside strong ones too.
    pub line: Vec<Line>,
}

/// A line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Wavelength in air.
    pub wavelength_nm: f64,
    /// Light of the line over that of the strongest, as it is in kind: it says which lines disturb which.
    pub strength_rel: f64,
}

/// Wavelengths in air of a mercury pencil lamp with argon. Hg I: Sansonetti, Salit and Reader, Appl. Opt. 35, 74
/// (1996), table 2; Ar I: NIST Atomic Spectra Database, observed wavelengths in air.
const OF_MERCURY_ARGON: [(f64, f64); 33] = [
    (365.0158, 0.3),
    (365.4842, 0.1),
    (366.3284, 0.05),
    (404.6565, 0.4),
    (407.7837, 0.03),
    (433.9224, 0.015),
    (434.7506, 0.03),
    (435.8335, 1.0),
    (546.0750, 1.0),
    (576.9610, 0.15),
    (579.0670, 0.15),
    (696.5431, 0.1),
    (706.7218, 0.05),
    (714.7042, 0.005),
    (727.2936, 0.02),
    (738.3980, 0.08),
    (750.3869, 0.12),
    (751.4652, 0.06),
    (763.5106, 0.25),
    (772.3761, 0.08),
    (772.4207, 0.05),
    (794.8176, 0.08),
    (800.6157, 0.06),
    (801.4786, 0.06),
    (810.3693, 0.1),
    (811.5311, 0.2),
    (826.4522, 0.1),
    (840.8210, 0.1),
    (842.4648, 0.12),
    (852.1442, 0.08),
    (866.7944, 0.01),
    (912.2967, 0.15),
    (922.4499, 0.06),
];

impl LineList {
    /// Those of a mercury pencil lamp with argon.
    pub fn mercury_argon() -> Self {
        let line = |(wavelength_nm, strength_rel): (f64, f64)| Line {
            wavelength_nm,
            strength_rel,
        };
        Self {
            format: FORMAT.to_owned(),
            lamp: MERCURY_ARGON.to_owned(),
            line: OF_MERCURY_ARGON.map(line).to_vec(),
        }
    }

    /// Reads a list; its lines come sorted.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        let source = SourceText { file, text };
        let mut list: Self = source.parse(FORMAT)?;
        list.check().map_err(|fault| source.locate(&fault))?;
        list.line.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
        Ok(list)
    }

    fn check(&self) -> Result<(), Fault> {
        if self.lamp.trim().is_empty() || self.lamp.chars().any(char::is_control) {
            return Err(Fault::new("lamp", "is empty or more than one line; write what shines"));
        }
        for (place, line) in self.line.iter().enumerate() {
            let key = |name: &str| format!("line.{place}.{name}");
            within(&key("wavelength_nm"), line.wavelength_nm, 150.0..=3000.0, " nm in air")?;
            within(
                &key("strength_rel"),
                line.strength_rel,
                1e-6..=1.0,
                " of the strongest line",
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_a_laboratory_is_checked_line_by_line() {
        let file = Utf8Path::new("neon.toml");
        let text = "format = \"isolux-lines/1\"\nlamp = \"neon\"\n[[line]]\nwavelength_nm = 640.2248\n\
                    strength_rel = 1.0\n[[line]]\nwavelength_nm = 585.2488\nstrength_rel = 0.3\n";
        let list = LineList::parse(file, text).unwrap();
        assert_eq!(list.line[0].wavelength_nm, 585.2488);
        for (from, to, expected) in [
            (
                "= 640.2248",
                "= 6402.248",
                "neon.toml:4:1: line.0.wavelength_nm: is 6402.248",
            ),
            ("= 0.3", "= 30.0", "neon.toml:8:1: line.1.strength_rel: is 30"),
            ("\"neon\"", "\"\"", "neon.toml:2:1: lamp: is empty"),
        ] {
            let error = LineList::parse(file, &text.replacen(from, to, 1)).unwrap_err();
            assert!(error.to_string().starts_with(expected), "{error}");
        }
        assert!(
            LineList::mercury_argon()
                .line
                .is_sorted_by(|a, b| a.wavelength_nm < b.wavelength_nm)
        );
    }
}
