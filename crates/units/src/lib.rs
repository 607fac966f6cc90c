#![doc = include_str!("../README.md")]
//!
//! Where a wrong unit would move an axis or falsify a reading, at the traits of instruments, a number is a type of this
//! crate: a finite `f64` with one meaning. An axis never wraps, because its cable does not; negative values are data
//! (dark-subtracted noise), not errors.

pub mod digits;
pub mod json;
mod median;
mod quantity;

pub use median::median;
pub use quantity::{AxisAngle, Celsius, Lux, Millimetre, NotFinite};
