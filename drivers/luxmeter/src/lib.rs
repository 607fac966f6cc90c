//! Lux meter drivers, one module an instrument.

mod t10a;

use isolux_transport::Driver;

pub use t10a::{KONICA_T10A, T10aDriver};

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[KONICA_T10A];
