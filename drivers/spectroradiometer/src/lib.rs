//! Spectroradiometer drivers, one module an instrument.

mod agreement;
mod line;
mod ooi;
mod stored;

pub use ooi::OceanOoiDriver;
