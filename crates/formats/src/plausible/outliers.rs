//! Single intensities that do not belong where they stand: two numbers swapped, a digit lost or changed.
//!
//! For every value, every pair of neighbours along γ and every two odd values anywhere, the question is how much likelier
//! the values are, beside their neighbours along γ and across planes ([`Field`]), once the value is changed or the two are
//! exchanged. Light itself can be uneven, but then in many places: what is told stands above most others of its file.
//! Thresholds were chosen on one half of many files by many hands and measured on the other; see decision record 0010.

use super::misfit::{Field, Pattern};
use super::resolution::resolution;
use super::{Stored, at};
use crate::finding::{Finding, Findings};

/// From which gain on (a logarithm of likelihoods) a change is told, when it stands this much above the seventh such
/// place of the file.
struct Told {
    gain: f64,
    above_seventh: f64,
}

const VALUE: Told = Told {
    gain: 24.0,
    above_seventh: 5.0,
};
const PAIR: Told = Told {
    gain: 10.0,
    above_seventh: 3.0,
};
/// A pair far above all others of the file is told from a smaller gain on: the gain, and how far above the second.
const LONE_PAIR: (f64, f64) = (4.0, 4.0);
/// Two values apart: the gain of exchanging them, and how far above any other two.
const EXCHANGE: (f64, f64) = (16.0, 6.0);
/// Values that are tried in each other's place.
const PARTNERS: usize = 60;
/// A value is looked at from this many times what is usual around it.
const PROMINENT: f64 = 3.0;
/// Least change: this part of the peak and of the value, or that; at least so many steps of the file's numbers.
const LEAST_VALUE: [(f64, f64); 2] = [(0.01, 0.02), (0.003, 0.03)];
const LEAST_PAIR: [(f64, f64); 2] = [(0.005, 0.0), (0.003, 0.03)];
/// Smaller changes, down to this part of the peak, must gain so much more.
const SMALL: (f64, f64) = (0.0005, 8.0);
const STEPS: f64 = 2.0;
/// An exchange is looked at where the misfits of the two shrink to this part in one direction.
const SHRINKS: f64 = 0.95;
/// With so many places that would fit better otherwise the light is rugged, and no more are looked at.
const RUGGED: usize = 20_000;
/// Places that are ranked.
const MOST: usize = 400;

/// Looks at every value, every pair of neighbours along γ, and every two odd values.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let step = resolution(stored);
    let Some(field) = Field::new(stored, step) else { return };
    for suspect in suspects(&field, step) {
        let gamma = stored.angles_deg[suspect.index % field.ng];
        let (message, fix) = match suspect.what {
            What::Exchange(partner) => {
                let (line, _) = stored.places.get(partner).copied().unwrap_or((1, 1));
                (
                    format!(
                        "this intensity (γ = {gamma}°) and the one in line {line} fit their neighbours better exchanged"
                    ),
                    "compare both with the source; they may be swapped",
                )
            }
            What::Pair => (
                format!("this intensity (γ = {gamma}°) and the next one fit their neighbours better exchanged"),
                "compare both with the source; they may be swapped",
            ),
            What::Value(change) => (
                format!(
                    "this intensity (γ = {gamma}°) does not fit its neighbours, which suggest about {:.4}",
                    stored.values[suspect.index] + change
                ),
                "compare it with the source; a digit may be wrong, or two numbers swapped",
            ),
        };
        let finding = Finding::warning("intensity-outlier", message).assumed("the value as it stands");
        findings.push(at(stored, suspect.index, finding).fix(fix));
    }
}

#[derive(Debug, Clone, Copy)]
enum What {
    /// Another value would fit, by this change.
    Value(f64),
    /// This and the next value.
    Pair,
    /// This and the one at that index.
    Exchange(usize),
}

#[derive(Debug, Clone, Copy)]
struct Suspect {
    index: usize,
    what: What,
    gain: f64,
}

fn suspects(field: &Field<'_>, step: f64) -> Vec<Suspect> {
    let mut odd: Vec<Suspect> = Vec::new();
    let mut pairs = Vec::new();
    let shares: Vec<[f64; 2]> = (0..field.ng)
        .map(|angle| [0, 1].map(|order| field.own_share(angle, order)))
        .collect();
    for index in 0..field.values.len() {
        if odd.len() + pairs.len() > RUGGED {
            break;
        }
        odd.extend(value(field, index));
        if (index + 1) % field.ng != 0 {
            pairs.extend(pair(field, index, shares[index % field.ng], step));
        }
    }
    odd.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let exchange = exchange(field, &odd[..odd.len().min(PARTNERS)], step);
    let values = places(
        field,
        odd.iter().filter_map(|&odd| weighed(field, odd, LEAST_VALUE)).collect(),
    );
    let pairs = places(field, pairs);

    let gain = |places: &[Suspect], rank: usize| places.get(rank).map_or(0.0, |place| place.gain);
    let told = |places: &[Suspect], least: &Told| {
        let least = least.gain.max(gain(places, 6) + least.above_seventh);
        places.iter().take_while(|place| place.gain > least).count()
    };
    let mut told_pairs = told(&pairs, &PAIR);
    if gain(&pairs, 0) > LONE_PAIR.0.max(gain(&pairs, 1) + LONE_PAIR.1) {
        told_pairs = told_pairs.max(1);
    }
    let told_values = told(&values, &VALUE);
    let mut found = exchange;
    let mut rest: Vec<Suspect> = [&pairs[..told_pairs], &values[..told_values]].concat();
    rest.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    for suspect in rest {
        if found.iter().all(|other| apart(field, suspect.index, other.index)) {
            found.push(suspect);
        }
    }
    found.sort_by_key(|suspect| suspect.index);
    found
}

/// The value, if another one would fit better.
fn value(field: &Field<'_>, index: usize) -> Option<Suspect> {
    let [along, across] = [false, true].map(|across| field.misfits(index, across));
    // `max` passes over a direction without a prediction.
    let largest = along
        .iter()
        .chain(&across)
        .fold(0.0_f64, |most, misfit| most.max(misfit.abs()));
    let least = LEAST_VALUE[0].1 * field.values[index].abs().max(SMALL.0 * field.peak);
    if largest < least || !field.stands_out(index, PROMINENT) {
        return None;
    }
    let (gain, change) = field.pattern(&[(index, 1.0)]).best().filter(|best| best.0 > 1.0)?;
    let what = What::Value(change);
    Some(Suspect { index, what, gain })
}

/// The pair of this and the next value along γ, if they would fit better exchanged.
fn pair(field: &Field<'_>, index: usize, shares: [f64; 2], step: f64) -> Option<Suspect> {
    let difference = field.values[index + 1] - field.values[index];
    if difference.abs() < SMALL.0 * field.peak || difference.abs() <= STEPS * step {
        return None;
    }
    // Most pairs are told from their own misfits: exchanged, these would grow.
    let shrinks = |across: bool| {
        let [here, next] = [index, index + 1].map(|at| field.misfits(at, across));
        (0..2).any(|order| {
            let change = if across { difference } else { shares[order] * difference };
            let before = here[order].abs() + next[order].abs();
            (here[order] + change).abs() + (next[order] - change).abs() < SHRINKS * before
        })
    };
    if !shrinks(false) && !shrinks(true) {
        return None;
    }
    let gain = field.pattern(&[(index, 1.0), (index + 1, -1.0)]).gain(difference);
    let what = What::Pair;
    (gain > 0.0)
        .then_some(Suspect { index, what, gain })
        .and_then(|suspect| weighed(field, suspect, LEAST_PAIR))
}

/// The two values of the file that fit in each other's place, if there is one such pair and no other.
fn exchange(field: &Field<'_>, odd: &[Suspect], step: f64) -> Vec<Suspect> {
    let patterns: Vec<Pattern> = odd.iter().map(|odd| field.pattern(&[(odd.index, 1.0)])).collect();
    let odd: Vec<(&Suspect, &Pattern)> = odd.iter().zip(&patterns).collect();
    let mut all = Vec::new();
    for (rank, (one, pattern)) in odd.iter().enumerate() {
        for (other, others) in &odd[rank + 1..] {
            let difference = field.values[other.index] - field.values[one.index];
            if one.index.abs_diff(other.index) <= 1 || difference.abs() <= STEPS * step {
                continue;
            }
            let (here, there) = (pattern.gain(difference), others.gain(-difference));
            if here <= 0.0 || there <= 0.0 {
                continue;
            }
            let near = !apart(field, one.index, other.index);
            let gain = if near {
                let both = [(one.index, 1.0), (other.index, -1.0)];
                field.pattern(&both).gain(difference)
            } else {
                here + there
            };
            all.push((gain, one.index, other.index));
        }
    }
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let Some(&(gain, one, other)) = all.first() else {
        return Vec::new();
    };
    let shares = |index: usize| index == one || index == other;
    let second = all
        .iter()
        .find(|two| !shares(two.1) && !shares(two.2))
        .map_or(0.0, |two| two.0);
    if gain <= EXCHANGE.0.max(second + EXCHANGE.1) {
        return Vec::new();
    }
    [(one, other), (other, one)]
        .map(|(index, partner)| Suspect {
            index,
            what: What::Exchange(partner),
            gain,
        })
        .to_vec()
}

/// The suspect, its gain less by what a small change must gain more; none where the change is too small to matter.
fn weighed(field: &Field<'_>, suspect: Suspect, least: [(f64, f64); 2]) -> Option<Suspect> {
    let value = field.values[suspect.index];
    let change = match suspect.what {
        What::Value(change) => change,
        What::Pair => field.values[suspect.index + 1] - value,
        What::Exchange(_) => return Some(suspect),
    };
    let (change, local) = (change.abs(), value.abs().max((value + change).abs()));
    let large = |&(of_peak, of_value): &(f64, f64)| change >= of_peak * field.peak && change >= of_value * local;
    if least.iter().any(large) {
        return Some(suspect);
    }
    let gain = suspect.gain - SMALL.1;
    (change >= SMALL.0 * field.peak && gain > 0.0).then_some(Suspect { gain, ..suspect })
}

/// One wrong value disturbs the predictions of its neighbours; the largest of a group speaks for it.
fn places(field: &Field<'_>, mut all: Vec<Suspect>) -> Vec<Suspect> {
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all.truncate(MOST);
    let mut places: Vec<Suspect> = Vec::new();
    for suspect in all {
        if places.iter().all(|other| apart(field, suspect.index, other.index)) {
            places.push(suspect);
        }
    }
    places
}

/// Whether two values disturb no prediction together.
fn apart(field: &Field<'_>, one: usize, other: usize) -> bool {
    let planes = (one / field.ng).abs_diff(other / field.ng);
    let angles = (one % field.ng).abs_diff(other % field.ng);
    !(planes == 0 && angles <= 3 || angles == 0 && planes <= 2)
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
