//! Single intensities that do not belong where they stand: two numbers swapped, a digit lost or changed.
//!
//! One wrong value leaves a known pattern in the misfits of its neighbours along γ and across planes ([`Field`]), and so
//! does a pair of neighbours that changed places. A place is suspect when the pattern stands far above what is usual
//! around it, and when undoing it leaves no more than is usual. Light itself can be uneven, but seldom in just that pattern.
//! Thresholds were chosen on one half of many files by many hands and measured on the other; see decision record 0010.

use super::misfit::Field;
use super::{Stored, at};
use crate::finding::{Finding, Findings};

/// A value is looked at from this many times what is usual around it.
const PROMINENT: f64 = 4.0;
/// How far above what is usual the pattern of a wrong value stands, and that of a pair.
const SINGLE: f64 = 26.0;
const PAIR: f64 = 8.0;
/// Root mean square of what may be left, in units of what is usual: for a value this, or this share of its pattern up to
/// that bound; for a pair.
const LEFT_SINGLE: (f64, f64, f64) = (2.0, 0.05, 4.0);
const LEFT_PAIR: f64 = 2.5;
/// The largest single misfit that may be left, as a share of the pattern.
const LEFT_LARGEST: f64 = 0.4;
/// The change that fits a pair best must be its difference, to within this share.
const REVERSED: f64 = 0.2;
/// Two values far apart, each of which fits in the other's place: how far above what is usual each of them stands, and to
/// within which share of their difference each fits.
const EXCHANGED: (f64, f64) = (8.0, 0.1);
/// Values that are tried as partners.
const PARTNERS: usize = 60;
/// Steps on either side of a reversal that all go the other way, and the share within which it is as large as they are; where
/// it ranks among pairs.
const REACH: usize = 5;
const EVEN: f64 = 0.6;
const REVERSAL: f64 = 40.0;
/// Least change of a value and least difference of a pair, relative.
const RELATIVE: (f64, f64) = (0.02, 0.01);
/// Where many places look alike it is the light: only what stands this many times above the seventh counts.
const ABOVE: (f64, usize) = (3.0, 6);
/// Places that are ranked.
const MOST: usize = 400;

/// Looks at every value and every pair of neighbours along γ.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let step = 10f64.powi(-decimals(stored));
    let Some(field) = Field::new(stored, step) else { return };
    for suspect in suspects(&field, step) {
        let index = suspect.plane * field.ng + suspect.angle;
        let gamma = stored.angles_deg[suspect.angle];
        let (message, fix) = if let Some((plane, angle)) = suspect.partner {
            let (line, _) = stored.places.get(plane * field.ng + angle).copied().unwrap_or((1, 1));
            (
                format!(
                    "this intensity (γ = {gamma}°) and the one in line {line} would fit their neighbours in each other's place"
                ),
                "compare both with the source; they may be swapped",
            )
        } else if suspect.pair {
            (
                format!("this intensity and the next one (γ = {gamma}°) fit their neighbours only the other way round"),
                "compare both with the source; they may be swapped",
            )
        } else {
            let expected = stored.values[index] + suspect.change;
            (
                format!("this intensity (γ = {gamma}°) does not fit its neighbours, which suggest about {expected:.4}"),
                "compare it with the source; a digit may be wrong, or two numbers swapped",
            )
        };
        findings.push(
            at(
                stored,
                index,
                Finding::warning("intensity-outlier", message).assumed("the value as it stands"),
            )
            .fix(fix),
        );
    }
}

#[derive(Debug, Clone, Copy)]
struct Suspect {
    plane: usize,
    angle: usize,
    change: f64,
    pair: bool,
    score: f64,
    /// Where the value stands that belongs here, if that is known.
    partner: Option<(usize, usize)>,
}

fn suspects(field: &Field<'_>, step: f64) -> Vec<Suspect> {
    let mut all = Vec::new();
    let shares: Vec<f64> = (0..field.ng).map(|angle| field.step_share(angle)).collect();
    for plane in 0..field.planes {
        let row = plane * field.ng;
        for (angle, &share) in shares.iter().enumerate() {
            let index = row + angle;
            let (along, across) = (field.along[index].abs(), field.across[index].abs());
            let least = RELATIVE.0 * field.values[index].abs().max(0.002 * field.peak);
            // `max` passes over a direction without a prediction.
            if along.max(across) >= least && field.prominence(plane, angle) > PROMINENT {
                all.extend(single(field, plane, angle, least));
            }
            if only_reversal(field, plane, angle, step) {
                all.push(Suspect {
                    plane,
                    angle,
                    change: field.values[index + 1] - field.values[index],
                    pair: true,
                    score: REVERSAL,
                    partner: None,
                });
            } else if angle + 1 < field.ng && may_be_swapped(field, plane, angle, share, step) {
                let prominent = |angle| field.prominence(plane, angle) > PROMINENT;
                if prominent(angle) || prominent(angle + 1) {
                    all.extend(pair(field, plane, angle));
                }
            }
        }
    }
    all.sort_by(|a, b| b.score.total_cmp(&a.score));
    all.truncate(MOST);
    let mut places: Vec<Suspect> = Vec::new();
    // One wrong value disturbs the predictions of its neighbours; the largest of a group speaks for it.
    for suspect in all {
        let apart = |other: &Suspect| {
            let (planes, angles) = (other.plane.abs_diff(suspect.plane), other.angle.abs_diff(suspect.angle));
            !(planes == 0 && angles <= 3 || angles == 0 && planes <= 2)
        };
        if places.iter().all(apart) {
            places.push(suspect);
        }
    }
    let usual = |pair: bool| {
        let kind = places.iter().filter(|place| place.pair == pair);
        kind.skip(ABOVE.1)
            .map(|place| ABOVE.0 * place.score)
            .next()
            .unwrap_or(0.0)
    };
    let least = [SINGLE.max(usual(false)), PAIR.max(usual(true))];
    exchanged(field, &mut places);
    places.retain(|place| place.partner.is_some() || place.score > least[usize::from(place.pair)]);
    places.sort_by_key(|place| (place.plane, place.angle));
    places
}

fn single(field: &Field<'_>, plane: usize, angle: usize, least: f64) -> Option<Suspect> {
    if edge(field, plane, angle) {
        return None;
    }
    let pattern = field.pattern(plane, &[(angle, 1.0)]);
    let count = pattern.misfit.len();
    let (product, square) = pattern.products();
    if count < 3 || square <= 0.0 {
        return None;
    }
    let change = -product / square;
    let score = square.sqrt() * change.abs();
    let (left, largest) = pattern.left(change, count - 1);
    let (floor, share, most) = LEFT_SINGLE;
    let fits = left <= (share * score).max(floor).min(most) && largest <= LEFT_LARGEST * score;
    (change.abs() >= least && fits).then_some(Suspect {
        plane,
        angle,
        change,
        pair: false,
        score,
        partner: None,
    })
}

/// Marks the two values of the file that fit in each other's place, if there is one such pair and no other.
fn exchanged(field: &Field<'_>, places: &mut [Suspect]) {
    let value = |place: &Suspect| field.values[place.plane * field.ng + place.angle];
    let odd: Vec<usize> = (0..places.len())
        .filter(|&at| !places[at].pair && places[at].score > EXCHANGED.0)
        .take(PARTNERS)
        .collect();
    let mut found = Vec::new();
    for (rank, &one) in odd.iter().enumerate() {
        for &other in &odd[rank + 1..] {
            let difference = value(&places[other]) - value(&places[one]);
            let fits = |change: f64| (change - difference).abs() <= EXCHANGED.1 * difference.abs();
            if fits(places[one].change) && fits(-places[other].change) {
                found.push((one, other));
            }
        }
    }
    if let [(one, other)] = found[..] {
        let place = |at: usize| (places[at].plane, places[at].angle);
        (places[one].partner, places[other].partner) = (Some(place(other)), Some(place(one)));
    }
}

/// The pair is the only step against the slope around it, and as large as the steps beside it: put right, the values fall
/// (or rise) evenly, as they do in the planes beside.
fn only_reversal(field: &Field<'_>, plane: usize, angle: usize, step: f64) -> bool {
    if angle < REACH || angle + 1 + REACH >= field.ng || edge(field, plane, angle) || edge(field, plane, angle + 1) {
        return false;
    }
    let row = &field.values[plane * field.ng..(plane + 1) * field.ng];
    let difference = row[angle + 1] - row[angle];
    if difference.abs() <= 3.0 * step || difference.abs() < RELATIVE.0 * row[angle].abs() {
        return false;
    }
    // The two are as they stand; put right, the step there is minus their difference.
    let slope = -difference.signum();
    let right = |at: usize| match at {
        _ if at == angle => row[angle + 1],
        _ if at == angle + 1 => row[angle],
        _ => row[at],
    };
    let rise = |at: usize| (right(at + 1) - right(at)) * slope;
    let (before, after) = (rise(angle - 1), rise(angle + 1));
    let even = EVEN * before.min(after)..=before.max(after) / EVEN;
    if !(angle - REACH..=angle + REACH).all(|at| rise(at) > 0.0) || !even.contains(&rise(angle)) {
        return false;
    }
    field.planes_beside(plane).all(|other| {
        let row = &field.values[other * field.ng..(other + 1) * field.ng];
        (row[angle + 1] - row[angle]) * slope > 0.0
    })
}

/// The values are far enough apart, and the misfits of the two in one direction are about what swapped ones have.
fn may_be_swapped(field: &Field<'_>, plane: usize, angle: usize, share: f64, step: f64) -> bool {
    let index = plane * field.ng + angle;
    let (here, next) = (field.values[index], field.values[index + 1]);
    let difference = next - here;
    if difference.abs() <= RELATIVE.1 * here.abs().max(next.abs()) || difference.abs() <= 2.0 * step {
        return false;
    }
    let about = |misfit: f64, expected: f64| {
        misfit * expected > 0.0 && {
            let ratio = misfit / expected;
            (0.4..1.6).contains(&ratio)
        }
    };
    about(field.along[index + 1] - field.along[index], 2.0 * share * difference)
        || about(field.across[index + 1] - field.across[index], 2.0 * difference)
        || field.along[index].is_nan() != field.along[index + 1].is_nan()
}

fn pair(field: &Field<'_>, plane: usize, angle: usize) -> Option<Suspect> {
    if edge(field, plane, angle) || edge(field, plane, angle + 1) {
        return None;
    }
    let index = plane * field.ng + angle;
    let change = field.values[index + 1] - field.values[index];
    let pattern = field.pattern(plane, &[(angle, 1.0), (angle + 1, -1.0)]);
    let count = pattern.misfit.len();
    let (product, square) = pattern.products();
    if count < 3 || square <= 0.0 {
        return None;
    }
    let score = square.sqrt() * change.abs();
    let (left, largest) = pattern.left(change, count);
    let reversed = (-product / square / change - 1.0).abs() <= REVERSED;
    (reversed && left <= LEFT_PAIR && largest <= LEFT_LARGEST * score).then_some(Suspect {
        plane,
        angle,
        change,
        pair: true,
        score,
        partner: None,
    })
}

/// Few planes do not tell an edge of the light from damage, but an edge is at the same angle in all of them, and a
/// single plane breaks off at the horizon.
fn edge(field: &Field<'_>, plane: usize, angle: usize) -> bool {
    if field.planes >= 4 {
        return false;
    }
    let range = angle.saturating_sub(1)..(angle + 2).min(field.ng);
    if field.planes == 1 {
        let width = field.gamma_deg[range.end - 1] - field.gamma_deg[range.start];
        return (field.gamma_deg[angle] - 90.0).abs() <= width.max(5.0);
    }
    let others = (0..field.planes).filter(|&other| other != plane);
    let largest = others
        .flat_map(|other| range.clone().map(move |angle| other * field.ng + angle))
        .fold(0.0, |most: f64, index| most.max(field.along[index].abs()));
    field.along[plane * field.ng + angle].abs() < 3.0 * largest
}

/// The largest number of decimals among some hundred values, zeros at their end not counted.
fn decimals(stored: &Stored<'_>) -> i32 {
    let count = |index: usize| {
        let text = (stored.raw)(index);
        let point = text.bytes().rposition(|byte| matches!(byte, b'.' | b','));
        point.map_or(0, |at| text[at + 1..].trim_end_matches('0').len())
    };
    let some = (0..stored.values.len()).step_by(stored.values.len() / 500 + 1);
    some.map(count).max().unwrap_or(0).min(12) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn findings(values: &[f64], planes: usize) -> Vec<Finding> {
        let ng = values.len() / planes;
        let planes_deg: Vec<f64> = (0..planes).map(|plane| plane as f64 * 15.0).collect();
        let angles_deg: Vec<f64> = (0..ng).map(|angle| angle as f64 * 2.5).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let stored = Stored {
            planes_deg: &planes_deg,
            angles_deg: &angles_deg,
            values,
            places: &places,
            raw: &|_| "1.01",
            poles: true,
            ends_with_newline: true,
        };
        let mut findings = Findings::new();
        check(&stored, &mut findings);
        findings.into_vec()
    }

    const NG: usize = 37;

    fn lobe(planes: usize) -> Vec<f64> {
        let cosine = |index: usize| ((index % NG) as f64 * 2.5).to_radians().cos().max(0.0);
        (0..planes * NG).map(|index| 500.0 * cosine(index).powf(1.5)).collect()
    }

    fn lines(values: &[f64], planes: usize) -> Vec<usize> {
        findings(values, planes)
            .iter()
            .filter_map(|finding| finding.line)
            .collect()
    }

    #[test]
    fn smooth_light_is_quiet_and_a_wrong_value_is_named() {
        assert!(findings(&lobe(1), 1).is_empty());
        assert!(findings(&lobe(7), 7).is_empty());
        let mut swapped = lobe(1);
        swapped.swap(8, 25);
        assert_eq!(lines(&swapped, 1), [9, 26]);
        let mut neighbours = lobe(7);
        neighbours.swap(2 * NG + 18, 2 * NG + 19);
        assert_eq!(lines(&neighbours, 7), [2 * NG + 19]);
    }

    #[test]
    fn a_lone_reversal_on_an_uneven_slope_is_told() {
        // Steps of 10 and 14 in turn: too rough for a cubic, yet always down.
        let mut values: Vec<f64> = (0..NG)
            .map(|at| 500.0 - 12.0 * at as f64 - 2.0 * (at % 2) as f64)
            .collect();
        assert!(findings(&values, 1).is_empty());
        values.swap(12, 13);
        assert_eq!(lines(&values, 1), [13]);
    }

    #[test]
    fn a_cut_off_in_all_planes_is_light() {
        let values: Vec<f64> = (0..7 * NG)
            .map(|index| if index % NG < 9 { 400.0 } else { 0.0 })
            .collect();
        assert!(findings(&values, 7).is_empty());
    }
}
