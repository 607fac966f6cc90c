//! What a model says: a scene from any input, the map of a lit sensor, sweeps, predicted readings.

pub mod array_files;
pub(crate) mod in_motion;
mod light_so_far;
pub(crate) mod memory;
pub mod predict;
pub mod scene;
pub mod sensor_so_far;
pub mod simulate;
pub mod sweep;
