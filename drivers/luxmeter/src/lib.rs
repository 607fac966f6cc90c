//! Lux meter drivers, one module an instrument: each is a `Language`, and `meter` makes a device of any of them.

mod ascii;
mod confirmed;
mod connected;
mod language;
mod mavo;
mod meter;
mod modbus;
mod p9710;
mod t10a;
mod unit;

use isolux_transport::Driver;

pub use ascii::ASCII_LUX;
pub use mavo::GOSSEN_MAVO_USB;
pub use modbus::MODBUS_LUX;
pub use p9710::GIGAHERTZ_P9710;
pub use t10a::KONICA_T10A;

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[KONICA_T10A, GOSSEN_MAVO_USB, GIGAHERTZ_P9710, MODBUS_LUX, ASCII_LUX];
