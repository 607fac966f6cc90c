//! Spectral files: TM-27 `.spdx`, pairs `.spd`, CGATS `.sp`, Speos `.spectrum`, CSV and vendors' text.

mod axis;
pub(crate) mod cgats;
mod characters;
mod checks;
pub(crate) mod columns;
mod density;
pub(crate) mod embedded;
pub(crate) mod file;
pub(crate) mod jcamp;
pub(crate) mod json;
pub(crate) mod macam;
mod point;
mod points;
mod quantity;
mod resample;
pub(crate) mod spdx;
pub(crate) mod speos;
pub(crate) mod table;
pub(crate) mod write;
mod write_cgats;
mod write_tm27;

pub use file::{Series, SpectrumFile};
pub use resample::Interpolation;
