//! `[light_modulation]` of a job: a record of the light over time.

use camino::Utf8PathBuf;
use serde::{Deserialize, Serialize};

use crate::document::Fault;

/// `[light_modulation]`: a record of the light over time, and what is stated about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightModulation {
    /// The file: CSV or WAV.
    pub waveform: Utf8PathBuf,
    /// Sample rate in Hz, where the file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample_rate_hz: Option<f64>,
    /// What the recorder shows in the dark, in units of the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dark: Option<f64>,
    /// Exposure times of cameras, ms.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exposures_ms: Vec<f64>,
    /// Time from row to row of a rolling shutter, µs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line_time_us: Option<f64>,
}

impl LightModulation {
    /// Refuses numbers that no recorder and no camera has.
    ///
    /// # Errors
    /// [`Fault`] with the key.
    pub fn check(&self) -> Result<(), Fault> {
        let above_zero = |key: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            let message = format!("{value}: a number above zero is needed");
            Err(Fault::new(format!("light_modulation.{key}"), message))
        };
        self.sample_rate_hz
            .map_or(Ok(()), |hz| above_zero("sample_rate_hz", hz))?;
        self.line_time_us.map_or(Ok(()), |us| above_zero("line_time_us", us))?;
        self.exposures_ms
            .iter()
            .try_for_each(|ms| above_zero("exposures_ms", *ms))?;
        if self.dark.is_some_and(|dark| !dark.is_finite()) {
            return Err(Fault::new("light_modulation.dark", "dark is no number"));
        }
        Ok(())
    }
}
