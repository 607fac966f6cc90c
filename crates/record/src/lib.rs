//! The documents of a bench: station, plan, job, the run directory with its append-only readings, observations.
//!
//! Everything here is data on disk and its validation. Nothing here asks a clock: whoever writes a record says when.

pub mod observation;
pub mod reading;

pub use reading::{Quality, Reading, ReadingKind, Role, UnknownWord};
