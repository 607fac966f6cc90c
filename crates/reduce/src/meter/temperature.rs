//! A reading is too large by 1 + α·(T − T₀) (ISO/CIE 19476, f6,T): by the run's own readings of the temperature.

use isolux_record::Reading;
use isolux_record::station::Temperature;

use super::found::{Found, is_lit};

/// The effect of a model that does the same.
pub const EFFECT: &str = "temp_coefficient";

/// What the temperature does to these rows.
pub fn of(stated: &Temperature, rows: &[Reading], corrected: bool) -> Found {
    let unknown = rows.iter().any(|row| is_lit(row) && row.ambient_c.is_none());
    if unknown || !rows.iter().any(is_lit) {
        return without_thermometer(stated);
    }
    let difference_k = |row: &Reading| row.ambient_c.map(|ambient_c| ambient_c - stated.reference_c);
    // What is behind the baffle may have none: it is a small part of the light.
    let factor = |row: &Reading| 1.0 / (1.0 + stated.coefficient_per_k * difference_k(row).unwrap_or(0.0));
    let lit = rows.iter().filter(|row| is_lit(row));
    let largest_k = lit.filter_map(difference_k).map(f64::abs).fold(0.0, f64::max);
    let u_rel = (stated.u_coefficient_per_k * largest_k).hypot(stated.coefficient_per_k * stated.u_temperature_k);
    let effect = format!(
        "name = \"{EFFECT}\"\ncoefficient_per_k = {:?}\nreference_c = {:?}\n",
        stated.coefficient_per_k, stated.reference_c
    );
    Found {
        effect: corrected.then_some(effect),
        ..Found::of(rows, rows.iter().map(factor).collect(), u_rel, corrected)
    }
}

/// Nothing to correct by: what the stated range of temperatures leaves, or nothing known.
fn without_thermometer(stated: &Temperature) -> Found {
    let begin = "the lux meter's temperature is not corrected: the run has no temperature of the room";
    let Some(most_k) = stated.max_difference_k else {
        return Found::unknown(format!(
            "{begin}, and the station no luxmeter.temperature.max_difference_k"
        ));
    };
    let u_rel = stated.coefficient_per_k.hypot(stated.u_coefficient_per_k) * most_k / 3.0_f64.sqrt();
    Found {
        u_rel,
        note: Some(format!(
            "{begin}; the uncertainty holds {:.2} % (k = 1) for it",
            100.0 * u_rel
        )),
        ..Found::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::reading;

    const STATED: Temperature = Temperature {
        coefficient_per_k: -0.001,
        u_coefficient_per_k: 0.0002,
        reference_c: 23.0,
        u_temperature_k: 0.5,
        max_difference_k: None,
    };

    fn at(ambient_c: Option<f64>) -> Vec<Reading> {
        vec![Reading {
            ambient_c,
            ..reading(0.0, 0.0, 100.0)
        }]
    }

    #[test]
    fn five_kelvin_are_taken_out_with_what_is_known_of_them() {
        let found = of(&STATED, &at(Some(28.0)), true);
        assert!((found.factors[0] - 1.0 / 0.995).abs() < 1e-12);
        assert!((found.u_rel - 0.001_f64.hypot(0.0005)).abs() < 1e-12, "{}", found.u_rel);
        assert!(found.effect.unwrap().contains("reference_c = 23.0"));
        let left_out = of(&STATED, &at(Some(28.0)), false);
        assert!(left_out.factors.is_empty() && left_out.effect.is_none());
        assert!((left_out.u_rel - (1.0 / 0.995 - 1.0_f64).hypot(found.u_rel)).abs() < 1e-12);
    }

    #[test]
    fn without_a_thermometer_its_range_stays_in_the_budget_or_nothing_is_known() {
        let found = of(&STATED, &at(None), true);
        assert!(found.missing.unwrap().contains("max_difference_k"));
        let bounded = Temperature {
            max_difference_k: Some(4.0),
            ..STATED
        };
        let found = of(&bounded, &at(None), true);
        let expected = 0.001_f64.hypot(0.0002) * 4.0 / 3.0_f64.sqrt();
        assert!((found.u_rel - expected).abs() < 1e-12 && found.factors.is_empty());
        assert!(found.note.unwrap().contains("the uncertainty holds 0.24 %"));
    }
}
