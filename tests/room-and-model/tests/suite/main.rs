//! The virtual darkroom and the model, which share no physics.

mod agreement;
mod colour;
mod interpolation;
