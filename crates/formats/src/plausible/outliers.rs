//! Single intensities that do not belong where they stand: two numbers swapped, a digit lost or changed.
//!
//! For every value, every pair of neighbours along γ and every two odd values anywhere, the question is how much likelier
//! the values are, beside their neighbours along γ and across planes ([`Field`]), once the value is changed or the two are
//! exchanged. Light itself can be uneven, but then in many places: what is told stands above most others of its file.
//! Thresholds were chosen on one half of many files by many hands and measured on the other; see decision record 0010.

use std::cmp::Ordering;

use super::misfit::{Field, Pattern};
use super::resolution::Resolution;
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
/// The same for a pair across planes.
const ACROSS: Told = Told {
    gain: 12.0,
    above_seventh: 3.0,
};
const LONE_ACROSS: (f64, f64) = (5.0, 4.0);
/// Two values apart: the gain of exchanging them, and how far above any other two.
const EXCHANGE: (f64, f64) = (16.0, 6.0);
/// Values that are tried in each other's place.
pub(super) const PARTNERS: usize = 60;
/// A value is looked at from this many times what is usual around it.
const PROMINENT: f64 = 3.0;
/// Least change: this part of the peak and of the value, or that; at least so many steps of the file's numbers.
const LEAST_VALUE: [(f64, f64); 2] = [(0.01, 0.02), (0.003, 0.03)];
const LEAST_PAIR: [(f64, f64); 2] = [(0.005, 0.0), (0.003, 0.03)];
const LEAST_ACROSS: [(f64, f64); 2] = [(0.01, 0.0); 2];
/// Smaller changes, down to this part of the peak, must gain so much more.
const SMALL: (f64, f64) = (0.0005, 8.0);
const STEPS: f64 = 2.0;
/// An exchange is looked at where the misfits of the two shrink to this part in one direction.
const SHRINKS: f64 = 0.95;
/// With so many places that would fit better otherwise the light is rugged, and no more are looked at.
const RUGGED: usize = 20_000;
/// Places that are ranked, and the rank (from 0) of the one above which another must stand.
const MOST: usize = 400;
const SEVENTH: usize = 6;

/// Looks at every value, every pair of neighbours along γ, and every two odd values.
pub(super) fn check(stored: &Stored<'_>, findings: &mut Findings) {
    let step = Resolution::of(stored).step();
    let Some(field) = Field::new(stored, stored.values, step) else {
        return;
    };
    for suspect in Ranked::of(&field, step).suspects(&field, step) {
        let gamma = stored.angles_deg[suspect.index % field.ng];
        let (message, fix) = match suspect.what {
            What::Exchange(partner) | What::Across(partner) => {
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

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum What {
    /// Another value would fit, by this change.
    Value(f64),
    /// This and the next value.
    Pair,
    /// This and the one at that index.
    Exchange(usize),
    /// This and the one at that index, in the next plane.
    Across(usize),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Suspect {
    pub index: usize,
    pub what: What,
    pub gain: f64,
}

/// All places that would fit better otherwise, those that gain most first.
#[derive(Default)]
pub(super) struct Ranked {
    /// Values, whatever the size of the change.
    pub odd: Vec<Suspect>,
    /// Values whose change matters.
    pub values: Vec<Suspect>,
    /// Pairs of neighbours along γ.
    pub pairs: Vec<Suspect>,
    /// Pairs of neighbours across planes.
    pub across: Vec<Suspect>,
}

impl Ranked {
    pub fn of(field: &Field, step: f64) -> Self {
        let mut ranked = Self::default();
        let shares = Shares::of(field);
        for index in 0..field.values.len() {
            if ranked.cut_off() {
                break;
            }
            ranked.look(field, index, &shares, step);
        }
        ranked.sort();
        ranked
    }

    /// Adds the value at an index, and its pairs with the next one along γ and across planes.
    pub fn look(&mut self, field: &Field, index: usize, shares: &Shares, step: f64) {
        if let Some(odd) = value(field, index) {
            self.odd.push(odd);
            self.values.extend(weighed(field, odd, LEAST_VALUE));
        }
        self.look_at_pair(field, index, shares, step);
        self.look_across(field, index, shares, step);
    }

    #[inline]
    pub fn look_at_pair(&mut self, field: &Field, index: usize, shares: &Shares, step: f64) {
        let angle = index % field.ng;
        if angle + 1 < field.ng && differ(field, index, index + 1, step) {
            let shares = [&shares.along[angle], &WHOLE];
            self.pairs.extend(pair(field, (index, index + 1), What::Pair, shares));
        }
    }

    #[inline]
    pub fn look_across(&mut self, field: &Field, index: usize, shares: &Shares, step: f64) {
        let plane = index / field.ng;
        let Some(next) = field.next_plane(plane) else { return };
        let other = next * field.ng + index % field.ng;
        if differ(field, index, other, step) {
            let shares = [&WHOLE, &shares.across[plane]];
            self.across
                .extend(pair(field, (index, other), What::Across(other), shares));
        }
    }

    pub fn sort(&mut self) {
        for list in [&mut self.odd, &mut self.values, &mut self.pairs, &mut self.across] {
            list.sort_unstable_by(by_gain);
        }
    }

    /// Whether not every place was looked at.
    pub fn cut_off(&self) -> bool {
        self.odd.len() + self.pairs.len() + self.across.len() > RUGGED
    }

    /// What is told of all that.
    pub fn suspects(&self, field: &Field, step: f64) -> Vec<Suspect> {
        let partners: Vec<usize> = self.odd.iter().take(PARTNERS).map(|odd| odd.index).collect();
        let patterns: Vec<Pattern> = partners.iter().map(|&index| field.pattern(&[(index, 1.0)])).collect();
        let exchange = exchange(&partners, |one, other| {
            let [one, other] = [one, other].map(|rank| (partners[rank], &patterns[rank]));
            exchanged(field, step, one, other)
        });
        let lists = [&self.pairs, &self.across, &self.values].map(|list| places(field, list.iter().copied()));
        chosen(field, exchange, &lists)
    }
}

pub(super) fn by_gain(one: &Suspect, other: &Suspect) -> Ordering {
    other.gain.total_cmp(&one.gain).then(one.index.cmp(&other.index))
}

/// How much the misfits of two neighbours grow with their own value where it is taken from the other's.
pub(super) struct Shares {
    /// For every angle and the next.
    along: Vec<Share>,
    /// For every plane and the next.
    across: Vec<Share>,
}

/// By order (line, cubic), of the one and of the other.
type Share = [[f64; 2]; 2];
/// Where neither takes part in the other's prediction.
const WHOLE: Share = [[1.0; 2]; 2];

impl Shares {
    pub fn of(field: &Field) -> Self {
        let across = |plane: usize| {
            let next = field.next_plane(plane).unwrap_or(plane);
            [0, 1].map(|order| {
                [(plane, next), (next, plane)].map(|(own, other)| field.own_share_across(own, other, order))
            })
        };
        Self {
            along: (0..field.ng)
                .map(|angle| [0, 1].map(|order| [field.own_share(angle, order); 2]))
                .collect(),
            across: (0..field.planes).map(across).collect(),
        }
    }
}

/// What is told, in the order of the file; `places`: pairs along γ, pairs across planes and values, those that gain most
/// first.
pub(super) fn chosen(
    field: &Field,
    exchange: Vec<Suspect>,
    [pairs, across, values]: &[Vec<Suspect>; 3],
) -> Vec<Suspect> {
    let gain = |places: &[Suspect], rank: usize| places.get(rank).map_or(0.0, |place| place.gain);
    let told = |places: &[Suspect], least: &Told| {
        let least = least.gain.max(gain(places, SEVENTH) + least.above_seventh);
        places.iter().take_while(|place| place.gain > least).count()
    };
    let told_pairs = [(pairs, &PAIR, &LONE_PAIR), (across, &ACROSS, &LONE_ACROSS)].map(|(pairs, least, lone)| {
        let alone = gain(pairs, 0) > lone.0.max(gain(pairs, 1) + lone.1);
        told(pairs, least).max(usize::from(alone))
    });
    let told_values = told(values, &VALUE);
    let mut rest: Vec<Suspect> = [
        &pairs[..told_pairs[0]],
        &across[..told_pairs[1]],
        &values[..told_values],
    ]
    .concat();
    let mut found = exchange;
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
fn value(field: &Field, index: usize) -> Option<Suspect> {
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

/// Whether two values differ enough to be looked at.
#[inline]
fn differ(field: &Field, one: usize, other: usize, step: f64) -> bool {
    let difference = (field.values[other] - field.values[one]).abs();
    difference >= SMALL.0 * field.peak && difference > STEPS * step
}

/// A pair of neighbours, if they would fit better exchanged; `shares` along γ and across planes.
fn pair(field: &Field, (index, other): (usize, usize), what: What, shares: [&Share; 2]) -> Option<Suspect> {
    let difference = field.values[other] - field.values[index];
    // Most pairs are told from their own misfits: exchanged, these would grow.
    let shrinks = |across: bool| {
        let [here, next] = [index, other].map(|at| field.misfits(at, across));
        (0..2).any(|order| {
            let [one, two] = shares[usize::from(across)][order];
            let before = here[order].abs() + next[order].abs();
            (here[order] + one * difference).abs() + (next[order] - two * difference).abs() < SHRINKS * before
        })
    };
    if !shrinks(false) && !shrinks(true) {
        return None;
    }
    let gain = field.pattern(&[(index, 1.0), (other, -1.0)]).gain(difference);
    let least = if what == What::Pair { LEAST_PAIR } else { LEAST_ACROSS };
    (gain > 0.0)
        .then_some(Suspect { index, what, gain })
        .and_then(|suspect| weighed(field, suspect, least))
}

/// The two of all partners that fit in each other's place, if there is one such pair and no other. `gain`: what it gains to
/// exchange the partners of these two ranks, if each would fit better.
pub(super) fn exchange(partners: &[usize], mut gain: impl FnMut(usize, usize) -> Option<f64>) -> Vec<Suspect> {
    let mut all = Vec::new();
    for (rank, &one) in partners.iter().enumerate() {
        for (other_rank, &other) in partners.iter().enumerate().skip(rank + 1) {
            all.extend(gain(rank, other_rank).map(|gain| (gain, one, other)));
        }
    }
    // The last of equals is taken by `max_by`: the first in rank.
    let first = |two: &&(f64, usize, usize)| two.0;
    let most = |a: &&(f64, usize, usize), b: &&(f64, usize, usize)| first(a).total_cmp(&first(b));
    let Some(&(gain, one, other)) = all.iter().rev().max_by(most) else {
        return Vec::new();
    };
    let shares = |index: usize| index == one || index == other;
    let second = all
        .iter()
        .filter(|two| !shares(two.1) && !shares(two.2))
        .fold(0.0_f64, |most, two| most.max(two.0));
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

/// What it gains to exchange two values, given the pattern of each; none where they are neighbours or one would not fit.
pub(super) fn exchanged(
    field: &Field,
    step: f64,
    (one, pattern): (usize, &Pattern),
    (other, others): (usize, &Pattern),
) -> Option<f64> {
    let difference = field.values[other] - field.values[one];
    if one.abs_diff(other) <= 1 || difference.abs() <= STEPS * step {
        return None;
    }
    let here = pattern.gain(difference);
    if here <= 0.0 {
        return None;
    }
    let there = others.gain(-difference);
    if there <= 0.0 {
        return None;
    }
    Some(if apart(field, one, other) {
        here + there
    } else {
        field.pattern(&[(one, 1.0), (other, -1.0)]).gain(difference)
    })
}

/// The suspect, its gain less by what a small change must gain more; none where the change is too small to matter.
fn weighed(field: &Field, suspect: Suspect, least: [(f64, f64); 2]) -> Option<Suspect> {
    let value = field.values[suspect.index];
    let change = match suspect.what {
        What::Value(change) => change,
        What::Pair => field.values[suspect.index + 1] - value,
        What::Across(other) => field.values[other] - value,
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

/// One wrong value disturbs the predictions of its neighbours; the largest of a group speaks for it. The first few places.
pub(super) fn places(field: &Field, ranked: impl Iterator<Item = Suspect>) -> Vec<Suspect> {
    let mut places: Vec<Suspect> = Vec::new();
    for suspect in ranked.take(MOST) {
        if places.iter().all(|other| apart(field, suspect.index, other.index)) {
            places.push(suspect);
            if places.len() > SEVENTH {
                break;
            }
        }
    }
    places
}

/// Whether two values disturb no prediction together.
fn apart(field: &Field, one: usize, other: usize) -> bool {
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
            unit_cd: 1.0,
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
    fn five_angles_are_enough_where_there_are_planes() {
        let mut values: Vec<f64> = (0..9 * 5).map(|index| 1000.0 - 250.0 * f64::from(index % 5)).collect();
        assert!(findings(&values, 9).is_empty());
        values.swap(22, 23);
        assert_eq!(lines(&values, 9), [23]);
    }

    #[test]
    fn neighbours_across_planes_are_told() {
        // Lobes that widen from plane to plane.
        let light = |index: usize| {
            let power = 1.0 + 0.4 * (index / NG) as f64;
            500.0 * ((index % NG) as f64 * 2.5).to_radians().cos().max(0.0).powf(power)
        };
        let mut values: Vec<f64> = (0..7 * NG).map(light).collect();
        assert!(findings(&values, 7).is_empty());
        values.swap(3 * NG + 20, 4 * NG + 20);
        let found = lines(&values, 7);
        assert!(
            found.contains(&(3 * NG + 21)) || found.contains(&(4 * NG + 21)),
            "{found:?}"
        );
    }

    #[test]
    fn a_cut_off_in_all_planes_is_light() {
        let values: Vec<f64> = (0..7 * NG)
            .map(|index| if index % NG < 9 { 400.0 } else { 0.0 })
            .collect();
        assert!(findings(&values, 7).is_empty());
    }
}
