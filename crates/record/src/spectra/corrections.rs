//! What a laboratory has found of its spectroradiometer, and every spectrum is corrected by: files that a station names
//! and that a run keeps whole.

mod linearity;
mod scatter;
mod wavelengths;

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

pub use self::linearity::{FORMAT as LINEARITY_FORMAT, Linearity};
pub use self::scatter::{FORMAT as SCATTER_FORMAT, Scatter};
pub use self::wavelengths::{FORMAT as WAVELENGTHS_FORMAT, LineFound, WavelengthScale};
use crate::document::{DocumentError, Fault, SourceText};
use crate::station::is_day;

/// The corrections of a spectroradiometer, each with the procedure that found it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpectralCorrections {
    /// Wavelength scale and bandpass, from a line lamp.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelengths: Option<WavelengthScale>,
    /// Light scattered inside, from a long-pass filter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter: Option<Scatter>,
    /// Linearity, from integration times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linearity: Option<Linearity>,
}

/// Where a correction comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Made {
    /// Model and serial number of the instrument.
    pub instrument: String,
    /// UTC day of the record, YYYY-MM-DD.
    pub day: String,
    /// What it was found with: lamp, filter.
    pub with: String,
    /// SHA-256 of run.toml of the record.
    pub record_sha256: String,
}

impl SpectralCorrections {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Each with its key in `[spectroradiometer]` of a station and where it comes from.
    pub fn made(&self) -> Vec<(&'static str, &Made)> {
        let all = [
            ("wavelengths", self.wavelengths.as_ref().map(|found| &found.made)),
            ("scatter", self.scatter.as_ref().map(|found| &found.made)),
            ("linearity", self.linearity.as_ref().map(|found| &found.made)),
        ];
        all.into_iter().filter_map(|(key, made)| Some((key, made?))).collect()
    }

    /// The keys that a station could name and this one does not.
    pub fn not_named(&self) -> Vec<&'static str> {
        let named: Vec<&str> = self.made().into_iter().map(|(key, _)| key).collect();
        let all = ["wavelengths", "scatter", "linearity"];
        all.into_iter().filter(|key| !named.contains(key)).collect()
    }

    /// Each with its key and the first digits of the hash of its record, in one line; `nothing` without any.
    pub fn name(&self) -> String {
        let hash = |made: &Made| made.record_sha256.chars().take(12).collect::<String>();
        let all: Vec<String> = self
            .made()
            .into_iter()
            .map(|(key, made)| format!("{key} {}", hash(made)))
            .collect();
        if all.is_empty() {
            "nothing".to_owned()
        } else {
            all.join(", ")
        }
    }

    /// The wavelength at a pixel that is said to be at `stated_nm`, nm.
    pub fn true_nm(&self, stated_nm: f64) -> f64 {
        self.wavelengths
            .as_ref()
            .map_or(stated_nm, |scale| scale.true_nm(stated_nm))
    }
}

/// Reads a file of corrections that begins with `format`, and checks it.
fn parse<T: serde::de::DeserializeOwned>(
    file: &Utf8Path,
    text: &str,
    format: &str,
    check: impl Fn(&T) -> Result<(), Fault>,
) -> Result<T, DocumentError> {
    let source = SourceText { file, text };
    let read: T = source.parse(format)?;
    check(&read).map_err(|fault| source.locate(&fault))?;
    Ok(read)
}

/// Where it comes from stands in comments and tables: words on one line.
fn check_made(made: &Made) -> Result<(), Fault> {
    for (key, text) in [("instrument", &made.instrument), ("with", &made.with)] {
        if text.trim().is_empty() || text.chars().any(char::is_control) {
            return Err(Fault::new(format!("made.{key}"), "is empty or more than one line"));
        }
    }
    if !is_day(&made.day) {
        let message = format!("`{}` is no day, write YYYY-MM-DD", made.day);
        return Err(Fault::new("made.day", message));
    }
    Ok(())
}
