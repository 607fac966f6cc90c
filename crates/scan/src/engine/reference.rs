//! The reference point: what it gave first since the lamp was switched on, and whether it gives that still.

use isolux_record::limits::Limits;
use isolux_record::{Quality, Reading, ReadingKind, Role};

use crate::error::ScanError;

/// The first visit to the reference point since the lamp was switched on, for each distance of the detector.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct References {
    /// (distance in mm, illuminance in lx).
    first: Vec<(f64, f64)>,
    /// The light at the end of the last warm-up, in the same words.
    stable: Option<(f64, f64)>,
}

impl References {
    /// The visits in `rows` since the lamp was last switched on. Rows of format 1 do not count that: there it is the
    /// last row of a lamp that was off, or the last time that its clock went back.
    pub fn since_last_switched_on(rows: &[Reading]) -> Self {
        let mut references = Self::default();
        let (mut last_s, mut last_burning) = (None, None);
        for row in rows {
            let clock_went_back = row.time_s.zip(last_s).is_some_and(|(now, last)| now < last);
            if row.kind == ReadingKind::LampOff || row.burning != last_burning || clock_went_back {
                references = Self::default();
            }
            last_s = row.time_s.or(last_s);
            last_burning = row.burning;
            if row.role == Role::Reference && row.quality == Quality::Ok {
                references.keep(row);
            }
        }
        references
    }

    /// Remembers a visit if it is the first at its distance.
    pub fn keep(&mut self, visit: &Reading) {
        if let Some(lux) = visit.illuminance_lx
            && self.first(visit.distance_mm).is_none()
        {
            self.first.push((visit.distance_mm, lux));
        }
    }

    /// What the first visit at this distance gave.
    pub fn first(&self, distance_mm: f64) -> Option<f64> {
        let at = self.first.iter().find(|(distance, _)| *distance == distance_mm);
        at.map(|(_, lux)| *lux)
    }

    /// Remembers the light with which the lamp was found stable.
    pub fn keep_stable(&mut self, distance_mm: f64, illuminance_lx: f64) {
        self.stable = Some((distance_mm, illuminance_lx));
    }

    /// What a visit at this distance should give: what the first one gave, or where there was none the light with which
    /// the lamp was found stable.
    pub fn expected(&self, distance_mm: f64) -> Option<f64> {
        let stable = self.stable.filter(|(distance, _)| *distance == distance_mm);
        self.first(distance_mm).or(stable.map(|(_, lux)| lux))
    }

    /// Whether a visit gives what it is expected to, within the plan's limit and one digit.
    ///
    /// # Errors
    /// [`ScanError::Reference`] if not, and for a visit without a number: nothing can be compared with it.
    pub fn judge(visit: &Reading, first_lx: Option<f64>, limits: &Limits) -> Result<(), ScanError> {
        let allowed_lx =
            limits.reference_rel() * first_lx.unwrap_or_default().abs() + visit.digit_lx.unwrap_or_default();
        let sound = match (visit.illuminance_lx, first_lx) {
            (Some(found), Some(first)) => (found - first).abs() <= allowed_lx,
            (Some(_), None) => true,
            (None, _) => false,
        };
        if sound {
            return Ok(());
        }
        Err(ScanError::Reference {
            found_lx: visit.illuminance_lx,
            first_lx,
            allowed_lx,
            allowed_rel: limits.reference_rel(),
        })
    }
}
