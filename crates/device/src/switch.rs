//! Something that is on or off: the lamp, a shutter, a baffle.

use async_trait::async_trait;

use crate::{DeviceError, Identity};

/// A two-state device. What "on" means is the station's word: lamp lit, shutter *open*, baffle *in the beam*.
#[async_trait]
pub trait Switch: Send + Sync {
    /// What the device said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// Switches, then reads the state back and compares.
    ///
    /// # Errors
    /// [`Fault`](DeviceError::Fault) when the state read back is not the one that was set.
    async fn set(&self, on: bool) -> Result<(), DeviceError>;

    /// The state, read from the device.
    ///
    /// # Errors
    /// Any link error.
    async fn state(&self) -> Result<bool, DeviceError>;
}
