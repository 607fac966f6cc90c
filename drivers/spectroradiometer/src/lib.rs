//! Spectroradiometer drivers, one module an instrument.

mod ooi;

pub use ooi::OceanOoiDriver;
