//! The temperature of the room.

use async_trait::async_trait;
use isolux_units::Celsius;
use tokio::time::Instant;

use crate::{DeviceError, Identity};

/// A thermometer.
#[async_trait]
pub trait Thermometer: Send + Sync {
    /// What the device said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// The temperature now.
    ///
    /// # Errors
    /// [`Fault`](DeviceError::Fault) when the sensor is broken or out of its range, besides any link error.
    async fn read(&self) -> Result<TemperatureReading, DeviceError>;
}

/// One temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TemperatureReading {
    /// The temperature.
    pub temperature: Celsius,
    /// When the answer arrived.
    pub at: Instant,
}
