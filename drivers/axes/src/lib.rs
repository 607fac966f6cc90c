//! Axis drivers, one module an instrument: each is an `AxisDriver`, and `polled` makes an axis of any of them.

mod ascii;
mod easi;
mod factory;
mod oriental;
mod polled;
mod zaber;

use isolux_transport::Driver;

pub use ascii::ASCII_AXIS;
pub use easi::PARKER_EASI;
pub use oriental::{ORIENTAL_AZ, OrientalAzDriver};
pub use zaber::{ZABER, ZaberDriver};

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[ZABER, ORIENTAL_AZ, PARKER_EASI, ASCII_AXIS];
