//! Spectra, photopic weighting and colour.
//!
//! A [`Spectrum`] is linear between its points and zero outside them. Every integral is the sum at 1 nm over
//! 360–830 nm, the range of V(λ) (CIE 018:2019), so that a number does not depend on the spacing of a file.

pub mod cie;
mod spectrum;

pub use spectrum::{Spectrum, SpectrumError};
