//! What a file's own smoothness could betray: every two neighbouring intensities are exchanged for a moment, and the checks
//! say whether they would tell it.
//!
//! A file carries hardly any redundancy, so some damage cannot be found by anybody. Which, and how large, can be known:
//! that is what stands here.

use std::fmt;

use serde::{Serialize, Serializer};

use super::Stored;
use super::rerun::Rerun;
use crate::finding::{Finding, Findings, Severity};

/// Which exchanges of two neighbouring intensities the checks would tell, and the largest that they would not.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SelfCheck {
    /// Neighbours along γ.
    #[serde(flatten)]
    pub along_gamma: Exchanges,
    /// Neighbours across planes.
    pub across_planes: Exchanges,
}

/// Exchanges of two neighbours that differ.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exchanges {
    /// How many there are.
    pub exchanges: usize,
    /// How many of them were looked at, those that change most first.
    pub looked_at: usize,
    /// How many of these would be told.
    pub told: usize,
    /// How many would be told at the place of one of the two.
    pub told_in_place: usize,
    /// How many of those looked at change more than 1 % of the largest intensity.
    pub above_1_percent: usize,
    /// Of these, all that would not be told, the largest first.
    pub untold_above_1_percent: Vec<Untold>,
    /// The largest of all that would not be told.
    pub largest_untold: Option<Untold>,
}

/// An exchange that would not be told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Untold {
    /// By how much the two differ.
    pub difference_cd: f64,
    /// By which part of the file's largest intensity.
    pub difference_rel: f64,
    /// Plane of the first.
    pub c_deg: f64,
    /// Angle of the first.
    pub gamma_deg: f64,
    /// One-based lines of both.
    pub lines: [usize; 2],
    /// One-based columns of both.
    pub columns: [usize; 2],
}

/// An exchange above this part of the peak matters to whoever uses the light.
const MATTERS: f64 = 0.01;
/// A file that would not tell more than this part of such exchanges is warned of. Of 137 files by many hands 88 would not tell
/// one at least, 24 more than a tenth, 10 more than a fifth: templates of a few numbers, eight planes with an edge between
/// them, values every 5° through a batwing's corner.
const COARSE: f64 = 0.2;
/// Most exchanges that are looked at, along γ and across planes, and the misfits that may be weighed for each kind. A file
/// of the usual size is looked at whole.
const MOST: [usize; 2] = [2500, 1000];
const WORK: [usize; 2] = [2_000_000, 800_000];

/// Exchanges neighbours one after the other; none where there is no light.
pub(super) fn run(stored: &Stored<'_>, findings: &mut Findings) -> Option<SelfCheck> {
    let (ng, values) = (stored.angles_deg.len(), stored.values);
    let peak = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let whole = ng > 0 && values.len() == ng * stored.planes_deg.len() && values.len() == stored.places.len();
    if !whole || peak <= 0.0 {
        return None;
    }
    let mut rerun = Rerun::of(stored);
    let along = (0..values.len())
        .filter(|index| (index + 1) % ng != 0)
        .map(|index| (index, index + 1));
    let across = (ng..values.len()).map(|index| (index - ng, index));
    let check = SelfCheck {
        along_gamma: exchanges(stored, &mut rerun, peak, along, (MOST[0], WORK[0])),
        across_planes: exchanges(stored, &mut rerun, peak, across, (MOST[1], WORK[1])),
    };
    check.say(findings);
    Some(check)
}

fn exchanges(
    stored: &Stored<'_>,
    rerun: &mut Rerun<'_>,
    peak: f64,
    pairs: impl Iterator<Item = (usize, usize)>,
    (most, work): (usize, usize),
) -> Exchanges {
    let ng = stored.angles_deg.len();
    let mut pairs: Vec<(f64, usize, usize)> = pairs
        .map(|(one, other)| ((stored.values[other] - stored.values[one]).abs(), one, other))
        .filter(|pair| pair.0 > 0.0)
        .collect();
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut found = Exchanges {
        exchanges: pairs.len(),
        ..Exchanges::default()
    };
    let until = rerun.work() + work;
    for (difference, one, other) in pairs.into_iter().take(most) {
        if rerun.work() > until {
            break;
        }
        let matters = difference > MATTERS * peak;
        found.looked_at += 1;
        found.above_1_percent += usize::from(matters);
        let told = rerun.told(one, other);
        if !told.is_empty() {
            let here = told.iter().any(|told| told.index() == one || told.index() == other);
            found.told += 1;
            found.told_in_place += usize::from(here);
            continue;
        }
        let untold = Untold {
            difference_cd: difference * stored.unit_cd,
            difference_rel: difference / peak,
            c_deg: stored.planes_deg[one / ng],
            gamma_deg: stored.angles_deg[one % ng],
            lines: [one, other].map(|index| stored.places[index].0),
            columns: [one, other].map(|index| stored.places[index].1),
        };
        found.largest_untold.get_or_insert(untold);
        if matters {
            found.untold_above_1_percent.push(untold);
        }
    }
    found
}

impl SelfCheck {
    /// Of a file with several tables: all their exchanges together.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self {
            along_gamma: self.along_gamma.with(other.along_gamma),
            across_planes: self.across_planes.with(other.across_planes),
        }
    }

    /// Exchanges above 1 % of the peak that would not be told, and all of them.
    fn untold_of(&self) -> (usize, usize) {
        let kinds = [&self.along_gamma, &self.across_planes];
        let untold = kinds.iter().map(|kind| kind.untold_above_1_percent.len()).sum();
        (untold, kinds.iter().map(|kind| kind.above_1_percent).sum())
    }

    fn say(&self, findings: &mut Findings) {
        let (untold, all) = self.untold_of();
        let kinds = [&self.along_gamma, &self.across_planes];
        let largest = kinds.iter().filter_map(|kind| kind.untold_above_1_percent.first());
        let Some(largest) = largest.max_by(|a, b| a.difference_rel.total_cmp(&b.difference_rel)) else {
            return;
        };
        let coarse = untold as f64 > COARSE * all as f64;
        let message = format!(
            "of {all} exchanges of two neighbouring intensities above 1 % of the peak{} {untold} would be told by no check{}; the \
             largest: {}",
            if kinds.iter().any(|kind| kind.looked_at < kind.exchanges) {
                " that were looked at"
            } else {
                ""
            },
            if coarse {
                ": the light is too coarse or too rugged"
            } else {
                ""
            },
            largest.place()
        );
        let severity = if coarse { Severity::Warning } else { Severity::Note };
        findings.push(
            Finding::new(severity, "intensity-self-check", message)
                .at(largest.lines[0], largest.columns[0])
                .assumed("the values as they stand")
                .fix("compare the file with its source; its light alone cannot show such a change"),
        );
    }
}

impl Exchanges {
    fn with(mut self, other: Self) -> Self {
        self.exchanges += other.exchanges;
        self.looked_at += other.looked_at;
        self.told += other.told;
        self.told_in_place += other.told_in_place;
        self.above_1_percent += other.above_1_percent;
        self.untold_above_1_percent.extend(other.untold_above_1_percent);
        let by_size = |a: &Untold, b: &Untold| b.difference_cd.total_cmp(&a.difference_cd);
        self.untold_above_1_percent.sort_by(by_size);
        self.largest_untold = self
            .largest_untold
            .into_iter()
            .chain(other.largest_untold)
            .min_by(by_size);
        self
    }
}

impl Untold {
    /// Size and place, for a person.
    fn place(&self) -> String {
        format!(
            "{} cd ({:.2} % of the peak), lines {} and {}, C {}°, γ {}°",
            crate::significant(self.difference_cd, 3),
            100.0 * self.difference_rel,
            self.lines[0],
            self.lines[1],
            crate::significant(self.c_deg, 6),
            crate::significant(self.gamma_deg, 6)
        )
    }
}

impl fmt::Display for Exchanges {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "{} of {} exchanges of neighbours would be told",
            self.told, self.looked_at
        )?;
        if self.looked_at < self.exchanges {
            write!(out, ", the largest of {}", self.exchanges)?;
        }
        let told = self.above_1_percent - self.untold_above_1_percent.len();
        write!(out, " (above 1 % of the peak {told} of {})", self.above_1_percent)?;
        match &self.largest_untold {
            Some(largest) => write!(out, "; the largest that would not: {}", largest.place()),
            None => Ok(()),
        }
    }
}

impl Serialize for Exchanges {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Row {
            exchanges: usize,
            looked_at: usize,
            told: usize,
            told_in_place: usize,
            above_1_percent: usize,
            above_1_percent_told: usize,
            largest_untold_cd: Option<f64>,
            largest_untold_rel: Option<f64>,
            c_deg: Option<f64>,
            gamma_deg: Option<f64>,
            line: Option<usize>,
            column: Option<usize>,
            other_line: Option<usize>,
            other_column: Option<usize>,
        }
        let largest = self.largest_untold.as_ref();
        Row {
            exchanges: self.exchanges,
            looked_at: self.looked_at,
            told: self.told,
            told_in_place: self.told_in_place,
            above_1_percent: self.above_1_percent,
            above_1_percent_told: self.above_1_percent - self.untold_above_1_percent.len(),
            largest_untold_cd: largest.map(|untold| untold.difference_cd),
            largest_untold_rel: largest.map(|untold| untold.difference_rel),
            c_deg: largest.map(|untold| untold.c_deg),
            gamma_deg: largest.map(|untold| untold.gamma_deg),
            line: largest.map(|untold| untold.lines[0]),
            column: largest.map(|untold| untold.columns[0]),
            other_line: largest.map(|untold| untold.lines[1]),
            other_column: largest.map(|untold| untold.columns[1]),
        }
        .serialize(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One plane with a value every 2.5°, of 2 cd a unit.
    fn with_stored<T>(values: &[f64], run: impl FnOnce(&Stored<'_>) -> T) -> T {
        let angles_deg: Vec<f64> = (0..values.len()).map(|angle| angle as f64 * 2.5).collect();
        let places: Vec<(usize, usize)> = (0..values.len()).map(|index| (index + 1, 1)).collect();
        let texts: Vec<String> = values.iter().map(|value| format!("{value:.2}")).collect();
        run(&Stored {
            planes_deg: &[0.0],
            angles_deg: &angles_deg,
            values,
            places: &places,
            raw: &|index| &texts[index],
            poles: true,
            ends_with_newline: true,
            unit_cd: 2.0,
        })
    }

    #[test]
    fn counts_what_would_be_told_and_names_the_largest_that_would_not() {
        // A smooth lobe of one plane, with a flat foot where two values differ by the last digit.
        let values: Vec<f64> = (0..37)
            .map(|at| 500.0 * (f64::from(at) * 2.5).to_radians().cos().powi(2))
            .map(|value| (value * 100.0).round() / 100.0)
            .collect();
        let mut findings = Findings::new();
        let check = with_stored(&values, |stored| run(stored, &mut findings)).unwrap();
        let along = &check.along_gamma;
        assert_eq!((along.exchanges, along.looked_at), (36, 36));
        assert_eq!(check.across_planes.exchanges, 0);
        // By hand: the file with the two of them exchanged, read again.
        let told = |one: usize| {
            let mut values = values.clone();
            values.swap(one, one + 1);
            let mut findings = Findings::new();
            with_stored(&values, |stored| crate::plausible::check(stored, false, &mut findings));
            !findings.into_vec().is_empty()
        };
        assert_eq!(along.told, (0..36).filter(|&one| told(one)).count());
        let untold = (0..36).filter(|&one| !told(one));
        let largest = untold
            .map(|one| 2.0 * (values[one] - values[one + 1]).abs())
            .fold(0.0, f64::max);
        let stands = along.largest_untold.unwrap();
        assert_eq!(stands.difference_cd, largest);
        assert!(!told(stands.lines[0] - 1));
        let json = serde_json::to_value(&check).unwrap();
        assert_eq!(json["told"], along.told);
        assert_eq!(json["line"], stands.lines[0]);
        assert!(json["across_planes"]["line"].is_null());
    }
}
