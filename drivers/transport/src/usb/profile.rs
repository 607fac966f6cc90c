//! The USB interface of a driver's instruments.

use super::address::UsbId;

/// What a driver knows of its instruments' USB interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UsbProfile {
    /// The ids of its instruments.
    pub ids: &'static [UsbId],
    /// The bulk endpoint that takes commands.
    pub command: u8,
    /// The bulk endpoints that answer.
    pub answers: &'static [u8],
    /// How transfers become bytes of a link.
    pub framing: UsbFraming,
}

/// How USB transfers travel on a byte link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UsbFraming {
    /// One frame a transfer: endpoint, length (u16, low byte first), payload. For languages in which endpoint and end
    /// of a transfer mean something; each transfer ends with a short packet.
    Transfers,
    /// The bytes as they are. For languages that frame themselves, on a single endpoint.
    Bytes,
}
