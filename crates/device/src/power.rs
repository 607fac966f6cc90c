//! A power meter in the supply line of the lamp.

use std::time::Duration;

use async_trait::async_trait;
use tokio::time::Instant;

use crate::{DeviceError, Identity};

/// A power meter.
#[async_trait]
pub trait PowerMeter: Send + Sync {
    /// What the meter said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// A new value appears this often, and averages as long.
    fn update_interval(&self) -> Duration;

    /// A *new* reading, of nothing from before `not_before`.
    ///
    /// # Errors
    /// [`Timeout`](DeviceError::Timeout) at `deadline`; [`Malformed`](DeviceError::Malformed) for what is no reading. A
    /// quantity outside its range, or one that the meter does not have, is no error but another [`Quantity`].
    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<PowerReading, DeviceError>;
}

/// One quantity of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// A number, in the unit of its field.
    Measured(f64),
    /// Beyond the range. There is no number.
    OverRange,
    /// The meter has none, or was not asked for it.
    NoData,
}

impl Quantity {
    /// The number, when there is one.
    pub const fn value(self) -> Option<f64> {
        match self {
            Self::Measured(value) => Some(value),
            Self::OverRange | Self::NoData => None,
        }
    }
}

/// One reading of a power meter, all quantities of one update.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerReading {
    /// RMS voltage (mean for DC), V.
    pub voltage: Quantity,
    /// RMS current (mean for DC), A.
    pub current: Quantity,
    /// Active power, W.
    pub power: Quantity,
    /// Active power ÷ (voltage · current), −1 to 1.
    pub power_factor: Quantity,
    /// Nothing from before this moment contributed.
    pub began: Instant,
    /// Nothing from after this moment contributed.
    pub ended: Instant,
    /// Two exchanges agreed; otherwise the load or the supply is not steady, or answers were mixed up.
    pub steady: bool,
    /// Answers that were lost or damaged before this one, and asked for again.
    pub retries: u32,
    /// The answer as it came over the wire.
    pub evidence: Vec<u8>,
}
