//! Ratings of a distribution by the rules of others.

mod outdoor;

pub use outdoor::{LcsZone, ZonalFlux, backlight_rating, uplight_rating};
