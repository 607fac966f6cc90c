//! Readings, samples and random numbers for the tests of this crate.

use isolux_record::{Quality, Reading, ReadingKind, Role};

use crate::samples::Sample;

/// SplitMix64: uniform and normal numbers.
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Of the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

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
        u_digit_cd: 0.0,
        display: None,
        lamp_s: None,
    }
}

/// A lit reading at 10 m with a digit of 0.01 lx.
pub fn reading(c_deg: f64, gamma_deg: f64, illuminance_lx: f64) -> Reading {
    Reading {
        index: 0,
        block: "lit".to_owned(),
        kind: ReadingKind::Lit,
        time_s: Some(2000.0),
        c_deg,
        gamma_deg,
        distance_mm: 10_000.0,
        travel: 1,
        range: 1,
        ambient_c: Some(25.0),
        illuminance_lx: Some(illuminance_lx),
        u_lx: Some(0.01 / 12.0_f64.sqrt()),
        quality: Quality::Ok,
        role: Role::Point,
        point: 0,
        repeat: 0,
        c_target_deg: c_deg,
        gamma_target_deg: gamma_deg,
        digit_lx: Some(0.01),
        integration_s: Some(0.5),
        raw: String::new(),
        session: 0,
        burning: None,
        lamp_s: None,
        electrical: isolux_record::Electrical::default(),
    }
}
