//! Drift of lamp and meter from the visits to the reference point.

use isolux_record::{Reading, ReadingKind, Station};
use isolux_units::json::nan_if_null;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the reference readings changed, and what is done about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Drift {
    /// Fewer than two visits, or not corrected: what a lamp that counts as stable may do in that time.
    Unknown {
        /// Relative standard uncertainty that stays.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rel: f64,
    },
    /// No change beyond the uncertainty of the visits.
    None {
        /// Relative standard uncertainty that a drift within it leaves.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rel: f64,
        /// What the relative change per hour may be: its root mean square.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rate_per_h: f64,
        /// Middle of the visits, seconds since the lamp was switched on.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        centre_s: f64,
    },
    /// A straight line in the time since the lamp was switched on.
    Linear {
        /// Relative change per hour.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        rate_per_h: f64,
        /// Its standard uncertainty.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rate_per_h: f64,
        /// Time at which the factor is 1, seconds since the lamp was switched on.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        centre_s: f64,
        /// Relative standard uncertainty of the correction.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rel: f64,
    },
    /// Lines between the visits: they scatter more about a straight line than their uncertainty allows.
    Interpolated {
        /// Times of the visits, seconds since the lamp was switched on.
        lamp_s: Vec<f64>,
        /// Reading ÷ mean of all visits.
        factor: Vec<f64>,
        /// Relative standard uncertainty of the correction.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rel: f64,
    },
    /// The lamp was switched on more than once and came back at another level: every burning by its own visits.
    ByBurning {
        /// The burnings that have readings of the distribution, in the order of the rows.
        burning: Vec<Burning>,
        /// Relative standard uncertainty of the correction, of the burning where it is largest.
        #[serde(deserialize_with = "nan_if_null")]
        #[schemars(with = "Option<f64>")]
        u_rel: f64,
    },
}

/// One burning of the lamp, from switching on to switching off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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

/// A visit to the reference point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// Number of its row.
    pub row: u64,
    /// Seconds since the lamp was switched on.
    pub lamp_s: f64,
    /// What was read, corrected for offset and stray light.
    pub value: f64,
    /// Standard uncertainty of it.
    pub u: f64,
    /// One digit of the display.
    pub digit: f64,
}

/// When a lamp counts as stable: what it may do where nobody looks at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stability {
    /// (max − min)/mean of its light over the window.
    pub spread_rel: f64,
    /// Length of the window.
    pub window_s: f64,
}

impl Stability {
    /// The criterion of a station; EN 13032-4 where it states none.
    pub fn of(station: &Station) -> Self {
        let stable = station.lamp().and_then(|lamp| lamp.stable.as_ref());
        Self {
            spread_rel: stable.map_or(0.005, |stable| stable.spread_rel),
            window_s: stable.map_or(900.0, |stable| stable.window_s),
        }
    }

    /// Relative standard uncertainty of a level over `seconds` without a visit. A lamp that just passes the criterion
    /// and goes on as it did changes by the spread in every window: any reading lies within half of that change of the
    /// middle.
    pub fn u_rel(self, seconds: f64) -> f64 {
        0.5 * self.spread_rel * (seconds / self.window_s).max(1.0) / 3.0_f64.sqrt()
    }
}

/// One burning of the lamp as the drift is taken from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// Its first row.
    pub first_row: u64,
    /// Its visits to the reference point.
    pub visits: Vec<Visit>,
    /// Relative standard uncertainty of its level where the visits are too few.
    pub unknown_rel: f64,
}

/// The first rows of the burnings of the lamp: the first lit row, and every lit row that follows a lamp_off one, that
/// the record counts to another switching on, or whose clock, which starts with the lamp, is behind that of the row
/// before. The clock alone does not tell: after a long warm-up, or one that was set ahead, it reads more than before
/// the lamp went out.
pub fn burnings(rows: &[Reading]) -> Vec<u64> {
    let (mut starts, mut last_s, mut off, mut counted) = (Vec::new(), f64::NEG_INFINITY, false, None);
    for row in rows {
        match row.kind {
            ReadingKind::LampOff => off = true,
            ReadingKind::Lit => {
                let lamp_s = row.lamp_age_s().unwrap_or(last_s);
                if starts.is_empty() || off || lamp_s < last_s || row.burning != counted {
                    starts.push(row.index);
                }
                (last_s, off, counted) = (lamp_s, false, row.burning);
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
    /// The drift in the visits of several burnings. A lamp that comes back as it was is followed by its age alone,
    /// whichever burning it is. One that comes back at another level has no line from one burning into the next: each is
    /// brought to the mean of all visits by its own.
    ///
    /// # Errors
    /// The mean of the visits of a burning where it is not above zero.
    pub fn of_burnings(burnings: &[Seen]) -> Result<Self, f64> {
        if let [one] = burnings {
            return Self::of(&one.visits, one.unknown_rel);
        }
        let all: Vec<Visit> = burnings.iter().flat_map(|seen| seen.visits.iter().copied()).collect();
        if all.is_empty() {
            let u_rel = burnings.iter().map(|seen| seen.unknown_rel).fold(0.0, f64::max);
            return Ok(Self::Unknown { u_rel });
        }
        if let Some(by_age) = Self::by_age(burnings, &all)? {
            return Ok(by_age);
        }
        let mean = mean_of(&all);
        let (mut burning, mut worst) = (Vec::new(), 0.0_f64);
        for seen in burnings {
            let visits = &seen.visits;
            let drift = Self::of(visits, seen.unknown_rel)?;
            let level = if visits.is_empty() { 1.0 } else { mean_of(visits) / mean };
            if level <= 0.0 || mean <= 0.0 {
                return Err(level * mean);
            }
            let u_level = u_of_mean(visits) / (level * mean);
            worst = worst.max(drift.u_rel().hypot(u_level));
            burning.push(Burning {
                first_row: seen.first_row,
                visits: visits.len(),
                level,
                drift,
            });
        }
        Ok(Self::ByBurning { burning, u_rel: worst })
    }

    /// The drift of all burnings by the age of the lamp. None where a burning was not visited or its visits lie off it
    /// by more than twice the uncertainty of their mean, and where the visits scatter about a straight line.
    ///
    /// # Errors
    /// The mean of all visits where it is not above zero.
    fn by_age(burnings: &[Seen], all: &[Visit]) -> Result<Option<Self>, f64> {
        let drift = Self::of(all, 0.0)?;
        let mean = mean_of(all);
        let mut u_level = 0.0_f64;
        for Seen { visits, .. } in burnings {
            let off = visits
                .iter()
                .map(|visit| visit.value / drift.factor(0, visit.lamp_s) - mean);
            let off = off.sum::<f64>() / visits.len() as f64;
            let u = u_of_mean(visits);
            if visits.is_empty() || off.is_nan() || off.abs() > 2.0 * u {
                return Ok(None);
            }
            u_level = u_level.max(u / mean);
        }
        let with_level = |u_rel: f64| u_rel.hypot(u_level);
        Ok(match drift {
            Self::None {
                u_rel,
                u_rate_per_h,
                centre_s,
            } => Some(Self::None {
                u_rel: with_level(u_rel),
                u_rate_per_h,
                centre_s,
            }),
            Self::Linear {
                rate_per_h,
                u_rate_per_h,
                centre_s,
                u_rel,
            } => Some(Self::Linear {
                rate_per_h,
                u_rate_per_h,
                centre_s,
                u_rel: with_level(u_rel),
            }),
            Self::Unknown { .. } | Self::Interpolated { .. } | Self::ByBurning { .. } => None,
        })
    }

    /// The drift in the visits of one burning, `unknown_rel` where they are fewer than two. The uncertainty of one visit
    /// is mostly the digit of the display, so a line through all visits is better than lines between them wherever it
    /// fits.
    ///
    /// # Errors
    /// The mean of the visits where it is not above zero.
    pub fn of(visits: &[Visit], unknown_rel: f64) -> Result<Self, f64> {
        if visits.len() < 2 {
            return Ok(Self::Unknown { u_rel: unknown_rel });
        }
        let n = visits.len() as f64;
        let mean = mean_of(visits);
        // A mean that is no number is not above zero either.
        if mean.is_nan() || mean <= 0.0 {
            return Err(mean);
        }
        let u_one = (visits.iter().map(|visit| visit.u * visit.u).sum::<f64>() / n).sqrt() / mean;
        let mut relative: Vec<(f64, f64)> = visits.iter().map(|visit| (visit.lamp_s, visit.value / mean)).collect();
        relative.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let centre_s = relative.iter().map(|(lamp_s, _)| lamp_s).sum::<f64>() / n;
        let spread_s2 = relative.iter().map(|(time, _)| (time - centre_s).powi(2)).sum::<f64>();
        let slope = if spread_s2 > 0.0 {
            let products = relative.iter().map(|(time, value)| (time - centre_s) * (value - 1.0));
            products.sum::<f64>() / spread_s2
        } else {
            0.0
        };
        let residual2: f64 = relative
            .iter()
            .map(|(time, value)| (value - 1.0 - slope * (time - centre_s)).powi(2))
            .sum();
        let freedom = (n - 2.0).max(1.0);
        if visits.len() > 3 && residual2 / freedom > 4.0 * u_one * u_one {
            return Ok(Self::Interpolated {
                lamp_s: relative.iter().map(|(time, _)| *time).collect(),
                factor: relative.iter().map(|(_, value)| *value).collect(),
                u_rel: u_one.hypot(between_visits(&relative)),
            });
        }
        let u_line = u_of_mean(visits) / mean;
        let length_s = relative[relative.len() - 1].0 - relative[0].0;
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
            u_rate_per_h: slope.hypot(u_slope) * 3600.0,
            centre_s,
        })
    }

    /// The factor by which the reading of row `row`, `lamp_s` after the lamp was switched on, is too high.
    pub fn factor(&self, row: u64, lamp_s: f64) -> f64 {
        match self {
            Self::ByBurning { burning, .. } => {
                let at = burning.partition_point(|burning| burning.first_row <= row).max(1) - 1;
                burning
                    .get(at)
                    .map_or(1.0, |burning| burning.level * burning.drift.factor(row, lamp_s))
            }
            Self::Unknown { .. } | Self::None { .. } => 1.0,
            Self::Linear {
                rate_per_h, centre_s, ..
            } => 1.0 + rate_per_h / 3600.0 * (lamp_s - centre_s),
            Self::Interpolated {
                lamp_s: times, factor, ..
            } => {
                let above = times.partition_point(|at| *at < lamp_s);
                match (above.checked_sub(1), times.get(above)) {
                    (None, _) => factor[0],
                    (Some(below), None) => factor[below],
                    (Some(below), Some(high)) => {
                        let share = (lamp_s - times[below]) / (high - times[below]);
                        factor[below] + share * (factor[above] - factor[below])
                    }
                }
            }
        }
    }

    /// Relative standard uncertainty of the correction, common to all readings.
    pub fn u_rel(&self) -> f64 {
        match self {
            Self::Unknown { u_rel }
            | Self::None { u_rel, .. }
            | Self::Linear { u_rel, .. }
            | Self::Interpolated { u_rel, .. }
            | Self::ByBurning { u_rel, .. } => *u_rel,
        }
    }
}

/// Mean of the values of visits; not a number without any.
fn mean_of(visits: &[Visit]) -> f64 {
    visits.iter().map(|visit| visit.value).sum::<f64>() / visits.len() as f64
}

/// Standard uncertainty of that mean. Visits that all show the same are rounded alike, however many there are.
fn u_of_mean(visits: &[Visit]) -> f64 {
    let n = (visits.len() as f64).max(1.0);
    let u2 = visits.iter().map(|visit| visit.u * visit.u).sum::<f64>();
    let values = visits.iter().map(|visit| visit.value);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let u_one = (u2 / n).sqrt();
    if high - low <= u_one { u_one } else { u_one / n.sqrt() }
}

/// What lines between visits miss: each visit against the line between its neighbours, half of the root of the mean
/// square, since the light may have changed anywhere between two visits.
fn between_visits(relative: &[(f64, f64)]) -> f64 {
    let misses = relative.windows(3).map(|three| {
        let share = (three[1].0 - three[0].0) / (three[2].0 - three[0].0).max(f64::MIN_POSITIVE);
        three[1].1 - three[0].1 - share * (three[2].1 - three[0].1)
    });
    let count = relative.len().saturating_sub(2).max(1) as f64;
    0.5 * (misses.map(|miss| miss * miss).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visits(f: impl Fn(f64) -> f64) -> Vec<Visit> {
        (0..26)
            .map(|i| (i, 1800.0 + 300.0 * i as f64))
            .map(|(row, time_s)| Visit {
                row,
                lamp_s: time_s,
                value: f(time_s),
                u: 0.01 / 12.0_f64.sqrt(),
                digit: 0.01,
            })
            .collect()
    }

    #[test]
    fn a_line_is_found_through_the_steps_of_the_display() {
        let falling = visits(|time| ((3.37 * (1.0 - 0.01 * (time - 1800.0) / 3600.0)) * 100.0).round() / 100.0);
        let drift = Drift::of(&falling, 0.01).unwrap();
        assert!(
            matches!(drift, Drift::Linear { rate_per_h, .. } if (rate_per_h + 0.01).abs() < 0.0015),
            "{drift:?}"
        );
        let ratio = drift.factor(0, 1800.0) / drift.factor(0, 9300.0);
        assert!((ratio - 1.0 / (1.0 - 0.01 * 7500.0 / 3600.0)).abs() < 0.003);
        let steady = Drift::of(&visits(|_| 3.37), 0.01).unwrap();
        // 26 visits that are rounded alike are as good as one.
        let digit_rel = 0.01 / 12.0_f64.sqrt() / 3.37;
        assert!(
            matches!(steady, Drift::None { u_rel, .. } if (u_rel / digit_rel - 1.0).abs() < 1e-9),
            "{steady:?}"
        );
    }

    /// The lamp went out between two sessions, and its second warm-up took longer than the first session: its clock
    /// only rises.
    #[test]
    fn a_lamp_that_was_switched_on_again_is_another_burning_whatever_its_clock_reads() {
        let at = |index: u64, lamp_s: f64, burning: u32| Reading {
            index,
            lamp_s: Some(lamp_s),
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
        let drift = Drift::of(&visits(|time| if time > 5000.0 { 3.1 } else { 3.37 }), 0.01).unwrap();
        assert!(matches!(drift, Drift::Interpolated { .. }));
        assert!((drift.factor(0, 2000.0) / drift.factor(0, 9000.0) - 3.37 / 3.1).abs() < 1e-9);
        assert!(Drift::of(&visits(|_| -0.1), 0.01).is_err_and(|mean| (mean + 0.1).abs() < 1e-12));
        assert_eq!(
            Drift::of(&visits(|_| 1.0)[..1], 0.01),
            Ok(Drift::Unknown { u_rel: 0.01 })
        );
    }

    #[test]
    fn a_lamp_that_nobody_looks_at_may_go_on_as_it_did() {
        let stability = Stability {
            spread_rel: 0.005,
            window_s: 900.0,
        };
        // Half of ± 0.5 % in a short time, half of 5 % in ten windows; rectangular.
        assert!((stability.u_rel(0.0) - 0.0025 / 3.0_f64.sqrt()).abs() < 1e-15);
        assert!((stability.u_rel(9000.0) - 0.025 / 3.0_f64.sqrt()).abs() < 1e-15);
    }
}
