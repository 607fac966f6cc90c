//! What comes of a request: its answer, or why there is none.

use std::error::Error;
use std::io;
use std::time::Duration;

use isolux_device::{DeviceError, ErrorKind};
use tokio::time::Instant;

use crate::owner::TakenOver;

/// Why a request has no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BusError {
    /// None came in time.
    Timeout {
        /// How long was waited.
        waited: Duration,
        /// What had arrived by then.
        received: Vec<u8>,
    },
    /// The link is gone; this bus will not come back.
    Disconnected {
        /// What the system said.
        reason: String,
    },
    /// Another process has taken the instrument over; this bus sends nothing more.
    TakenOver {
        /// Which.
        reason: String,
    },
    /// Bytes came that are none.
    Malformed {
        /// What is wrong with them.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
}

impl BusError {
    /// What the link said when it ended.
    pub(crate) fn of_link(error: &io::Error) -> Self {
        let reason = error.to_string();
        if error.get_ref().is_some_and(<dyn Error + Send + Sync>::is::<TakenOver>) {
            Self::TakenOver { reason }
        } else {
            Self::Disconnected { reason }
        }
    }

    /// The same, as the failure of `action` on `device`.
    pub fn during(self, device: &str, action: &str) -> DeviceError {
        let (device, action) = (device.to_owned(), action.to_owned());
        match self {
            Self::Timeout { waited, received } => DeviceError::Timeout {
                device,
                action,
                waited,
                received,
            },
            Self::Disconnected { reason } => DeviceError::Disconnected { device, action, reason },
            Self::TakenOver { reason } => DeviceError::TakenOver { device, action, reason },
            Self::Malformed { reason, frame } => DeviceError::Malformed {
                device,
                action,
                reason,
                frame,
            },
        }
    }

    /// Whether the same request may be answered when it is made again.
    pub const fn is_worth_another_try(&self) -> bool {
        !matches!(self, Self::Disconnected { .. } | Self::TakenOver { .. })
    }
}

/// Whether what failed with `kind` may succeed when it is asked again.
pub const fn worth_another_try(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::Timeout | ErrorKind::Malformed)
}

/// An answer, and when its request was sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exchanged<A> {
    /// The answer.
    pub answer: A,
    /// Just before the first byte of the request was written: what the answer says was true later, or the device is
    /// slow.
    pub sent: Instant,
}
