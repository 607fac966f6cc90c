//! How a device call fails, with the evidence.

use std::fmt;
use std::time::Duration;

/// The coarse kind of a [`DeviceError`]: what a caller decides by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// No answer, or no standstill, within the deadline. The line was drained; trying again is safe.
    Timeout,
    /// The link is gone. Reopen it, check the identity, then repeat the point.
    Disconnected,
    /// Another process has taken the instrument over and may be working with it: nothing was sent.
    TakenOver,
    /// Bytes arrived that are no answer: damaged, out of order, wrong checksum. Trying again is safe.
    Malformed,
    /// The device understood and said no.
    Refused,
    /// The wanted position is outside the axis' limits; nothing moved.
    OutOfTravel,
    /// This instrument cannot do that.
    Unsupported,
    /// The device reports, or was seen to have, a fault of its own: stall, lost reference, broken head.
    Fault,
}

/// A failed call to an instrument.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// No answer in time.
    #[error("{device}: no answer to {action} within {waited:?} (received {})", Bytes(received))]
    Timeout {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// How long was waited.
        waited: Duration,
        /// What had arrived by then, if anything.
        received: Vec<u8>,
    },
    /// The link is gone.
    #[error("{device}: the link broke during {action}: {reason}")]
    Disconnected {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// What the operating system said.
        reason: String,
    },
    /// The instrument belongs to another process now.
    #[error("{device}: {action} was not sent: {reason}")]
    TakenOver {
        /// Driver and target.
        device: String,
        /// What was to be asked.
        action: String,
        /// Which process has it.
        reason: String,
    },
    /// An answer that is none.
    #[error("{device}: unusable answer to {action}: {reason} (received {})", Bytes(frame))]
    Malformed {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// What is wrong with it.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
    /// The device said no.
    #[error("{device}: refused {action}: {reason} (received {})", Bytes(frame))]
    Refused {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// The device's reason.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
    /// Outside the travel of the axis.
    #[error("{device}: {wanted}{unit} is outside its travel of {from}{unit} to {to}{unit}; nothing moved")]
    OutOfTravel {
        /// Driver and target.
        device: String,
        /// The position asked for.
        wanted: f64,
        /// Lower limit.
        from: f64,
        /// Upper limit.
        to: f64,
        /// The unit, as it follows a number.
        unit: &'static str,
    },
    /// Not something this instrument can do.
    #[error("{device}: cannot {action}: {reason}")]
    Unsupported {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// Why not.
        reason: String,
    },
    /// The device is at fault.
    #[error("{device}: fault during {action}: {reason} (received {})", Bytes(evidence))]
    Fault {
        /// Driver and target.
        device: String,
        /// What was asked.
        action: String,
        /// Which fault: the device's flag or what the driver saw.
        reason: String,
        /// The bytes that say so.
        evidence: Vec<u8>,
    },
}

impl DeviceError {
    /// An answer of `device` to `action` that is none.
    pub fn malformed(device: &str, action: impl Into<String>, reason: impl Into<String>, frame: Vec<u8>) -> Self {
        Self::Malformed {
            device: device.to_owned(),
            action: action.into(),
            reason: reason.into(),
            frame,
        }
    }

    /// The no of `device` to `action`.
    pub fn refused(device: &str, action: impl Into<String>, reason: impl Into<String>, frame: Vec<u8>) -> Self {
        Self::Refused {
            device: device.to_owned(),
            action: action.into(),
            reason: reason.into(),
            frame,
        }
    }

    /// What `device` cannot do.
    pub fn unsupported(device: &str, action: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Unsupported {
            device: device.to_owned(),
            action: action.into(),
            reason: reason.into(),
        }
    }

    /// A fault of `device` itself during `action`.
    pub fn fault(device: &str, action: impl Into<String>, reason: impl Into<String>, evidence: Vec<u8>) -> Self {
        Self::Fault {
            device: device.to_owned(),
            action: action.into(),
            reason: reason.into(),
            evidence,
        }
    }

    /// The coarse kind.
    pub const fn kind(&self) -> ErrorKind {
        match self {
            Self::Timeout { .. } => ErrorKind::Timeout,
            Self::Disconnected { .. } => ErrorKind::Disconnected,
            Self::TakenOver { .. } => ErrorKind::TakenOver,
            Self::Malformed { .. } => ErrorKind::Malformed,
            Self::Refused { .. } => ErrorKind::Refused,
            Self::OutOfTravel { .. } => ErrorKind::OutOfTravel,
            Self::Unsupported { .. } => ErrorKind::Unsupported,
            Self::Fault { .. } => ErrorKind::Fault,
        }
    }

    /// Driver and target of the device that failed.
    pub fn device(&self) -> &str {
        match self {
            Self::Timeout { device, .. }
            | Self::Disconnected { device, .. }
            | Self::TakenOver { device, .. }
            | Self::Malformed { device, .. }
            | Self::Refused { device, .. }
            | Self::OutOfTravel { device, .. }
            | Self::Unsupported { device, .. }
            | Self::Fault { device, .. } => device,
        }
    }
}

/// Bytes for people: printable ones as text, the rest as `\x..`, long ones cut.
struct Bytes<'a>(&'a [u8]);

impl fmt::Display for Bytes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 80;
        if self.0.is_empty() {
            return f.write_str("nothing");
        }
        write!(f, "\"{}\"", self.0[..self.0.len().min(SHOWN)].escape_ascii())?;
        if self.0.len() > SHOWN {
            write!(f, "… of {} bytes", self.0.len())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_who_what_and_what_arrived() {
        let error = DeviceError::Malformed {
            device: "konica-t10a:/dev/ttyUSB1".into(),
            action: "read".into(),
            reason: "check characters are 00, computed 03".into(),
            frame: b"\x0200101".to_vec(),
        };
        assert_eq!(
            error.to_string(),
            "konica-t10a:/dev/ttyUSB1: unusable answer to read: check characters are 00, computed 03 (received \"\\x0200101\")"
        );
        assert_eq!(error.kind(), ErrorKind::Malformed);
        assert_eq!(Bytes(&[0; 200]).to_string().matches("\\x00").count(), 80);
        assert!(Bytes(&[]).to_string().contains("nothing"));
    }
}
