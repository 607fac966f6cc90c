//! Pictures of luminaires and light sources: each a function from data to an SVG string.

mod cartesian;
mod chromaticity;
mod cone;
mod contour;
mod isocandela;
mod isolux;
mod polar;
mod scale_bar;
mod shown;
mod solid;
mod spectral_colour;
mod spectrum;
mod tm30;
mod zones;

pub use cartesian::cartesian;
pub use chromaticity::{Diagram, chromaticity};
pub use cone::{Cone, cone, cones};
pub use isocandela::isocandela;
pub use isolux::{IsoluxOptions, isolux};
pub use polar::{PolarOptions, PolarSoFar, polar, polar_so_far};
pub use solid::solid;
pub use spectrum::{SpectrumOptions, spectrum};
pub use tm30::tm30;
pub use zones::zones;
