//! Directions that were read at rest after the sweeps: whether they say the same.
//!
//! Each is compared with the curves of its half-plane at the place where its light came from: play between encoder and
//! luminaire is out of the curves, and in a reading at rest. What both share (calibration, distance, the zero of an
//! angle) is no part of the uncertainty of their difference.

use isolux_record::plan::Block;
use isolux_record::{Quality, Reading, Role, Run};

use super::delay::Delay;
use super::merged::{self, Fitted};
use crate::drift::Drift;
use crate::error::ReduceError;
use crate::finding::{Evidence, Finding};

/// Share of cases that k = 2 covers.
const COVERED: f64 = 0.9545;

/// A direction that was read in motion and at rest.
#[derive(Debug, Clone)]
pub struct Check {
    /// The reading at rest, with its number in the record.
    rest: Reading,
    /// What each sweep says there.
    swept: Vec<InMotion>,
    /// Standard uncertainty of the difference, drift aside, lx.
    u_lx: f64,
    /// Largest light of its half-plane, lx.
    largest_lx: f64,
}

/// Light at a direction by one sweep: its share in that of all, lx, and when it read it, in seconds of the run and of
/// the lamp.
#[derive(Debug, Clone, Copy)]
struct InMotion {
    share: f64,
    lux: f64,
    time_s: f64,
    lamp_s: f64,
}

/// The readings at rest of a block beside what its sweeps say.
pub fn checks(run: &Run, block: &Block, fitted: &[Fitted<'_>], delay: Option<Delay>) -> Vec<Check> {
    let is_check = |row: &&Reading| row.role == Role::Check && row.block == block.name && row.quality == Quality::Ok;
    let rows = run.readings.rows.iter().filter(is_check);
    rows.filter_map(|row| check(row, fitted, delay)).collect()
}

fn check(row: &Reading, fitted: &[Fitted<'_>], delay: Option<Delay>) -> Option<Check> {
    let of_plane: Vec<&Fitted<'_>> = fitted
        .iter()
        .filter(|sweep| sweep.c_target_deg() == row.c_target_deg)
        .collect();
    let giving = merged::giving(&of_plane, row.gamma_target_deg);
    let first = giving.first()?;
    // Without two speeds play is not known: it is at most all of the displacement.
    let (play_deg, u_deg) = delay.map_or((0.0, first.shift.shift_deg / 3.0_f64.sqrt()), |delay| {
        (0.5 * delay.play_deg.0, 0.5 * delay.play_deg.1)
    });
    let gamma_deg = row.gamma_deg + f64::from(row.travel.signum()) * play_deg;
    let all = giving.iter().map(|sweep| sweep.weight(gamma_deg)).sum::<f64>();
    let share = |sweep: &Fitted<'_>| sweep.weight(gamma_deg) / all;
    let mean = |of: &dyn Fn(&Fitted<'_>) -> f64| giving.iter().map(|sweep| share(sweep) * of(sweep)).sum::<f64>();
    let slope = mean(&|sweep| sweep.along.curve.slope(gamma_deg).abs());
    // What sweeps have in common does not become less by their number.
    let u2 = |sweep: &Fitted<'_>| {
        let of_digit = sweep.digit_lx(gamma_deg) / 12.0_f64.sqrt();
        let parts = sweep.parts(gamma_deg).into_iter().chain([of_digit]);
        parts.map(|part| part * part).sum()
    };
    let u_swept = mean(&u2).sqrt();
    let u_rest = row
        .u_lx
        .unwrap_or(0.0)
        .hypot(row.digit_lx.unwrap_or(0.0) / 12.0_f64.sqrt());
    let swept = giving.iter().map(|sweep| {
        let time_s = sweep.time_s(gamma_deg);
        InMotion {
            share: share(sweep),
            lux: sweep.along.curve.at(gamma_deg),
            time_s,
            lamp_s: time_s - sweep.one.record.of.lamp_on_s.unwrap_or(0.0),
        }
    });
    Some(Check {
        rest: row.clone(),
        swept: swept.collect(),
        u_lx: u_swept.hypot(u_rest).hypot(u_deg * slope),
        largest_lx: of_plane.iter().map(|sweep| sweep.largest()).fold(0.0, f64::max),
    })
}

/// What the checks say.
#[derive(Debug, Clone, Default)]
pub struct Checked {
    /// One sentence; none without checks.
    pub note: Option<String>,
    /// Where they disagree with the sweeps.
    pub finding: Option<Finding>,
}

impl Checked {
    /// By readings at rest with the lamp's drift taken out of them and of the sweeps; `drift_at` gives it for a
    /// distance of the detector, and `rows` are those of the run with readings for its sweeps.
    ///
    /// # Errors
    /// Those of `drift_at`.
    pub fn of(
        checks: &[Check],
        rows: &[Reading],
        drift_at: impl Fn(f64) -> Result<Drift, ReduceError>,
    ) -> Result<Self, ReduceError> {
        let k = coverage_factor(checks.len());
        let mut compared = Vec::with_capacity(checks.len());
        for check in checks {
            let drift = drift_at(check.rest.distance_mm)?;
            let (difference_lx, u_lx) = check.difference_lx(&drift, rows);
            compared.push(Compared {
                check,
                rel: difference_lx / check.largest_lx,
                u_rel: k * u_lx / check.largest_lx,
            });
        }
        let far = |one: &Compared<'_>| one.rel.abs() / one.u_rel.max(f64::MIN_POSITIVE);
        let Some(worst) = compared.iter().max_by(|a, b| far(a).total_cmp(&far(b))) else {
            return Ok(Self::default());
        };
        let count = compared.len();
        let beyond: Vec<Evidence> = compared
            .iter()
            // What is no number agrees with nothing.
            .filter(|one| one.rel.is_nan() || one.rel.abs() > one.u_rel)
            .map(|one| evidence(&one.check.rest))
            .collect();
        let words = worst.words();
        Ok(Self {
            note: Some(format!(
                "{count} directions, drawn by the sweeps, were read at rest after them: in shares of U (k = {k:.2}, \
                 for so many) the largest difference is {words}"
            )),
            finding: (!beyond.is_empty()).then(|| Finding {
                what: format!(
                    "{} of the {count} directions that were read at rest after the sweeps disagree with these \
                     by more than U (k = {k:.2}, for so many), the most by {words}",
                    beyond.len()
                ),
                rows: beyond,
            }),
        })
    }
}

impl Check {
    /// Reading at rest less sweeps, and its standard uncertainty, lx.
    fn difference_lx(&self, drift: &Drift, rows: &[Reading]) -> (f64, f64) {
        let factor = |time_s: f64, lamp_s: f64| {
            let row = rows.partition_point(|row| row.time_s.unwrap_or_default() < time_s);
            drift.factor(row.min(rows.len().saturating_sub(1)) as u64, lamp_s)
        };
        let rest_s = self.rest.time_s.unwrap_or(0.0);
        let rest_lx = self.rest.illuminance_lx.unwrap_or(f64::NAN) / factor(rest_s, self.rest.lamp_s.unwrap_or(rest_s));
        let each = self
            .swept
            .iter()
            .map(|swept| swept.share * swept.lux / factor(swept.time_s, swept.lamp_s));
        let swept_lx = each.sum::<f64>();
        (rest_lx - swept_lx, self.u_lx.hypot(drift.u_rel() * swept_lx))
    }
}

/// One of them, in shares of the largest light of its half-plane.
struct Compared<'a> {
    check: &'a Check,
    rel: f64,
    u_rel: f64,
}

impl Compared<'_> {
    fn words(&self) -> String {
        let Reading {
            c_target_deg,
            gamma_target_deg,
            ..
        } = self.check.rest;
        format!(
            "{:+.2} % ± {:.2} % of the largest light, at C {c_target_deg}° γ {gamma_target_deg}°",
            100.0 * self.rel,
            100.0 * self.u_rel
        )
    }
}

fn evidence(row: &Reading) -> Evidence {
    Evidence {
        row: row.index,
        time_s: row.time_s,
        c_deg: row.c_target_deg,
        gamma_deg: row.gamma_target_deg,
        illuminance_lx: row.illuminance_lx,
    }
}

/// The k at which all of `count` directions are within k·u as often as one is within 2 u. Abramowitz and Stegun,
/// 26.2.23.
fn coverage_factor(count: usize) -> f64 {
    let beside = 0.5 * (1.0 - COVERED.powf(1.0 / count.max(1) as f64));
    let t = (-2.0 * beside.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coverage_factor_grows_with_the_count() {
        // Quantiles of the normal distribution at 0.97725, 0.997677, 0.999767.
        for (count, k) in [(1, 2.0), (10, 2.831), (100, 3.500)] {
            assert!(
                (coverage_factor(count) - k).abs() < 2e-3,
                "{count}: {}",
                coverage_factor(count)
            );
        }
    }
}
