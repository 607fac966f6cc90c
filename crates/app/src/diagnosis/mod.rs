//! Where a model and observations disagree, and the measurement that would settle it.

pub mod diagnose;
pub mod investigate;
