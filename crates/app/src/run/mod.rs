//! Run directories after the scan: found in a folder, read, shown again as events, reduced.

pub mod folder;
pub mod monte_carlo;
pub mod record;
pub mod reduce;
pub mod replay;
pub mod rest;
