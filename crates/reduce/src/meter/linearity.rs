//! True over shown illuminance (ISO/CIE 19476, f3), linear over the logarithm of the illuminance and held at both ends
//! of its table.

use isolux_record::station::Linearity;
use isolux_record::{Reading, ReadingKind};
use isolux_units::digits::significant;

use super::found::{Found, is_lit};

/// The effect of a model that does nearly the same.
pub const EFFECT: &str = "nonlinearity";

/// What non-linearity does to these rows, whose meter shows `offset_lx` without light.
pub fn of(stated: &Linearity, rows: &[Reading], offset_lx: f64, corrected: bool) -> Found {
    let signal_lx = |row: &Reading| row.illuminance_lx.map(|lux| lux - offset_lx);
    let factor = |row: &Reading| match row.kind {
        ReadingKind::Capped => 1.0,
        _ => signal_lx(row).map_or(1.0, |lux| factor_at(stated, lux)),
    };
    let lit = rows.iter().filter(|row| is_lit(row));
    let largest_lx = lit.filter_map(signal_lx).fold(0.0, f64::max);
    let last_lx = stated.illuminance_lx.last().copied().unwrap_or(0.0);
    let beyond = largest_lx > last_lx;
    Found {
        missing: beyond.then(|| {
            let largest = significant(largest_lx, 4);
            format!("readings of up to {largest} lx are beyond luxmeter.linearity, which ends at {last_lx} lx")
        }),
        effect: effect(stated, largest_lx).filter(|_| corrected),
        ..Found::of(rows, rows.iter().map(factor).collect(), stated.u_rel, corrected)
    }
}

/// The factor at an illuminance.
fn factor_at(stated: &Linearity, lux: f64) -> f64 {
    let (at, factors) = (&stated.illuminance_lx, &stated.factor);
    let above = at.partition_point(|other| *other < lux);
    match (above.checked_sub(1), at.get(above)) {
        (Some(below), Some(_)) => {
            let [from, here, to] = [at[below], lux, at[above]].map(f64::ln);
            factors[below] + (factors[above] - factors[below]) * (here - from) / (to - from)
        }
        (Some(below), None) => factors[below],
        (None, _) => factors.first().copied().unwrap_or(1.0),
    }
}

/// E/(1 + kE) as near to the table as it comes, up to the largest reading.
fn effect(stated: &Linearity, largest_lx: f64) -> Option<String> {
    let (mut above, mut below) = (0.0, 0.0);
    for step in 1..=20 {
        let lux = largest_lx * f64::from(step) / 20.0;
        above += lux * (1.0 - 1.0 / factor_at(stated, lux));
        below += lux * lux;
    }
    let k = above / below;
    (k.is_finite() && k != 0.0).then(|| format!("name = \"{EFFECT}\"\ninverse_scale_per_lx = {k:e}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::reading;

    #[test]
    fn factors_are_linear_over_the_logarithm_and_held() {
        let stated = Linearity {
            illuminance_lx: vec![1.0, 100.0, 1000.0],
            factor: vec![1.0, 1.002, 1.005],
            u_rel: 0.0004,
        };
        for (lux, expected) in [(-0.2, 1.0), (0.5, 1.0), (10.0, 1.001), (100.0, 1.002), (5000.0, 1.005)] {
            assert!((factor_at(&stated, lux) - expected).abs() < 1e-12, "{lux}");
        }
        // The offset is no light.
        let capped = Reading {
            kind: ReadingKind::Capped,
            ..reading(0.0, 0.0, 40.0)
        };
        let rows = [reading(0.0, 0.0, 50.0), capped];
        let found = of(&stated, &rows, 40.0, true);
        assert!((found.factors[0] - 1.001).abs() < 1e-12 && found.factors[1] == 1.0);
        assert!(found.u_rel == 0.0004 && found.missing.is_none());
        let left_out = of(&stated, &rows, 40.0, false);
        assert!((left_out.u_rel - 0.001_f64.hypot(0.0004)).abs() < 1e-12);
        let beyond = of(&stated, &[reading(0.0, 0.0, 2000.0)], 0.0, true);
        assert!(
            beyond
                .missing
                .unwrap()
                .contains("2000 lx are beyond luxmeter.linearity, which ends at 1000 lx")
        );
    }

    #[test]
    fn the_effect_of_a_model_is_the_table_of_the_same_law() {
        let k = 2e-6;
        let shown: Vec<f64> = (1..=200).map(|step| 10.0 * f64::from(step)).collect();
        let factor = shown.iter().map(|shown| 1.0 / (1.0 - k * shown)).collect();
        let stated = Linearity {
            illuminance_lx: shown,
            factor,
            u_rel: 0.0,
        };
        let text = effect(&stated, 2000.0).unwrap();
        let found: f64 = text.rsplit_once("= ").unwrap().1.trim().parse().unwrap();
        assert!((found / k - 1.0).abs() < 1e-3, "{text}");
    }
}
