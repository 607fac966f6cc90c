//! Drift of lamp and meter from the visits to the reference point.

use isolux_record::{Reading, ReadingKind};
use serde::Serialize;

/// How the reference readings changed, and what is done about it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Drift {
    /// Fewer than two visits: nothing is known.
    Unknown,
    /// No change beyond the uncertainty of the visits.
    None {
        /// Relative standard uncertainty that a drift within it leaves.
        u_rel: f64,
    },
    /// A straight line in time.
    Linear {
        /// Relative change per hour.
        rate_per_h: f64,
        /// Its standard uncertainty.
        u_rate_per_h: f64,
        /// Time at which the factor is 1, seconds since the lamp was switched on.
        centre_s: f64,
        /// Relative standard uncertainty of the correction.
        u_rel: f64,
    },
    /// Lines between the visits: they scatter more about a straight line than their uncertainty allows.
    Interpolated {
        /// Times of the visits.
        time_s: Vec<f64>,
        /// Reading ÷ mean of all visits.
        factor: Vec<f64>,
        /// Relative standard uncertainty of the correction.
        u_rel: f64,
    },
    /// The lamp was switched on more than once: every burning by its own visits, each with a clock of its own.
    ByBurning {
        /// The burnings that have readings of the distribution, in the order of the rows.
        burning: Vec<Burning>,
        /// Relative standard uncertainty of the correction, of the burning where it is largest.
        u_rel: f64,
    },
}

/// One burning of the lamp, from switching on to switching off.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Burning {
    /// Its first row.
    pub first_row: u64,
    /// Visits to the reference point in it; without any its level is not tied to that of the others.
    pub visits: usize,
    /// Mean of its visits ÷ mean of the visits of all burnings.
    pub level: f64,
    /// What changed about its own mean.
    pub drift: Drift,
}

/// A visit to the reference point: time in seconds, what was read there (corrected), its standard uncertainty.
pub type Visit = (f64, f64, f64);

/// The first rows of the burnings of the lamp: the first lit row, and every lit row that follows a lamp_off one, that the record
/// counts to another switching on, or whose clock, which starts with the lamp, is behind that of the row before. The clock
/// alone does not tell: after a long warm-up, or one that was set ahead, it reads more than before the lamp went out.
pub fn burnings(rows: &[Reading]) -> Vec<u64> {
    let (mut starts, mut last_s, mut off, mut counted) = (Vec::new(), f64::NEG_INFINITY, false, None);
    for row in rows {
        match row.kind {
            ReadingKind::LampOff => off = true,
            ReadingKind::Lit => {
                let time_s = row.time_s.unwrap_or(last_s);
                if starts.is_empty() || off || time_s < last_s || row.burning != counted {
                    starts.push(row.index);
                }
                (last_s, off, counted) = (time_s, false, row.burning);
            }
            ReadingKind::Baffled | ReadingKind::Capped => {}
        }
    }
    starts
}

/// The place in `starts` of the burning that a row belongs to.
pub fn burning_of(starts: &[u64], row: u64) -> usize {
    starts.partition_point(|start| *start <= row).saturating_sub(1)
}

impl Drift {
    /// The drift in the visits of several burnings, each (first row, visits as in [`Drift::of`]). A lamp comes back at another
    /// level and its clock at zero, so that no line leads from one burning into the next: each is brought to the mean of all
    /// visits by its own.
    ///
    /// # Errors
    /// The mean of the visits of a burning where it is not above zero.
    pub fn of_burnings(burnings: &[(u64, Vec<Visit>)]) -> Result<Self, f64> {
        if let [(_, visits)] = burnings {
            return Self::of(visits);
        }
        let value = |(_, value, _): &Visit| *value;
        let all: Vec<f64> = burnings
            .iter()
            .flat_map(|(_, visits)| visits.iter().map(value))
            .collect();
        if all.is_empty() {
            return Ok(Self::Unknown);
        }
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let (mut burning, mut worst) = (Vec::new(), 0.0_f64);
        for (first_row, visits) in burnings {
            let n = visits.len() as f64;
            let drift = Self::of(visits)?;
            let level = if visits.is_empty() {
                1.0
            } else {
                visits.iter().map(value).sum::<f64>() / n / mean
            };
            if level <= 0.0 || mean <= 0.0 {
                return Err(level * mean);
            }
            let u_level = visits.iter().map(|(_, _, u)| u * u).sum::<f64>().sqrt() / n.max(1.0) / (level * mean);
            worst = worst.max(drift.u_rel()).max(u_level);
            burning.push(Burning {
                first_row: *first_row,
                visits: visits.len(),
                level,
                drift,
            });
        }
        Ok(Self::ByBurning { burning, u_rel: worst })
    }

    /// The drift in visits (time, illuminance corrected for offset and stray light, its standard uncertainty); the times
    /// rise. The uncertainty of one visit is mostly the digit of the display, so a line through all visits is better than
    /// lines between them wherever it fits.
    ///
    /// # Errors
    /// The mean of the visits where it is not above zero.
    pub fn of(visits: &[Visit]) -> Result<Self, f64> {
        if visits.len() < 2 {
            return Ok(Self::Unknown);
        }
        let n = visits.len() as f64;
        let mean = visits.iter().map(|(_, value, _)| value).sum::<f64>() / n;
        if mean <= 0.0 {
            return Err(mean);
        }
        let u_one = (visits.iter().map(|(_, _, u)| u * u).sum::<f64>() / n).sqrt() / mean;
        let centre_s = visits.iter().map(|(time, _, _)| time).sum::<f64>() / n;
        let spread_s2 = visits.iter().map(|(time, _, _)| (time - centre_s).powi(2)).sum::<f64>();
        let slope = if spread_s2 > 0.0 {
            visits
                .iter()
                .map(|(time, value, _)| (time - centre_s) * (value / mean - 1.0))
                .sum::<f64>()
                / spread_s2
        } else {
            0.0
        };
        let residual2: f64 = visits
            .iter()
            .map(|(time, value, _)| (value / mean - 1.0 - slope * (time - centre_s)).powi(2))
            .sum();
        let freedom = (n - 2.0).max(1.0);
        let u_line = u_one / n.sqrt();
        if visits.len() > 3 && residual2 / freedom > 4.0 * u_one * u_one {
            return Ok(Self::Interpolated {
                time_s: visits.iter().map(|(time, _, _)| *time).collect(),
                factor: visits.iter().map(|(_, value, _)| value / mean).collect(),
                u_rel: u_one,
            });
        }
        let length_s = visits[visits.len() - 1].0 - visits[0].0;
        let u_slope = if spread_s2 > 0.0 { u_one / spread_s2.sqrt() } else { 0.0 };
        if slope.abs() > 2.0 * u_slope {
            return Ok(Self::Linear {
                rate_per_h: slope * 3600.0,
                u_rate_per_h: u_slope * 3600.0,
                centre_s,
                u_rel: u_line,
            });
        }
        // A drift that stays below twice its own uncertainty is spread evenly over ± slope·T/2: rectangular.
        Ok(Self::None {
            u_rel: u_line.hypot(slope.abs() * length_s / 2.0 / 3.0_f64.sqrt()),
        })
    }

    /// The factor by which the reading of row `row` at `time_s` is too high.
    pub fn factor(&self, row: u64, time_s: f64) -> f64 {
        match self {
            Self::ByBurning { burning, .. } => {
                let at = burning.partition_point(|burning| burning.first_row <= row).max(1) - 1;
                burning
                    .get(at)
                    .map_or(1.0, |burning| burning.level * burning.drift.factor(row, time_s))
            }
            Self::Unknown | Self::None { .. } => 1.0,
            Self::Linear {
                rate_per_h, centre_s, ..
            } => 1.0 + rate_per_h / 3600.0 * (time_s - centre_s),
            Self::Interpolated {
                time_s: times, factor, ..
            } => {
                let above = times.partition_point(|at| *at < time_s);
                match (above.checked_sub(1), times.get(above)) {
                    (None, _) => factor[0],
                    (Some(below), None) => factor[below],
                    (Some(below), Some(high)) => {
                        let share = (time_s - times[below]) / (high - times[below]);
                        factor[below] + share * (factor[above] - factor[below])
                    }
                }
            }
        }
    }

    /// Relative standard uncertainty of the correction, common to all readings.
    pub fn u_rel(&self) -> f64 {
        match self {
            Self::Unknown => 0.0,
            Self::None { u_rel }
            | Self::Linear { u_rel, .. }
            | Self::Interpolated { u_rel, .. }
            | Self::ByBurning { u_rel, .. } => *u_rel,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visits(f: impl Fn(f64) -> f64) -> Vec<(f64, f64, f64)> {
        (0..26)
            .map(|i| 1800.0 + 300.0 * f64::from(i))
            .map(|time| (time, f(time), 0.01 / 12.0_f64.sqrt()))
            .collect()
    }

    #[test]
    fn a_line_is_found_through_the_steps_of_the_display() {
        let falling = visits(|time| ((3.37 * (1.0 - 0.01 * (time - 1800.0) / 3600.0)) * 100.0).round() / 100.0);
        let drift = Drift::of(&falling).unwrap();
        assert!(
            matches!(drift, Drift::Linear { rate_per_h, .. } if (rate_per_h + 0.01).abs() < 0.0015),
            "{drift:?}"
        );
        let ratio = drift.factor(0, 1800.0) / drift.factor(0, 9300.0);
        assert!((ratio - 1.0 / (1.0 - 0.01 * 7500.0 / 3600.0)).abs() < 0.003);
        assert!(matches!(Drift::of(&visits(|_| 3.37)).unwrap(), Drift::None { .. }));
    }

    /// The lamp went out between two sessions, and its second warm-up took longer than the first session: its clock only rises.
    #[test]
    fn a_lamp_that_was_switched_on_again_is_another_burning_whatever_its_clock_reads() {
        let at = |index: u64, time_s: f64, burning: u32| Reading {
            index,
            time_s: Some(time_s),
            burning: Some(burning),
            ..crate::testing::reading(0.0, 0.0, 3.37)
        };
        let rows = [at(0, 1800.0, 1), at(1, 1810.0, 1), at(2, 2700.0, 2), at(3, 2710.0, 2)];
        assert_eq!(burnings(&rows), [0, 2]);
        // The clock was set back while the lamp went on burning: no line leads through both parts.
        let rows = [at(0, 1800.0, 1), at(1, 1810.0, 1), at(2, 900.0, 1)];
        assert_eq!(burnings(&rows), [0, 2]);
    }

    #[test]
    fn a_jump_is_no_line() {
        let drift = Drift::of(&visits(|time| if time > 5000.0 { 3.1 } else { 3.37 })).unwrap();
        assert!(matches!(drift, Drift::Interpolated { .. }));
        assert!((drift.factor(0, 2000.0) / drift.factor(0, 9000.0) - 3.37 / 3.1).abs() < 1e-9);
        assert!(Drift::of(&visits(|_| -0.1)).is_err_and(|mean| (mean + 0.1).abs() < 1e-12));
        assert_eq!(Drift::of(&[(0.0, 1.0, 0.1)]), Ok(Drift::Unknown));
    }
}
