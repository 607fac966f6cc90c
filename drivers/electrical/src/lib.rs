//! Electrical instruments: power meters and supplies that switch a lamp in SCPI, by profiles in TOML; power meters on
//! Modbus/TCP; oscilloscopes that record a photodiode.

mod exchange;
mod instrument;
mod meter;
mod profile;
mod scope;
mod scope_profile;
mod supply;
mod wt300;

use isolux_transport::Driver;

pub use meter::SCPI_METER;
pub use scope::SCPI_SCOPE;
pub use supply::SCPI_SUPPLY;
pub use wt300::YOKOGAWA_WT300;

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[SCPI_METER, SCPI_SUPPLY, YOKOGAWA_WT300, SCPI_SCOPE];
