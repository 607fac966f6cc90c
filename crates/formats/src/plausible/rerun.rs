//! The checks of single values again after two of them were exchanged, computed only where the exchange reaches.
//!
//! What comes out is what [`super::check`] finds in the file with the two exchanged; a test compares them.

use std::collections::HashMap;

use super::misfit::{Field, Pattern, Trial};
use super::outliers::{self, Ranked, Shares, Suspect, What};
use super::resolution::Resolution;
use super::twins::Twins;
use super::{Stored, closing, pole};

/// A warning's place, and what it says there but for a value that is suggested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Told {
    /// Another value would fit.
    Value(usize),
    /// This and the next one are exchanged.
    Pair(usize),
    /// This one and that one are exchanged.
    Exchange(usize, usize),
    /// It differs from its image.
    Twin(usize),
    /// It differs from the other planes at a pole.
    Pole(usize),
    /// In the plane at 360° it differs from the one at 0°.
    Closing(usize),
}

impl Told {
    fn of(suspect: Suspect) -> Self {
        match suspect.what {
            What::Value(_) => Self::Value(suspect.index),
            What::Pair => Self::Pair(suspect.index),
            What::Exchange(partner) | What::Across(partner) => Self::Exchange(suspect.index, partner),
        }
    }

    /// Index of the value at which it stands.
    pub fn index(self) -> usize {
        match self {
            Self::Value(index)
            | Self::Pair(index)
            | Self::Exchange(index, _)
            | Self::Twin(index)
            | Self::Pole(index)
            | Self::Closing(index) => index,
        }
    }
}

/// A file with what its checks say, ready to exchange two of its values.
pub(super) struct Rerun<'s> {
    stored: Stored<'s>,
    /// The file's values, as they are after an exchange while one is looked at.
    values: Vec<f64>,
    peak: f64,
    twins: Twins,
    /// None where there are too few angles, or the light is so rugged that not every place is looked at.
    outliers: Option<Outliers>,
    before: Vec<Told>,
    /// The planes at 0° and 360° are equal.
    closes: bool,
}

impl<'s> Rerun<'s> {
    /// Runs the checks once on the file as it is.
    pub fn of(stored: &Stored<'s>) -> Self {
        let twins = Twins::of(stored);
        let peak = stored.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let outliers = Outliers::of(stored);
        let suspects = outliers
            .iter()
            .flat_map(|outliers| outliers.ranked.suspects(&outliers.field, outliers.step));
        let mut before: Vec<Told> = suspects.map(Told::of).collect();
        before.extend(twins.told(stored.values).into_iter().map(Told::Twin));
        before.extend(
            (0..2)
                .filter_map(|end| pole(stored, stored.values, end, peak))
                .map(|odd| Told::Pole(odd.index)),
        );
        Self {
            values: stored.values.to_vec(),
            closes: closing(stored, stored.values).is_none(),
            stored: *stored,
            peak,
            twins,
            outliers,
            before,
        }
    }

    /// How many misfits were weighed so far: a measure of the time it took.
    pub fn work(&self) -> usize {
        self.outliers
            .as_ref()
            .map_or(0, |outliers| outliers.field.work() + outliers.work)
    }

    /// What is told with two values exchanged that is not told without, in the order of the kinds and of the file.
    pub fn told(&mut self, one: usize, other: usize) -> Vec<Told> {
        let ng = self.stored.angles_deg.len();
        self.values.swap(one, other);
        let suspects = self.outliers.as_mut().map_or(Vec::new(), |outliers| {
            outliers.exchanged(&self.stored, &self.values, one, other)
        });
        let mut after: Vec<Told> = suspects.into_iter().map(Told::of).collect();
        after.extend(
            self.twins
                .exchanged(&self.values, one, other)
                .into_iter()
                .map(Told::Twin),
        );
        for (end, angle) in [0, ng - 1].into_iter().enumerate() {
            if [one, other].iter().any(|index| index % ng == angle) {
                let pole = pole(&self.stored, &self.values, end, self.peak);
                after.extend(pole.map(|odd| Told::Pole(odd.index)));
            }
        }
        if self.closes {
            after.extend(closing(&self.stored, &self.values).map(Told::Closing));
        }
        self.values.swap(one, other);
        after.retain(|told| !self.before.contains(told));
        after.sort_unstable();
        after.dedup();
        after
    }
}

/// Odd values whose exchanges with each other are kept from one run to the next.
const KEPT: usize = 160;

/// What [`outliers`] computes, kept for the next run.
struct Outliers {
    field: Field,
    trial: Trial,
    resolution: Resolution,
    step: f64,
    shares: Shares,
    ranked: Ranked,
    rank_of: HashMap<usize, usize>,
    patterns: Vec<Option<Pattern>>,
    /// What exchanging two kept values gains; NaN where not yet computed, minus infinity where one would not fit.
    gains: Vec<f64>,
    /// Work of runs that could not be computed from the differences.
    work: usize,
}

impl Outliers {
    fn of(stored: &Stored<'_>) -> Option<Self> {
        let resolution = Resolution::of(stored);
        let step = resolution.step();
        let field = Field::new(stored, stored.values, step)?;
        let ranked = Ranked::of(&field, step);
        if ranked.cut_off() {
            return None;
        }
        let kept = ranked.odd.len().min(KEPT);
        let rank_of = ranked.odd[..kept].iter().enumerate();
        Some(Self {
            trial: Trial::new(&field),
            shares: Shares::of(&field),
            rank_of: rank_of.map(|(rank, odd)| (odd.index, rank)).collect(),
            patterns: vec![None; kept],
            gains: vec![f64::NAN; kept * kept],
            work: 0,
            field,
            resolution,
            step,
            ranked,
        })
    }

    /// What stands out once two values were exchanged, which gave `values`.
    fn exchanged(&mut self, stored: &Stored<'_>, values: &[f64], one: usize, other: usize) -> Vec<Suspect> {
        let step = self.resolution.exchanged(stored, values, one, other);
        if step == self.step {
            // A plane at 360° repeats the first and takes no part.
            if one.max(other) >= self.field.values.len() {
                return self.whole(stored, values, step);
            }
            self.trial.make(&mut self.field, one, other);
            let suspects = self.suspects();
            self.trial.take_back(&mut self.field);
            suspects
        } else {
            self.whole(stored, values, step)
        }
    }

    fn whole(&mut self, stored: &Stored<'_>, values: &[f64], step: f64) -> Vec<Suspect> {
        let Some(field) = Field::new(stored, values, step) else {
            return Vec::new();
        };
        let suspects = Ranked::of(&field, step).suspects(&field, step);
        self.work += field.work() + values.len();
        suspects
    }

    /// The values that the exchange touches, looked at again.
    fn fresh(&self) -> Ranked {
        let (field, trial) = (&self.field, &self.trial);
        let mut fresh = Ranked::default();
        for &index in &trial.touched {
            fresh.look(field, index, &self.shares, self.step);
            // The pairs with the values before are touched too.
            if index % field.ng != 0 && !trial.touches(index - 1) {
                fresh.look_at_pair(field, index - 1, &self.shares, self.step);
            }
            let plane = index / field.ng;
            let before = plane.checked_sub(1).unwrap_or(field.planes - 1);
            let beside = before * field.ng + index % field.ng;
            if field.next_plane(before) == Some(plane) && !trial.touches(beside) {
                fresh.look_across(field, beside, &self.shares, self.step);
            }
        }
        fresh.sort();
        fresh
    }

    /// What stands out in the field while two values are exchanged.
    fn suspects(&mut self) -> Vec<Suspect> {
        let fresh = self.fresh();
        let (field, trial, ranked, step) = (&self.field, &self.trial, &self.ranked, self.step);
        let stays = |suspect: &&Suspect| !trial.touches(suspect.index);
        let pair_stays = |suspect: &&Suspect| !trial.touches(suspect.index) && !trial.touches(suspect.index + 1);

        let partners: Vec<usize> = merged(ranked.odd.iter().filter(stays), &fresh.odd)
            .take(outliers::PARTNERS)
            .map(|odd| odd.index)
            .collect();
        let (patterns, gains) = (&mut self.patterns, &mut self.gains);
        let side = patterns.len();
        let ranks: Vec<Option<usize>> = partners
            .iter()
            .map(|&index| self.rank_of.get(&index).copied().filter(|_| !trial.touches(index)))
            .collect();
        for &rank in ranks.iter().flatten() {
            patterns[rank].get_or_insert_with(|| field.pattern(&[(ranked.odd[rank].index, 1.0)]));
        }
        let own: Vec<Option<Pattern>> = partners
            .iter()
            .zip(&ranks)
            .map(|(&index, rank)| rank.is_none().then(|| field.pattern(&[(index, 1.0)])))
            .collect();
        let pattern = |at: usize| match ranks[at] {
            Some(rank) => patterns[rank].as_ref(),
            None => own[at].as_ref(),
        };
        let exchange = outliers::exchange(&partners, |one, other| {
            let compute = || {
                let (a, b) = (pattern(one)?, pattern(other)?);
                outliers::exchanged(field, step, (partners[one], a), (partners[other], b))
            };
            let (Some(a), Some(b)) = (ranks[one], ranks[other]) else {
                return compute();
            };
            let gain = &mut gains[a * side + b];
            if gain.is_nan() {
                *gain = compute().unwrap_or(f64::NEG_INFINITY);
            }
            (*gain > f64::NEG_INFINITY).then_some(*gain)
        });
        let across_stays = |suspect: &&Suspect| {
            let next = field.next_plane(suspect.index / field.ng).unwrap_or(0);
            !trial.touches(suspect.index) && !trial.touches(next * field.ng + suspect.index % field.ng)
        };
        let lists = [
            outliers::places(field, merged(ranked.pairs.iter().filter(pair_stays), &fresh.pairs)),
            outliers::places(field, merged(ranked.across.iter().filter(across_stays), &fresh.across)),
            outliers::places(field, merged(ranked.values.iter().filter(stays), &fresh.values)),
        ];
        outliers::chosen(field, exchange, &lists)
    }
}

/// Two lists in the order of [`outliers::by_gain`] as one.
fn merged<'a>(one: impl Iterator<Item = &'a Suspect>, other: &'a [Suspect]) -> impl Iterator<Item = Suspect> {
    let (mut one, mut other) = (one.peekable(), other.iter().peekable());
    std::iter::from_fn(move || {
        let first = match (one.peek(), other.peek()) {
            (Some(a), Some(b)) => outliers::by_gain(a, b).is_le(),
            (a, _) => a.is_some(),
        };
        if first { one.next() } else { other.next() }.copied()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Finding, Findings};
    use crate::plausible::check;

    struct File {
        name: &'static str,
        planes_deg: Vec<f64>,
        angles_deg: Vec<f64>,
        texts: Vec<String>,
    }

    /// Repeatable noise in ±1.
    fn noise(index: usize) -> f64 {
        let mut bits = (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        bits ^= bits >> 29;
        bits = bits.wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (bits >> 40) as f64 / f64::from(1 << 23) - 1.0
    }

    fn file(name: &'static str, c: (usize, f64), gamma: (usize, f64), light: impl Fn(f64, f64, usize) -> f64) -> File {
        let planes_deg: Vec<f64> = (0..c.0).map(|plane| plane as f64 * c.1).collect();
        let angles_deg: Vec<f64> = (0..gamma.0).map(|angle| angle as f64 * gamma.1).collect();
        let at = |index: usize| {
            let (c, gamma) = (planes_deg[index / gamma.0], angles_deg[index % gamma.0]);
            light(c.to_radians(), gamma.to_radians(), index)
        };
        let texts = (0..c.0 * gamma.0).map(|index| format!("{:.2}", at(index))).collect();
        File {
            name,
            planes_deg,
            angles_deg,
            texts,
        }
    }

    fn files() -> Vec<File> {
        let lobe = |gamma: f64| 300.0 * gamma.cos().max(0.0).powi(2);
        let wide = move |c: f64, gamma: f64| lobe(gamma) * (1.0 + 0.3 * (2.0 * c).cos() * gamma.sin().powi(2));
        vec![
            file("one plane", (1, 0.0), (37, 2.5), |_, gamma, _| lobe(gamma)),
            file("one noisy plane", (1, 0.0), (61, 3.0), |_, gamma, at| {
                (lobe(gamma) + 20.0) * (1.0 + 0.03 * noise(at))
            }),
            file("quadrant", (7, 15.0), (19, 5.0), move |c, gamma, _| wide(c, gamma)),
            file("half, noisy", (13, 15.0), (37, 5.0), move |c, gamma, at| {
                (wide(c, gamma) + 5.0) * (1.0 + 0.02 * noise(at))
            }),
            file("circle that closes", (9, 45.0), (19, 10.0), move |c, gamma, at| {
                wide(c, gamma) + 40.0 + 3.0 * noise(at % 152)
            }),
            file("symmetric circle", (8, 45.0), (19, 10.0), move |c, gamma, _| {
                wide(c, gamma) + 9.0
            }),
            file("three planes", (3, 45.0), (19, 5.0), move |c, gamma, at| {
                wide(c, gamma) * (1.0 + 0.01 * noise(at))
            }),
            file("a display", (12, 30.0), (37, 5.0), move |c, gamma, _| {
                (wide(c, gamma) / 3.0).round() * 3.0
            }),
            file("cut off", (12, 30.0), (37, 2.5), |_, gamma, at| {
                if gamma < 0.6 { 200.0 + noise(at) } else { 0.0 }
            }),
            file("rugged", (6, 60.0), (31, 6.0), |_, _, at| 100.0 + 60.0 * noise(at)),
            file("few angles", (4, 90.0), (5, 22.5), move |c, gamma, _| wide(c, gamma)),
        ]
    }

    fn stored<'s>(
        file: &'s File,
        values: &'s [f64],
        places: &'s [(usize, usize)],
        raw: &'s dyn Fn(usize) -> &'s str,
    ) -> Stored<'s> {
        Stored {
            planes_deg: &file.planes_deg,
            angles_deg: &file.angles_deg,
            values,
            places,
            raw,
            poles: true,
            ends_with_newline: true,
            unit_cd: 1.0,
        }
    }

    /// What the checks say of a file, as [`Told`] has it.
    fn whole(file: &File, texts: &[String]) -> Vec<Told> {
        let values: Vec<f64> = texts.iter().map(|text| text.parse().unwrap()).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let raw = |index: usize| &*texts[index];
        let mut findings = Findings::new();
        let stored = stored(file, &values, &places, &raw);
        check(&stored, false, &mut findings);
        let closing = closing(&stored, &values).map(Told::Closing);
        let told = |finding: Finding| {
            let index = finding.line? - 1;
            let line = finding
                .message
                .split("in line ")
                .nth(1)
                .and_then(|rest| rest.split(' ').next());
            Some(match finding.code {
                "intensity-twin" => Told::Twin(index),
                "intensity-pole" => Told::Pole(index),
                "intensity-outlier" if finding.message.contains("which suggest") => Told::Value(index),
                "intensity-outlier" if finding.message.contains("the next one") => Told::Pair(index),
                "intensity-outlier" => Told::Exchange(index, line?.parse::<usize>().ok()? - 1),
                _ => return None,
            })
        };
        // The readers themselves compare the planes at 0° and 360°.
        findings
            .into_vec()
            .into_iter()
            .filter_map(told)
            .chain(closing)
            .collect()
    }

    #[test]
    fn what_is_kept_is_what_the_whole_would_compute() {
        for file in files() {
            let values: Vec<f64> = file.texts.iter().map(|text| text.parse().unwrap()).collect();
            let places = vec![(1, 1); values.len()];
            let raw = |index: usize| &*file.texts[index];
            let stored = stored(&file, &values, &places, &raw);
            let Some(mut kept) = Outliers::of(&stored) else {
                continue;
            };
            let (count, ng) = (kept.field.values.len(), kept.field.ng);
            let pairs = (0..50).map(|turn| (turn * 7919 % count, (turn * 7919 + [1, ng, 41][turn % 3]) % count));
            for (one, other) in pairs {
                kept.trial.make(&mut kept.field, one, other);
                let fresh = kept.fresh();
                let mut exchanged = values.clone();
                exchanged.swap(one, other);
                let after = Field::new(&stored, &exchanged, kept.step).unwrap();
                let whole = Ranked::of(&after, kept.step);
                let (trial, ranked) = (&kept.trial, &kept.ranked);
                let stays = |suspect: &&Suspect| !trial.touches(suspect.index);
                let pair_stays = |pair: &&Suspect| !trial.touches(pair.index) && !trial.touches(pair.index + 1);
                let name = format!("{}: {one} and {other}", file.name);
                let odd: Vec<Suspect> = merged(ranked.odd.iter().filter(stays), &fresh.odd).collect();
                assert_eq!(odd, whole.odd, "{name}");
                let pairs: Vec<Suspect> = merged(ranked.pairs.iter().filter(pair_stays), &fresh.pairs).collect();
                assert_eq!(pairs, whole.pairs, "{name}");
                let next = |index: usize| kept.field.next_plane(index / ng).unwrap_or(0) * ng + index % ng;
                let across_stays = |pair: &&Suspect| !trial.touches(pair.index) && !trial.touches(next(pair.index));
                let across: Vec<Suspect> = merged(ranked.across.iter().filter(across_stays), &fresh.across).collect();
                assert_eq!(across, whole.across, "{name}");
                kept.trial.take_back(&mut kept.field);
            }
        }
    }

    #[test]
    fn a_rerun_says_what_the_whole_check_says() {
        let mut some = 0;
        for file in files() {
            let values: Vec<f64> = file.texts.iter().map(|text| text.parse().unwrap()).collect();
            let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
            let raw = |index: usize| &*file.texts[index];
            let mut rerun = Rerun::of(&stored(&file, &values, &places, &raw));
            let before = whole(&file, &file.texts);
            let count = values.len();
            let near = (0..count - 1).map(|one| (one, one + 1));
            let across = (0..count - file.angles_deg.len()).map(|one| (one, one + file.angles_deg.len()));
            let far = (0..60).map(|turn| ((turn * 7919) % count, (turn * 104_729 + 5) % count));
            for (one, other) in near.chain(across.step_by(5)).chain(far) {
                let mut texts = file.texts.clone();
                texts.swap(one, other);
                let mut expected = whole(&file, &texts);
                expected.retain(|told| !before.contains(told));
                expected.sort_unstable();
                expected.dedup();
                some += usize::from(!expected.is_empty());
                assert_eq!(rerun.told(one, other), expected, "{}: {one} and {other}", file.name);
            }
        }
        assert!(some > 1000, "{some}");
    }
}
