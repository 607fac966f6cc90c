#![doc = include_str!("../README.md")]
//!
//! [`inverse`] integrates, without noise and with a bound on its own error; [`direct`] counts rays, in three samplings
//! of one law; [`noise`] says what the counting does to a result.

pub mod against;
mod angles;
pub mod array;
mod batch;
pub mod blur;
mod bound;
pub mod camera;
mod crossings;
mod cubature;
pub mod direct;
pub mod emission;
pub mod inverse;
pub mod noise;
pub mod optics;
mod patch;
mod polar;
mod polynomial;
mod product;
pub mod random;
pub mod rays;
mod rules;
pub mod sensor;
pub mod setup;
pub mod simulation;
mod sines;
pub mod source;
pub mod station;
pub mod stop;
mod strips;
mod sum;
pub mod table;
