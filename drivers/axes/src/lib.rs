//! Axis drivers, one module an instrument.

mod zaber;

pub use zaber::ZaberDriver;
