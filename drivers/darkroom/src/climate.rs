//! Temperature of the room.

use crate::parts::Climate;

/// Air temperature at `time_s` after the room was opened, °C: a slow drift and the cycle of the air conditioning.
pub fn temperature_c(climate: &Climate, time_s: f64) -> f64 {
    let cycle = (std::f64::consts::TAU * time_s / climate.swing_period_s).sin();
    climate.temperature_c + climate.drift_c_per_h * time_s / 3600.0 + climate.swing_c * cycle
}
