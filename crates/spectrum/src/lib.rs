#![doc = include_str!("../README.md")]
//!
//! A [`Spectrum`] is linear between its points and zero outside them. Every integral is a sum at 1 nm over 360–830 nm,
//! the range of V(λ) (CIE 018:2019), of [`Spectrum::per_nm`], so that a number does not depend on the spacing of a
//! file.

pub mod action;
pub mod cct;
pub mod cie;
mod colour;
pub mod fidelity;
pub mod illuminant;
mod locus;
pub mod meter;
mod per_nm;
mod quantities;
pub mod rendering;
mod resample;
mod shape;
mod spectrum;
pub mod steps;
#[expect(clippy::approx_constant, reason = "a reflectance of 0.318 is not 1/π")]
mod tables;

pub use colour::{Chromaticity, Dominant, EQUAL_ENERGY, Tristimulus, dominant, spectrum_locus};
pub use quantities::{Quantities, quantities};
pub use resample::ResampleError;
pub use spectrum::{Spectrum, SpectrumError};
