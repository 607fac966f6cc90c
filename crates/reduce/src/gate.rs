//! The gate: a record whose lamp or bench did not stay as it was gives no result, unless a person accepts it.

use isolux_record::limits::Limits;
use isolux_record::{Reading, ReadingKind};

use crate::drift::{Seen, Visit};
use crate::finding::{Evidence, Finding};
use crate::reference::Reference;
use crate::samples::Sample;

/// What the visits to the reference point show: a drift that is larger than the limit, visits that scatter about it, a
/// burning at another level. One digit of the display is allowed on top of every limit.
pub fn of_reference(reference: &Reference, limits: &Limits, all: &[Reading]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let every: Vec<&Visit> = reference.burnings.iter().flat_map(|seen| &seen.visits).collect();
    let Some(level) = median(every.iter().map(|visit| visit.value).collect()) else {
        return findings;
    };
    for seen in &reference.burnings {
        findings.extend(of_burning(seen, level, limits, all));
    }
    findings
}

fn of_burning(seen: &Seen, level: f64, limits: &Limits, all: &[Reading]) -> Vec<Finding> {
    let mut findings = Vec::new();
    let visits = &seen.visits;
    let Some(middle) = median(visits.iter().map(|visit| visit.value).collect()) else {
        return findings;
    };
    let percent = |rel: f64| 100.0 * rel;
    let evidence = |visits: &mut dyn Iterator<Item = &Visit>| -> Vec<Evidence> {
        visits.filter_map(|visit| row(all, visit.row)).collect()
    };
    let digit = visits.iter().map(|visit| visit.digit).fold(0.0, f64::max);
    if (middle - level).abs() > limits.drift_rel() * level.abs() + digit {
        findings.push(Finding {
            what: format!(
                "the lamp burns at {:+.2} % of the level of its other burnings from row {} on (limits.drift_rel {:.2} %)",
                percent(middle / level - 1.0),
                seen.first_row,
                percent(limits.drift_rel())
            ),
            rows: evidence(&mut visits.iter().take(1)),
        });
    }
    let beyond = |visit: &&Visit| (visit.value - middle).abs() > limits.drift_rel() * middle.abs() + visit.digit;
    let largest = visits
        .iter()
        .map(|visit| visit.value / middle - 1.0)
        .fold(
            0.0,
            |worst: f64, change| {
                if change.abs() > worst.abs() { change } else { worst }
            },
        );
    let drifted = evidence(&mut visits.iter().filter(beyond));
    if !drifted.is_empty() {
        findings.push(Finding {
            what: format!(
                "the reference point changed by up to {:+.2} % (limits.drift_rel {:.2} % and one digit)",
                percent(largest),
                percent(limits.drift_rel())
            ),
            rows: drifted,
        });
    }
    // Two visits are always on a line.
    if visits.len() > 2 {
        let line = robust_line(visits);
        let off = |visit: &Visit| visit.value - line(visit.time_s);
        let outside = |visit: &&Visit| off(visit).abs() > limits.reference_rel() * middle.abs() + visit.digit;
        let scattered = evidence(&mut visits.iter().filter(outside));
        if !scattered.is_empty() {
            let worst = visits.iter().map(|visit| off(visit).abs()).fold(0.0, f64::max);
            findings.push(Finding {
                what: format!(
                    "the visits to the reference point scatter by up to {:.2} % about their line (limits.reference_rel {:.2} % and one \
                     digit)",
                    percent(worst / middle.abs()),
                    percent(limits.reference_rel())
                ),
                rows: scattered,
            });
        }
    }
    findings
}

/// Where the closing half-plane C 360° does not agree with C 0°, relative to the largest intensity of C 0°; one digit
/// of the display is allowed on top.
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

fn row(all: &[Reading], index: u64) -> Option<Evidence> {
    let found = all
        .iter()
        .find(|row| row.index == index && row.kind == ReadingKind::Lit)?;
    Some(evidence_of(found))
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

/// The line of Theil and Sen: the median of the slopes of all pairs, through the median of what is left. A fifth of the
/// visits may be anything.
fn robust_line(visits: &[Visit]) -> impl Fn(f64) -> f64 {
    let mut slopes = Vec::new();
    for (place, one) in visits.iter().enumerate() {
        let later = visits[place + 1..].iter().filter(|other| other.time_s > one.time_s);
        slopes.extend(later.map(|other| (other.value - one.value) / (other.time_s - one.time_s)));
    }
    let slope = median(slopes).unwrap_or(0.0);
    let level = median(visits.iter().map(|visit| visit.value - slope * visit.time_s).collect()).unwrap_or(0.0);
    move |time_s| level + slope * time_s
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let high = *values.get(middle)?;
    Some(if values.len().is_multiple_of(2) {
        0.5 * (values[middle - 1] + high)
    } else {
        high
    })
}

#[cfg(test)]
mod tests;
