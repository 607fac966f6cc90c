//! What the lamp takes from its supply: a driver that keeps its power whatever the voltage, and takes more while it is
//! cold.

use crate::document::Darkroom;
use crate::output::warmup_excess;

/// Share of its rated voltage below which the lamp stays dark.
const LEAST_VOLTAGE: f64 = 0.8;

/// The state of the supply line, without any error of a meter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Electrical {
    /// RMS voltage, V.
    pub voltage_v: f64,
    /// RMS current, A.
    pub current_a: f64,
    /// Active power, W.
    pub power_w: f64,
}

impl Electrical {
    /// A line with this voltage and a lamp that is off.
    pub const fn idle(voltage_v: f64) -> Self {
        Self {
            voltage_v,
            current_a: 0.0,
            power_w: 0.0,
        }
    }

    /// A line with this voltage, and a lamp at its rated current or off it by the error of that, which was switched on
    /// `time_s` ago.
    pub fn illuminated(document: &Darkroom, voltage_v: f64, time_s: f64) -> Self {
        let lamp = &document.lamp;
        let power_w =
            lamp.power_w * (1.0 + lamp.power_warmup_share * warmup_excess(&document.injected_effects, time_s));
        let power_w = power_w * (1.0 + lamp.current_error_rel);
        Self {
            voltage_v,
            current_a: power_w / (voltage_v * lamp.power_factor),
            power_w,
        }
    }
}

/// Whether the lamp lights on a supply with these levels.
pub fn lights(document: &Darkroom, voltage_v: f64, limit_a: f64) -> bool {
    voltage_v >= LEAST_VOLTAGE * document.lamp.voltage_v
        && limit_a >= Electrical::illuminated(document, voltage_v, 0.0).current_a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cold_lamp_takes_more_by_its_share_of_the_excess_of_light() {
        let mut document = Darkroom::default();
        document.lamp.power_factor = 0.8;
        document.injected_effects.lamp_warmup.amplitude_rel = 0.05;
        let warm = Electrical::illuminated(&document, 24.0, 1e6);
        assert!((warm.power_w - 4.2).abs() < 1e-9 && (warm.current_a * 24.0 * 0.8 - 4.2).abs() < 1e-9);
        let cold = Electrical::illuminated(&document, 24.0, 0.0);
        assert!((cold.power_w / warm.power_w - 1.02).abs() < 1e-9);
    }

    #[test]
    fn it_stays_dark_below_its_voltage_and_its_current() {
        let document = Darkroom::default();
        assert!(lights(&document, 24.0, 0.35));
        assert!(!lights(&document, 12.0, 2.0) && !lights(&document, 24.0, 0.1));
    }
}
