//! A recorder of a voltage over time: an oscilloscope or a digitiser, with a photodiode at its input.

use std::time::Duration;

use async_trait::async_trait;

use crate::{DeviceError, Identity};

/// A recorder of waveforms.
#[async_trait]
pub trait WaveformRecorder: Send + Sync {
    /// What the recorder said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// A *new* record that begins after the call and lasts at least `duration`, at `least_rate_hz` or faster.
    ///
    /// # Errors
    /// [`Unsupported`](DeviceError::Unsupported) for a duration and rate that its memory does not hold;
    /// [`Malformed`](DeviceError::Malformed) for what is no record.
    async fn record(&self, duration: Duration, least_rate_hz: f64) -> Result<VoltageRecord, DeviceError>;
}

/// A record.
#[derive(Debug, Clone, PartialEq)]
pub struct VoltageRecord {
    /// Samples, V.
    pub voltage_v: Vec<f64>,
    /// Samples a second, Hz.
    pub rate_hz: f64,
    /// Lowest and highest value that the range shows, V: a sample there may be anything beyond.
    pub range_v: (f64, f64),
    /// Step of the converter, V.
    pub step_v: f64,
}
