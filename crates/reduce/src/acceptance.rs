//! The acceptance check: a record whose lamp or bench did not stay as it was gives no result, unless a person accepts
//! it.

use std::collections::HashMap;

use isolux_record::limits::Limits;
use isolux_record::steadiness::{self, Seen, Steadiness};
use isolux_record::{Reading, ReadingKind, Role};

use crate::drift::Visit;
use crate::finding::{Evidence, Finding};
use crate::reference::Reference;
use crate::samples::Sample;

/// What the visits to the reference point show: a drift that is larger than the limit, a visit that jumped from the one
/// before, a burning at another level. One digit of the display is allowed on top of every limit. All are judged by
/// the illuminance as it was read, as the scan judged it: what that went on with is no finding here.
pub fn of_reference(reference: &Reference, limits: &Limits, all: &[Reading]) -> Vec<Finding> {
    let rows = all
        .iter()
        .filter(|row| row.role == Role::Reference && row.kind == ReadingKind::Lit);
    let rows: HashMap<u64, &Reading> = rows.map(|row| (row.index, row)).collect();
    let burnings: Vec<(u64, Vec<Visited<'_>>)> = reference
        .burnings
        .iter()
        .map(|burning| {
            let visits = burning.visits.iter().filter_map(|visit| as_read(visit, &rows));
            (burning.first_row, visits.collect())
        })
        .collect();
    let every: Vec<Seen> = burnings.iter().flat_map(|(_, visits)| seen(visits)).collect();
    let Some(level) = steadiness::level(&every) else {
        return Vec::new();
    };
    let of_one = |(first_row, visits): &(u64, Vec<Visited<'_>>)| of_burning(*first_row, visits, level, limits);
    burnings.iter().flat_map(of_one).collect()
}

/// A visit as it was read, and its row.
type Visited<'a> = (&'a Reading, Seen);

fn seen(visits: &[Visited<'_>]) -> Vec<Seen> {
    visits.iter().map(|(_, seen)| *seen).collect()
}

fn of_burning(first_row: u64, visits: &[Visited<'_>], level: Seen, limits: &Limits) -> Vec<Finding> {
    let mut findings = Vec::new();
    let Some(middle) = steadiness::level(&seen(visits)) else {
        return findings;
    };
    let percent = |rel: f64| 100.0 * rel;
    if Steadiness::drifts(middle, level.illuminance_lx, limits) {
        findings.push(Finding {
            what: format!(
                "the lamp burns at {:+.2} % of the level of its other burnings from row {first_row} on (limits.drift_rel {:.2} %)",
                percent(middle.illuminance_lx / level.illuminance_lx - 1.0),
                percent(limits.drift_rel())
            ),
            rows: visits.iter().take(1).map(|(row, _)| evidence_of(row)).collect(),
        });
    }
    let (worst, drifted) = beyond_drift(visits, middle.illuminance_lx, limits);
    if !drifted.is_empty() {
        findings.push(Finding {
            what: format!(
                "the reference point changed by up to {:+.2} % (limits.drift_rel {:.2} % and one digit)",
                percent(worst),
                percent(limits.drift_rel())
            ),
            rows: drifted,
        });
    }
    let (worst, jumped) = jumps(visits, limits);
    if !jumped.is_empty() {
        findings.push(Finding {
            what: format!(
                "the reference point jumped by up to {:+.2} % from one visit to the next (limits.reference_rel {:.2} % and one \
                 digit)",
                percent(worst),
                percent(limits.reference_rel())
            ),
            rows: jumped,
        });
    }
    findings
}

fn as_read<'a>(visit: &Visit, rows: &HashMap<u64, &'a Reading>) -> Option<Visited<'a>> {
    let row = rows.get(&visit.row)?;
    let seen = Seen {
        illuminance_lx: row.illuminance_lx?,
        digit_lx: row.digit_lx.unwrap_or_default(),
    };
    Some((row, seen))
}

/// The largest change against the median of the visits, relative, and the visits beyond the limit.
fn beyond_drift(visits: &[Visited<'_>], middle_lx: f64, limits: &Limits) -> (f64, Vec<Evidence>) {
    let beyond = |seen: &Seen| Steadiness::drifts(*seen, middle_lx, limits);
    let rows = visits.iter().filter(|(_, seen)| beyond(seen));
    let changes = visits.iter().map(|(_, seen)| seen.illuminance_lx / middle_lx - 1.0);
    (largest(changes), rows.map(|(row, _)| evidence_of(row)).collect())
}

/// The largest jump from one visit to the next, relative, and the visits that jumped.
fn jumps(visits: &[Visited<'_>], limits: &Limits) -> (f64, Vec<Evidence>) {
    let mut followed = Steadiness::default();
    let (mut changes, mut rows) = (Vec::new(), Vec::new());
    for (row, seen) in visits {
        let before = followed.last();
        if !followed.follow(*seen, limits) {
            changes.extend(before.map(|before| seen.illuminance_lx / before.illuminance_lx - 1.0));
            rows.push(evidence_of(row));
        }
    }
    (largest(changes.into_iter()), rows)
}

fn largest(changes: impl Iterator<Item = f64>) -> f64 {
    changes.fold(
        0.0,
        |worst: f64, change| if change.abs() > worst.abs() { change } else { worst },
    )
}

/// Where the closing half-plane C 360° does not agree with C 0°, relative to the largest intensity of C 0°; one
/// digit of the display is allowed on top.
pub fn of_closing(samples: &[Sample], limits: &Limits, rows: &[&Reading]) -> Option<Finding> {
    let first: Vec<&Sample> = samples
        .iter()
        .filter(|sample| !sample.closing && sample.c_deg == 0.0)
        .collect();
    let peak_cd = first.iter().map(|sample| sample.intensity_cd).fold(0.0, f64::max);
    let digit_cd = rows
        .iter()
        .filter_map(|row| Some(row.digit_lx? * (row.distance_mm * 1e-3).powi(2)))
        .fold(0.0, f64::max);
    let mut worst = 0.0_f64;
    let mut beyond = Vec::new();
    for last in samples.iter().filter(|sample| sample.closing) {
        let Some(same) = first.iter().find(|same| same.gamma_deg == last.gamma_deg) else {
            continue;
        };
        let difference = last.intensity_cd - same.intensity_cd;
        if difference.abs() > limits.closing_rel() * peak_cd + digit_cd {
            if difference.abs() > worst.abs() {
                worst = difference;
            }
            let closing = |row: &&&Reading| row.c_target_deg == 360.0 && row.gamma_target_deg == last.gamma_deg;
            beyond.extend(rows.iter().find(closing).map(|row| evidence_of(row)));
        }
    }
    (!beyond.is_empty()).then(|| Finding {
        what: format!(
            "the closing half-plane C 360° differs from C 0° by up to {:+.2} % of its largest intensity in {} directions \
             (limits.closing_rel {:.2} % and one digit)",
            100.0 * worst / peak_cd,
            beyond.len(),
            100.0 * limits.closing_rel()
        ),
        rows: beyond,
    })
}

fn evidence_of(row: &Reading) -> Evidence {
    Evidence {
        row: row.index,
        time_s: row.time_s,
        c_deg: row.c_target_deg,
        gamma_deg: row.gamma_target_deg,
        illuminance_lx: row.illuminance_lx,
    }
}

#[cfg(test)]
mod tests;
