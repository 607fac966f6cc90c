//! The OOI language of Ocean Optics USB2000+ and Flame-S spectrometers as a sans-IO codec: no clock, no I/O.
//!
//! The instrument has a USB endpoint for commands (0x01), one for short answers (0x81) and one for spectra (0x82). On a
//! byte link each USB transfer travels as one [`Frame`]: `endpoint u8, length u16 little-endian, payload`. Answers
//! carry no request number, so after a timeout or damage the line must be quiet before the next request. Sources: Ocean
//! Optics "USB2000+ Data Sheet", "Flame-S installation and operation manual"; SeaBreeze (python-seabreeze 2.11) for the
//! EEPROM slots and the irradiance blocks.

mod answer;
mod conversation;
mod frame;
mod request;

pub use answer::{Answer, BlockTag, EepromSlot, InstrumentStatus, NotAnAnswer, slots};
pub use conversation::Host;
pub use frame::{Endpoint, Frame, Framer, NotAFrame};
pub use request::{NotARequest, Request};

/// Pixels of the detector.
pub const PIXELS: usize = 2048;

/// Pixels that no light reaches (USB2000+, Flame-S).
pub const DARK_PIXELS: std::ops::Range<usize> = 6..21;

/// Integration time, µs.
pub const INTEGRATION_LIMITS_US: (u32, u32) = (1_000, 655_350_000);

/// Largest count.
pub const FULL_SCALE: u16 = 65_535;

/// Bytes of an irradiance block; the address counts bytes.
pub const IRRADIANCE_BLOCK: u16 = 60;
