//! The Ocean Binary Protocol (OBP) of STS spectrometers as a sans-IO codec: no clock, no I/O.
//!
//! A message has a header of 44 bytes, a payload, a checksum of 16 bytes (MD5, or none) and a footer. Every request is
//! answered: queries with data, commands with an acknowledgement. The field "regarding" of a request comes back in its
//! answer where the instrument supports it, and then tells late answers from others.
//! Sources: Ocean Optics, "STS Data Sheet", rev. 201612, and OBPMessageTypes.h of SeaBreeze (python-seabreeze 2.11).

mod answer;
mod conversation;
mod message;
mod request;

pub use answer::{Answer, Value};
pub use conversation::Host;
pub use message::{Flags, Message, NotAMessage, error_text};
pub use request::Request;

/// Pixels of an STS. It has no dark ones.
pub const PIXELS: usize = 1024;

/// Integration time of an STS, µs.
pub const INTEGRATION_LIMITS_US: (u32, u32) = (10, 85_000_000);

/// Largest count of an STS: 14 bits.
pub const FULL_SCALE: u16 = 16_383;
