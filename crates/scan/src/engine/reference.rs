//! The reference point: what it gave since the lamp was switched on, and whether it gives that still.

use isolux_record::limits::Limits;
use isolux_record::steadiness::{Drifted, Seen, Steadiness, allowed_lx};
use isolux_record::{Quality, Reading, ReadingKind, Role};

use crate::error::ScanError;

/// The visits to the reference point, for each distance of the detector.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct References {
    /// Since the lamp was switched on: (distance in mm, visits there).
    visits: Vec<(f64, Steadiness)>,
    /// Levels of the burnings before: (distance in mm, level).
    earlier: Vec<(f64, Seen)>,
    /// The light at the end of the last warm-up: (distance in mm, illuminance in lx).
    stable: Option<(f64, f64)>,
}

impl References {
    /// The visits in `rows`; those since the lamp was last switched on are the present ones. Rows of format 3 do not
    /// count that: there it is the last row of a lamp that was off, or the last time that its clock went back.
    pub fn of(rows: &[Reading], limits: &Limits) -> Self {
        let mut references = Self::default();
        let (mut last_s, mut last_burning) = (None, None);
        for row in rows {
            let clock_went_back = row.lamp_s.zip(last_s).is_some_and(|(now, last)| now < last);
            if row.kind == ReadingKind::LampOff || row.burning != last_burning || clock_went_back {
                references.next_burning();
            }
            last_s = row.lamp_s.or(last_s);
            last_burning = row.burning;
            if row.role == Role::Reference && row.quality == Quality::Ok {
                references.keep(row, limits);
            }
        }
        references
    }

    /// Remembers a visit, unless it jumped from the one before at its distance.
    pub fn keep(&mut self, visit: &Reading, limits: &Limits) {
        let Some(seen) = seen(visit) else { return };
        let place = self
            .visits
            .iter()
            .position(|(distance, _)| *distance == visit.distance_mm);
        let place = place.unwrap_or_else(|| {
            self.visits.push((visit.distance_mm, Steadiness::default()));
            self.visits.len() - 1
        });
        self.visits[place].1.follow(seen, limits);
    }

    /// The lamp is switched on: what was visited so far belongs to an earlier burning.
    pub fn next_burning(&mut self) {
        let levels = self
            .visits
            .drain(..)
            .filter_map(|(distance, visits)| Some((distance, visits.level()?)));
        self.earlier.extend(levels);
        self.stable = None;
    }

    fn at(&self, distance_mm: f64) -> Option<&Steadiness> {
        let at = self.visits.iter().find(|(distance, _)| *distance == distance_mm);
        at.map(|(_, visits)| visits)
    }

    /// What the last visit at this distance gave.
    pub fn last(&self, distance_mm: f64) -> Option<f64> {
        Some(self.at(distance_mm)?.last()?.illuminance_lx)
    }

    /// Remembers the light with which the lamp was found stable.
    pub fn keep_stable(&mut self, distance_mm: f64, illuminance_lx: f64) {
        self.stable = Some((distance_mm, illuminance_lx));
    }

    /// What a visit at this distance should give: what the last one gave, or where there was none the light with which
    /// the lamp was found stable.
    pub fn expected(&self, distance_mm: f64) -> Option<f64> {
        let stable = self.stable.filter(|(distance, _)| *distance == distance_mm);
        self.last(distance_mm).or(stable.map(|(_, lux)| lux))
    }

    /// Whether a visit lies within the plan's limits of `expected_lx` and of the visits of this burning.
    ///
    /// # Errors
    /// [`ScanError::Reference`] if it jumped, and for a visit without a number: nothing can be compared with it;
    /// [`ScanError::Drifted`] for a slow drift, or a lamp that came back at another level, that no reduction corrects any
    /// more.
    pub fn judge(&self, visit: &Reading, expected_lx: Option<f64>, limits: &Limits) -> Result<(), ScanError> {
        let seen = seen(visit);
        let jumped = match (seen, expected_lx) {
            (Some(seen), Some(expected_lx)) => Steadiness::jumps(seen, expected_lx, limits),
            (Some(_), None) => false,
            (None, _) => true,
        };
        if jumped {
            return Err(ScanError::Reference {
                found_lx: visit.illuminance_lx,
                expected_lx,
                allowed_lx: seen
                    .zip(expected_lx)
                    .map_or(0.0, |(seen, expected_lx)| allowed_lx(seen, expected_lx, limits)),
                allowed_rel: limits.reference_rel(),
            });
        }
        let Some(seen) = seen else { return Ok(()) };
        let drifted = self
            .at(visit.distance_mm)
            .and_then(|visits| visits.drifted(seen, limits))
            .or_else(|| self.another_level(seen, visit.distance_mm, limits));
        match drifted {
            Some(drifted) => Err(ScanError::Drifted {
                found_lx: seen.illuminance_lx,
                middle_lx: drifted.middle_lx,
                change_rel: drifted.change_rel,
                allowed_rel: limits.drift_rel(),
            }),
            None => Ok(()),
        }
    }

    /// With `seen` as the next visit, how far this burning lies from the earlier one that is farthest beyond the limit.
    fn another_level(&self, seen: Seen, distance_mm: f64, limits: &Limits) -> Option<Drifted> {
        let level = self.at(distance_mm).map_or(seen, |visits| visits.level_with(seen));
        let others = self.earlier.iter().filter(|(distance, _)| *distance == distance_mm);
        let beyond = others.filter(|(_, other)| Steadiness::drifts(level, other.illuminance_lx, limits));
        let drifts = beyond.map(|(_, other)| Drifted {
            middle_lx: other.illuminance_lx,
            change_rel: level.illuminance_lx / other.illuminance_lx - 1.0,
        });
        drifts.max_by(|a, b| a.change_rel.abs().total_cmp(&b.change_rel.abs()))
    }
}

fn seen(visit: &Reading) -> Option<Seen> {
    Some(Seen {
        illuminance_lx: visit.illuminance_lx?,
        digit_lx: visit.digit_lx.unwrap_or_default(),
    })
}
