//! Readings for the tests of this crate.

use isolux_record::{Quality, Reading, ReadingKind, Role};

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
        electrical: isolux_record::Electrical::default(),
    }
}
