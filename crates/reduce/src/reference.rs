//! The visits to the reference point, burning by burning, and the drift that follows from them.

use std::collections::BTreeSet;

use isolux_record::{Reading, ReadingKind, Role};

use crate::drift::{self, Drift, Seen, Stability, Visit};
use crate::error::ReduceError;
use crate::samples::Corrected;

/// The burnings of the lamp that have readings of the distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// In the order of the rows.
    pub burnings: Vec<Seen>,
}

impl Reference {
    /// The visits among `all` readings that stand at the distance of the distribution's `rows`, with `light` as their
    /// value.
    pub fn of(
        all: &[Reading],
        rows: &[&Reading],
        distance_mm: f64,
        stability: Stability,
        light: &impl Fn(&Reading, f64) -> Corrected,
    ) -> Self {
        let starts = drift::burnings(all);
        // A burning without readings of the distribution says nothing of them.
        let used: BTreeSet<usize> = rows.iter().map(|row| drift::burning_of(&starts, row.index)).collect();
        let burnings = used.into_iter().map(|burning| {
            let here = |row: &Reading| drift::burning_of(&starts, row.index) == burning;
            let visits = all.iter().filter(|row| {
                row.role == Role::Reference
                    && row.kind == ReadingKind::Lit
                    && row.distance_mm == distance_mm
                    && here(row)
            });
            let times = rows.iter().filter(|row| here(row)).filter_map(|row| row.lamp_age_s());
            let (first_s, last_s) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), time| {
                (first.min(time), last.max(time))
            });
            Seen {
                first_row: starts.get(burning).copied().unwrap_or(0),
                visits: visits.filter_map(|row| visit(row, light)).collect(),
                unknown_rel: stability.u_rel((last_s - first_s).max(0.0)),
            }
        });
        Self {
            burnings: burnings.collect(),
        }
    }

    /// The drift in them.
    ///
    /// # Errors
    /// [`ReduceError::DarkReference`] where a mean of visits is not above zero.
    pub fn drift(&self, distance_mm: f64) -> Result<Drift, ReduceError> {
        let per_lx = (distance_mm * 1e-3).powi(2);
        Drift::of_burnings(&self.burnings).map_err(|mean_cd| ReduceError::DarkReference {
            illuminance_lx: mean_cd / per_lx,
        })
    }

    /// No correction: what the visits show stays in the readings, and at least what a stable lamp may do.
    pub fn uncorrected(&self) -> Drift {
        let of = |seen: &Seen| {
            let values = seen.visits.iter().map(|visit| visit.value);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            let shown = if high > low && low > 0.0 {
                (high - low) / (high + low)
            } else {
                0.0
            };
            seen.unknown_rel.max(shown / 3.0_f64.sqrt())
        };
        Drift::Unknown {
            u_rel: self.burnings.iter().map(of).fold(0.0, f64::max),
        }
    }

    /// What the budget cannot know: the level of a burning that no visit ties to the others.
    pub fn missing(&self, corrected: bool) -> Option<String> {
        let untied = self.burnings.iter().any(|seen| seen.visits.is_empty());
        (self.burnings.len() > 1 && (untied || !corrected)).then(|| {
            format!(
                "the light of {} burnings of the lamp is not tied together by visits",
                self.burnings.len()
            )
        })
    }
}

fn visit(row: &Reading, light: &impl Fn(&Reading, f64) -> Corrected) -> Option<Visit> {
    let corrected = light(row, row.illuminance_lx?);
    Some(Visit {
        row: row.index,
        lamp_s: row.lamp_age_s()?,
        value: corrected.intensity_cd,
        u: row.u_lx? * corrected.cd_per_lx,
        digit: row.digit_lx.unwrap_or(0.0) * corrected.cd_per_lx,
    })
}
