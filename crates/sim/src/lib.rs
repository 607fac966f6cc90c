//! Light on the sensor: solvers over a luminaire and a sensor.

pub mod inverse;
mod patch;
mod rules;
pub mod sensor;
pub mod source;
pub mod table;
mod tiles;
