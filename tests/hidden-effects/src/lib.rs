//! Observations in which an effect is hidden, made by the virtual darkroom's physics: individual LEDs, a floor in
//! patches, rotation matrices. Nothing here knows the models under test; they meet in files.

pub mod case;
pub mod follow_up;
pub mod no_noise;
mod oracle;
pub mod outside;
pub mod plan;
pub mod random;
pub mod recipe;
pub mod suite;
pub mod tables;
pub mod truth;
pub mod unforeseen;
