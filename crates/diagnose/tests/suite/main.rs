//! The diagnosis of readings made here, of which everything is known.

mod changed;
mod noise;
mod shapes;
mod traps;
