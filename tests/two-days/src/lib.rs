//! An operator's two days: the first makes `luminaire.model.toml`, the second reads the same lamp again with one fault
//! in the room, and the model is diagnosed against it by the functions behind the commands.
//!
//! The room's physics (`isolux-darkroom`) shares nothing with the model's. Here alone both are at hand: what a fault
//! changes without noise, how strong that is above what the model's file knows, and what is left where nobody looked.

pub mod case;
pub mod days;
pub mod faults;
pub mod lamps;
pub mod oracle;
pub mod plans;
pub mod spectra;
pub mod strength;
pub mod suite;
pub mod tables;
pub mod truth;
