//! Spectroradiometer drivers, one module an instrument.

mod agreement;
mod in_motion;
mod line;
mod obp;
mod ooi;
mod place;
mod stored;

use isolux_transport::Driver;

pub use obp::{OCEAN_OBP, OceanObpDriver};
pub use ooi::{OCEAN_OOI, OceanOoiDriver};

/// The drivers of this crate. A new one is one entry here.
pub const DRIVERS: &[Driver] = &[OCEAN_OOI, OCEAN_OBP];
