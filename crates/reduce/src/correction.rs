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
    /// The head's spectral responsivity, by F* of the lamp's spectra.
    SpectralMismatch,
    /// The meter's departure from proportion to the light.
    Linearity,
    /// The meter's responsivity at the temperature of the room.
    Temperature,
    /// The meter's response to light that does not come along its normal.
    Cosine,
    /// What light took from the meter's responsivity.
    Fatigue,
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
    SpectralLinearity,
    /// The smoothest distribution that rounding and scatter of the readings allow; off: the raw one.
    Smoothing,
}

impl Correction {
    /// All of them.
    pub const ALL: [Self; 16] = [
        Self::Dark,
        Self::Ambient,
        Self::Stray,
        Self::SpectralMismatch,
        Self::Linearity,
        Self::Temperature,
        Self::Cosine,
        Self::Fatigue,
        Self::InverseSquare,
        Self::Drift,
        Self::SpectralDark,
        Self::Wavelengths,
        Self::Bandpass,
        Self::Scatter,
        Self::SpectralLinearity,
        Self::Smoothing,
    ];

    /// The word on the command line.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Dark => "dark",
            Self::Ambient => "ambient",
            Self::Stray => "stray",
            Self::SpectralMismatch => "spectral_mismatch",
            Self::Linearity => "linearity",
            Self::Temperature => "temperature",
            Self::Cosine => "cosine",
            Self::Fatigue => "fatigue",
            Self::InverseSquare => "inverse_square",
            Self::Drift => "drift",
            Self::SpectralDark => "spectral_dark",
            Self::Wavelengths => "wavelengths",
            Self::Bandpass => "bandpass",
            Self::Scatter => "scatter",
            Self::SpectralLinearity => "spectral_linearity",
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
#[error("`{0}` is no correction; there are {all}", all = words())]
pub struct UnknownCorrection(String);

/// The words of all corrections.
fn words() -> String {
    Correction::ALL.map(Correction::as_str).join(", ")
}

impl FromStr for Correction {
    type Err = UnknownCorrection;
    fn from_str(word: &str) -> Result<Self, UnknownCorrection> {
        Self::ALL
            .into_iter()
            .find(|known| known.as_str() == word)
            .ok_or_else(|| UnknownCorrection(word.to_owned()))
    }
}
