//! Pictures of luminaires and light sources: each a function from data to an SVG string.

mod cartesian;
mod polar;
mod spectral_colour;
mod spectrum;

pub use cartesian::cartesian;
pub use polar::{PolarOptions, polar};
pub use spectrum::{SpectrumOptions, spectrum};
