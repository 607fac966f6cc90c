//! Quantities and angles of goniophotometry as types.
//!
//! A unit is a meaning: cd is not cd/klm, a C half-plane wraps and a γ does not, an axis never wraps because its
//! cable does not. Every type holds a finite `f64`; negative values are data (dark-subtracted noise), not errors.
//! There is no blanket arithmetic between quantities: the physics that links them is a named function.

mod angle;
pub mod digits;
mod quantity;

pub use angle::{AxisAngle, CPlane, Degrees, Gamma, GammaOutOfRange};
pub use quantity::{
    Candela, CandelaPerKilolumen, Celsius, Lumen, LumenPerWatt, Lux, Millimetre, Nanometre, NotFinite, Second,
    WattPerSquareMetre,
};
