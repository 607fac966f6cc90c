//! Readings, samples and random numbers for the tests of this crate.

pub use isolux_any_record::{Random, reading};

use crate::samples::Sample;

/// A sample where it stands in the grid, without noise and rounding.
pub fn sample(c_deg: f64, gamma_deg: f64, intensity_cd: f64) -> Sample {
    Sample {
        c_deg,
        gamma_deg,
        closing: false,
        true_c_deg: c_deg,
        true_gamma_deg: gamma_deg,
        intensity_cd,
        u_noise_cd: 0.0,
        u_curve_cd: None,
        u_digit_cd: 0.0,
        display: None,
        lamp_s: None,
    }
}
