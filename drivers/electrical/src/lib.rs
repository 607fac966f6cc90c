//! Electrical instruments in SCPI, by profiles in TOML: power meters, and supplies that switch a lamp.

mod instrument;
mod meter;
mod profile;
mod supply;

use isolux_transport::Driver;

pub use meter::SCPI_METER;
pub use supply::SCPI_SUPPLY;

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[SCPI_METER, SCPI_SUPPLY];
