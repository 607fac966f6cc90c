//! Lux meter drivers, one module an instrument.

mod t10a;

pub use t10a::{T10aDriver, display_lx};
