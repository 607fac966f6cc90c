//! The instruments of a station: which drivers there are, what is connected, opened, checked, and who owns it.

pub mod bench;
pub mod catalogue;
pub mod check;
mod corrections;
pub mod devices;
pub mod identify;
pub mod owner;
pub(crate) mod roles;
pub mod session;
mod spectral_lux;
