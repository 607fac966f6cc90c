//! Axis drivers, one module an instrument.

mod zaber;

use isolux_transport::Driver;

pub use zaber::{ZABER, ZaberDriver};

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[ZABER];
