//! Spectroradiometer drivers, one module an instrument.

mod agreement;
mod line;
mod ooi;
mod stored;

use isolux_transport::Driver;

pub use ooi::{OCEAN_OOI, OceanOoiDriver};

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[OCEAN_OOI];
