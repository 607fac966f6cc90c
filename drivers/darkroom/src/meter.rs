//! The lux meter behind its aperture: temperature, saturation, ranges, offset, noise, digits.

use crate::injected_effects::InjectedEffects;

/// Highest number of each range, lx (T-10A: ranges 1 to 5, four digits).
pub const RANGE_TOP_LX: [f64; 5] = [29.99, 299.9, 2999.0, 29_990.0, 299_900.0];

/// Last digit of range `range` (1 to 5), lx.
pub fn digit_lx(range: u8) -> f64 {
    10f64.powi(i32::from(range.clamp(1, 5)) - 3)
}

/// The range that the meter chooses by itself for `illuminance_lx`, coming from `present`: up when the present one
/// ends, down only when the reading has fallen well into the lower one.
pub fn auto_range(illuminance_lx: f64, present: u8) -> u8 {
    let fits = |range: u8, share: f64| illuminance_lx.abs() <= share * RANGE_TOP_LX[usize::from(range) - 1];
    let mut range = present.clamp(1, 5);
    while range < 5 && !fits(range, 1.0) {
        range += 1;
    }
    while range > 1 && fits(range - 1, 0.9) {
        range -= 1;
    }
    range
}

/// What the meter indicates for `illuminance_lx` on its aperture, without noise and digits, lx.
///
/// `range` 0 is "not known": no range error. The detector saturates as 1 − e^(−x), not by a polynomial.
pub fn indicated_lx(
    illuminance_lx: f64,
    ambient_c: f64,
    range: u8,
    gain_error_rel: f64,
    injected_effects: &InjectedEffects,
) -> f64 {
    let temperature = &injected_effects.temp_coefficient;
    let warm = 1.0 + temperature.coefficient_per_k * (ambient_c - temperature.reference_c);
    let current = illuminance_lx * warm;
    let bent = saturating(current, injected_effects.nonlinearity.inverse_scale_per_lx);
    let step = &injected_effects.range_step;
    let ranged = if range != 0 && f64::from(range) == step.range {
        bent * (1.0 + step.factor_rel)
    } else {
        bent
    };
    ranged * (1.0 + gain_error_rel) + injected_effects.dark_offset.offset_lx
}

/// x − k x² + …: what a detector gives that saturates exponentially.
pub fn saturating(x: f64, k: f64) -> f64 {
    if k == 0.0 {
        x
    } else {
        -(-2.0 * k * x).exp_m1() / (2.0 * k)
    }
}

/// `illuminance_lx` as range `range` shows it: rounded to its digit; `None` past the end of the range.
pub fn displayed_lx(illuminance_lx: f64, range: u8) -> Option<f64> {
    let digit = digit_lx(range);
    let steps = (illuminance_lx / digit).round();
    (steps.abs() <= 2999.0).then_some(steps * digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_range() {
        assert_eq!(displayed_lx(3.3749, 1), Some(3.37));
        assert_eq!(displayed_lx(30.2, 1), None);
        assert!((displayed_lx(30.24, 2).unwrap() - 30.2).abs() < 1e-12);
        assert_eq!(displayed_lx(-0.004, 1), Some(-0.0));
        assert_eq!(digit_lx(5), 100.0);
    }

    #[test]
    fn ranges_change_with_hysteresis() {
        assert_eq!(auto_range(28.0, 1), 1);
        assert_eq!(auto_range(28.0, 2), 2);
        assert_eq!(auto_range(26.0, 2), 1);
        assert_eq!(auto_range(31.0, 1), 2);
        assert_eq!(auto_range(5000.0, 1), 4);
    }

    #[test]
    fn the_chain_applies_each_error_once() {
        let mut injected_effects = InjectedEffects::default();
        injected_effects.dark_offset.offset_lx = 0.5;
        injected_effects.range_step.factor_rel = 0.01;
        injected_effects.range_step.range = 2.0;
        injected_effects.temp_coefficient.coefficient_per_k = 0.001;
        assert!((indicated_lx(100.0, 35.0, 2, 0.0, &injected_effects) - (100.0 * 1.01 * 1.01 + 0.5)).abs() < 1e-9);
        assert!((indicated_lx(100.0, 25.0, 3, 0.02, &injected_effects) - 102.5).abs() < 1e-9);
        assert!((saturating(1000.0, 1e-7) - (1000.0 - 0.1)).abs() < 1e-4);
        assert!((saturating(1000.0, -1e-7) - (1000.0 + 0.1)).abs() < 1e-4);
    }
}
