//! Light on a sensor against closed forms, and the two directions of the simulation against each other.

mod bounds;
mod colour_effect;
mod direct;
mod generated;
mod inverse;
mod unequal;
