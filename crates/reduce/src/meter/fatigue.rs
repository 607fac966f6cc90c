//! Fatigue (ISO/CIE 19476, f5): under light E the loss L of responsivity goes to l·E/E₀ as dL/dt = (l·E/E₀ − L)/τ, and
//! back likewise. That law is that of one process; the standard states no law, so a part of the uncertainty is the
//! largest loss ÷ √12, as if it had any size up to that.

use isolux_record::station::Fatigue;
use isolux_record::{Reading, ReadingKind};

use super::found::{Found, is_lit};

/// What fatigue does to these rows, in their order, whose meter shows `offset_lx` without light. Between two readings
/// the light is that of the former; before the first the meter saw its light for as long as the lamp was on.
pub fn of(stated: &Fatigue, rows: &[Reading], offset_lx: f64, corrected: bool) -> Found {
    if rows.iter().any(|row| is_lit(row) && row.time_s.is_none()) {
        return Found::unknown("the lux meter's fatigue is not corrected: readings have no time".to_owned());
    }
    let mut loss = Loss::new(stated);
    let factors: Vec<f64> = rows.iter().map(|row| loss.factor(row, offset_lx)).collect();
    let largest = factors.iter().map(|factor| (factor - 1.0).abs()).fold(0.0, f64::max);
    // Without a loss there is still the uncertainty of none, under the largest light.
    let lit = rows
        .iter()
        .filter(|row| is_lit(row))
        .filter_map(|row| row.illuminance_lx);
    let most = lit.fold(0.0, f64::max) / stated.at_lx;
    let u_rel = (stated.u_loss_rel * most).hypot(largest / 12.0_f64.sqrt());
    Found::of(rows, factors, u_rel, corrected)
}

/// The loss as it goes on.
struct Loss<'a> {
    stated: &'a Fatigue,
    /// Time, loss, and what the loss goes to since then.
    last: Option<(f64, f64, f64)>,
}

impl<'a> Loss<'a> {
    const fn new(stated: &'a Fatigue) -> Self {
        Self { stated, last: None }
    }

    fn factor(&mut self, row: &Reading, offset_lx: f64) -> f64 {
        let (Some(time_s), Some(lux)) = (row.time_s, row.illuminance_lx) else {
            return 1.0;
        };
        let light = if row.kind == ReadingKind::Capped {
            0.0
        } else {
            lux - offset_lx
        };
        let end = self.stated.loss_rel * light / self.stated.at_lx;
        let loss = match self.last {
            Some((before_s, loss, end)) => end + (loss - end) * self.left((time_s - before_s).max(0.0)),
            None => end * (1.0 - self.left(row.lamp_s.unwrap_or(0.0).max(0.0))),
        };
        self.last = Some((time_s, loss, end));
        1.0 / (1.0 - loss)
    }

    /// What of a difference is left after this time.
    fn left(&self, seconds: f64) -> f64 {
        (-seconds / self.stated.time_constant_s).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::reading;

    #[test]
    fn responsivity_falls_under_light_and_comes_back_in_the_dark() {
        let stated = Fatigue {
            loss_rel: 0.004,
            u_loss_rel: 0.001,
            at_lx: 1000.0,
            time_constant_s: 600.0,
        };
        let at = |time_s: f64, kind: ReadingKind, lux: f64| Reading {
            kind,
            time_s: Some(time_s),
            lamp_s: Some(time_s),
            ..reading(0.0, 0.0, lux)
        };
        let rows = [
            at(0.0, ReadingKind::Lit, 500.0),
            at(600.0, ReadingKind::Lit, 500.0),
            at(6000.0, ReadingKind::Capped, 0.0),
            at(6600.0, ReadingKind::Lit, 500.0),
        ];
        let found = of(&stated, &rows, 0.0, true);
        let e = std::f64::consts::E;
        let end = 0.002;
        let losses: Vec<f64> = found.factors.iter().map(|factor| 1.0 - 1.0 / factor).collect();
        let expected = [
            0.0,
            end * (1.0 - 1.0 / e),
            end * (1.0 - (-10.0_f64).exp()),
            end * (1.0 - (-10.0_f64).exp()) / e,
        ];
        for (loss, expected) in losses.iter().zip(expected) {
            assert!((loss - expected).abs() < 1e-12, "{losses:?}");
        }
        let largest = found.factors[2] - 1.0;
        assert!((found.u_rel - 0.0005_f64.hypot(largest / 12.0_f64.sqrt())).abs() < 1e-12);
        assert!(of(&stated, &rows, 0.0, false).factors.is_empty());
        let untimed = [reading(0.0, 0.0, 500.0)].map(|row| Reading { time_s: None, ..row });
        assert!(of(&stated, &untimed, 0.0, true).missing.is_some());
    }
}
