//! Quantities that an instrument is told or tells, as types, and the digits that a number deserves.
//!
//! Where a wrong unit would move an axis or falsify a reading, at the traits of instruments, a number is a type of this
//! crate: a finite `f64` with one meaning. An axis never wraps, because its cable does not; negative values are data
//! (dark-subtracted noise), not errors.

pub mod digits;
pub mod json;
mod quantity;

pub use quantity::{AxisAngle, Celsius, Lux, Millimetre, NotFinite};
