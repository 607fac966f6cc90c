//! What a link is, and how one is opened.

use std::fmt;
use std::sync::Arc;

use async_trait::async_trait;
use isolux_device::{OpenError, Target};
use tokio::io::{AsyncRead, AsyncWrite};

use crate::UsbProfile;

/// A byte link.
pub trait Link: AsyncRead + AsyncWrite + Unpin + Send {}

impl<T: AsyncRead + AsyncWrite + Unpin + Send> Link for T {}

/// Opens links by address.
#[async_trait]
pub trait Links: Send + Sync {
    /// Opens `address`: a path (`/dev/ttyUSB0`, `COM3`), `tcp://host:port`, `modbus-tcp://host:port`, or `memory:name`.
    /// `line` applies to serial lines alone.
    ///
    /// # Errors
    /// [`LinkError`] with what the system said and what to do.
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError>;

    /// Opens the USB device that `address` (`usb:…`) means among those of `profile`. Links that are not the system's
    /// know it by its address like any other.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    async fn open_usb(
        &self,
        address: &str,
        line: LineSettings,
        _profile: &'static UsbProfile,
    ) -> Result<Box<dyn Link>, LinkError> {
        self.open(address, line).await
    }
}

#[async_trait]
impl<L: Links + ?Sized> Links for Arc<L> {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        (**self).open(address, line).await
    }

    async fn open_usb(
        &self,
        address: &str,
        line: LineSettings,
        profile: &'static UsbProfile,
    ) -> Result<Box<dyn Link>, LinkError> {
        (**self).open_usb(address, line, profile).await
    }
}

/// Parity bit of a serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// None.
    None,
    /// Even.
    Even,
    /// Odd.
    Odd,
}

/// Settings of a serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineSettings {
    /// Bits per second.
    pub baud: u32,
    /// 7 or 8.
    pub data_bits: u8,
    /// Parity bit.
    pub parity: Parity,
    /// 1 or 2.
    pub stop_bits: u8,
}

impl fmt::Display for LineSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parity = match self.parity {
            Parity::None => 'N',
            Parity::Even => 'E',
            Parity::Odd => 'O',
        };
        write!(f, "{} {}{parity}{}", self.baud, self.data_bits, self.stop_bits)
    }
}

/// A link that could not be opened.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{address}: {reason}")]
pub struct LinkError {
    /// The address.
    pub address: String,
    /// What the system said.
    pub reason: String,
    /// What to do about it.
    pub advice: Option<String>,
}

impl LinkError {
    /// The same as the failure to open `target`.
    pub fn opening(self, target: &Target) -> OpenError {
        OpenError::Link {
            target: target.to_string(),
            reason: self.reason,
            advice: self.advice,
        }
    }
}
