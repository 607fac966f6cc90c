//! The corrections and their switches.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// A correction that can be switched off by its name (`reduce --without dark`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Correction {
    /// The meter's zero offset, from capped readings.
    Dark,
    /// Light in the room without the lamp, from lamp-off readings.
    Ambient,
    /// Light of the lamp that does not come straight from it (EN 13032-1 "stray light"), from baffled readings.
    Stray,
    /// Change of the lamp during the scan, from visits to the reference point.
    Drift,
    /// The dark spectrum of the spectroradiometer.
    SpectralDark,
}

impl Correction {
    /// All corrections, in the order in which they are applied.
    pub const ALL: [Self; 5] = [Self::Dark, Self::Ambient, Self::Stray, Self::Drift, Self::SpectralDark];

    /// The name on the command line and in `provenance.json`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Dark => "dark",
            Self::Ambient => "ambient",
            Self::Stray => "stray",
            Self::Drift => "drift",
            Self::SpectralDark => "spectral_dark",
        }
    }
}

impl fmt::Display for Correction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A word that names no correction.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no correction; there are dark, ambient, stray, drift, spectral_dark")]
pub struct UnknownCorrection(String);

impl FromStr for Correction {
    type Err = UnknownCorrection;
    fn from_str(word: &str) -> Result<Self, UnknownCorrection> {
        Self::ALL
            .into_iter()
            .find(|correction| correction.as_str() == word)
            .ok_or_else(|| UnknownCorrection(word.to_owned()))
    }
}

/// Which corrections are switched off.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Switches {
    off: BTreeSet<Correction>,
}

impl Switches {
    /// Everything on but these.
    pub fn without(off: impl IntoIterator<Item = Correction>) -> Self {
        Self {
            off: off.into_iter().collect(),
        }
    }

    /// Whether a correction is switched on.
    pub fn on(&self, correction: Correction) -> bool {
        !self.off.contains(&correction)
    }
}
