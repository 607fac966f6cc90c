//! Ratings of the measured light, each with uncertainty, and only where it applies.

mod light;
mod outdoor;
mod sector;

pub use light::{HazardDistance, RatedColour, hazard_distance, photon_flux, rated_colour, steps_from};
pub use outdoor::{OutdoorZones, outdoor};
pub use sector::{flux_share, sector_flux};
