//! The corrections, each of which can be switched off.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One correction of the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// The meter's offset, from capped readings.
    Dark,
    /// Light in the room with the lamp off, from lamp_off readings.
    Ambient,
    /// Stray light made by the lamp, from baffled readings.
    Stray,
    /// The square of each reading's own distance; off: of the station's.
    InverseSquare,
    /// Drift of lamp and meter, from the visits to the reference point.
    Drift,
    /// The dark spectrum.
    SpectralDark,
    /// The wavelength scale of the spectroradiometer, from a line lamp.
    Wavelengths,
    /// Its bandpass, from the same lines.
    Bandpass,
    /// The light that it scatters inside, from a long-pass filter.
    Scatter,
    /// What is left of its non-linearity, from integration times.
    Linearity,
    /// The smoothest distribution that rounding and scatter of the readings allow; off: the raw one.
    Smoothing,
}

impl Correction {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Dark,
        Self::Ambient,
        Self::Stray,
        Self::InverseSquare,
        Self::Drift,
        Self::SpectralDark,
        Self::Wavelengths,
        Self::Bandpass,
        Self::Scatter,
        Self::Linearity,
        Self::Smoothing,
    ];

    /// The word on the command line.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Dark => "dark",
            Self::Ambient => "ambient",
            Self::Stray => "stray",
            Self::InverseSquare => "inverse_square",
            Self::Drift => "drift",
            Self::SpectralDark => "spectral_dark",
            Self::Wavelengths => "wavelengths",
            Self::Bandpass => "bandpass",
            Self::Scatter => "scatter",
            Self::Linearity => "linearity",
            Self::Smoothing => "smoothing",
        }
    }
}

impl fmt::Display for Correction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A word that is no correction.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no correction; there are dark, ambient, stray, inverse_square, drift, spectral_dark, wavelengths, \
     bandpass, scatter, linearity, smoothing"
)]
pub struct UnknownCorrection(String);

impl FromStr for Correction {
    type Err = UnknownCorrection;
    fn from_str(word: &str) -> Result<Self, UnknownCorrection> {
        Self::ALL
            .into_iter()
            .find(|known| known.as_str() == word)
            .ok_or_else(|| UnknownCorrection(word.to_owned()))
    }
}
