//! Temperature of the room.

use crate::parts::Climate;

/// So far the room drifts before the building's heating or cooling holds it.
const MOST_DRIFT_K: f64 = 5.0;

/// Air temperature at `time_s` after the room was opened, °C: a slow drift and the cycle of the air conditioning.
pub fn temperature_c(climate: &Climate, time_s: f64) -> f64 {
    let cycle = (std::f64::consts::TAU * time_s / climate.swing_period_s).sin();
    let drift_k = (climate.drift_c_per_h * time_s / 3600.0).clamp(-MOST_DRIFT_K, MOST_DRIFT_K);
    climate.temperature_c + drift_k + climate.swing_c * cycle
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A scan of a month stays within what its thermometer reads.
    #[test]
    fn the_room_is_held_in_the_end() {
        let climate = Climate::default();
        let after = |hours: f64| temperature_c(&climate, hours * 3600.0) - climate.temperature_c;
        assert!((after(10.0) - 1.5).abs() <= climate.swing_c, "{}", after(10.0));
        assert!(
            (after(700.0) - MOST_DRIFT_K).abs() <= climate.swing_c,
            "{}",
            after(700.0)
        );
    }
}
