//! Readings whose scatter is compared with that of the others: blocks, half-planes, angles, ranges, stretches of time,
//! maps.

use std::collections::HashMap;

use super::limits::{PARTS, SCALE};
use super::series::Series;
use crate::table::{Coordinate, Light, ObservationKind};

/// Rows that belong together.
pub(super) struct Group {
    pub(super) members: Vec<u32>,
    pub(super) coordinate: Coordinate,
    pub(super) range: [f64; 2],
    pub(super) name: String,
    /// Whether it scatters more than the others by more than what counts as noise, and how much more than the others.
    pub(super) apart: Option<f64>,
}

/// Groups of fewer rows say little.
const FEWEST: usize = 6;

/// The groups of a series.
pub(super) fn groups(series: &Series<'_>) -> Vec<Group> {
    let mut grouping = Grouping {
        series,
        squares: series.plain.iter().map(|value| value * value).sum(),
        groups: Vec::new(),
    };
    match series.source {
        ObservationKind::Reading => grouping.readings(),
        _ => grouping.maps(),
    }
    grouping.groups
}

/// The groups of a series, one after the other.
struct Grouping<'s, 'a> {
    series: &'s Series<'a>,
    /// Sum of the squared residuals of all rows.
    squares: f64,
    groups: Vec<Group>,
}

impl Grouping<'_, '_> {
    /// A group of rows; nothing where they are too few or nearly all.
    fn add(&mut self, coordinate: Coordinate, name: &str, members: Vec<usize>) {
        let (series, n) = (self.series, self.series.len());
        if members.len() < FEWEST || 10 * members.len() > 7 * n {
            return;
        }
        let at = |i: &usize| match coordinate {
            Coordinate::Index => series.index[*i],
            _ => series.rows[*i].coordinate(coordinate, series.level[*i]),
        };
        let (low, high) = members
            .iter()
            .map(at)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                (low.min(at), high.max(at))
            });
        let count = members.len() as f64;
        let own = members.iter().map(|&i| series.plain[i].powi(2)).sum::<f64>();
        let others = ((self.squares - own).max(0.0) / (n as f64 - count)).sqrt();
        let own = (own / count).sqrt();
        self.groups.push(Group {
            members: members.iter().map(|&i| i as u32).collect(),
            coordinate,
            range: [low, high],
            name: name.to_owned(),
            apart: (own > SCALE * others).then(|| own / others.max(f64::MIN_POSITIVE)),
        });
    }

    /// Rows of the same key, for each key.
    fn by(&self, key: impl Fn(usize) -> Option<u64>) -> Vec<Vec<usize>> {
        let mut known: HashMap<u64, usize> = HashMap::new();
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for i in 0..self.series.len() {
            let Some(key) = key(i) else { continue };
            let at = *known.entry(key).or_insert(groups.len());
            if at == groups.len() {
                groups.push(Vec::new());
            }
            groups[at].push(i);
        }
        groups
    }

    fn readings(&mut self) {
        let (series, n) = (self.series, self.series.len());
        let row = |i: usize| series.rows[i];
        let illuminated = |i: usize| row(i).light == Light::Lit;
        for members in self.by(|i| Some((row(i).file as u64) << 32 | row(i).group as u64)) {
            self.add(Coordinate::Index, "one block", members);
        }
        let visits = series.visits();
        let first = |visit: &Vec<usize>| visit.first().copied();
        self.add(
            Coordinate::Index,
            "the first of each visit of a half-plane",
            visits
                .iter()
                .filter(|visit| visit.len() > 2)
                .filter_map(first)
                .collect(),
        );
        let range = |k: usize| row(k).range.to_bits();
        let switched = |k: &usize| series.follows[*k] && range(*k) != range(*k - 1);
        self.add(
            Coordinate::Index,
            "the first after each change of the range",
            (1..n).filter(switched).collect(),
        );
        for members in visits {
            self.add(Coordinate::Index, "one visit of a half-plane", members);
        }
        for members in self.by(|i| illuminated(i).then(|| row(i).c_deg.to_bits())) {
            self.add(Coordinate::CDeg, "one C plane", members);
        }
        for members in self.by(|i| Some(row(i).distance_mm.to_bits())) {
            self.add(Coordinate::DistanceMm, "one distance", members);
        }
        for members in self.by(|i| Some(row(i).range.to_bits())) {
            self.add(Coordinate::Range, "one range", members);
        }
        for light in [Light::Baffled, Light::LampOff, Light::Capped] {
            let members = (0..n).filter(|&i| row(i).light == light).collect();
            self.add(Coordinate::Index, "the dark readings", members);
        }
        for side in [false, true] {
            let angle = |i: &usize| {
                if side {
                    row(*i).gamma_deg
                } else {
                    row(*i).gamma_deg.abs()
                }
            };
            let mut order: Vec<usize> = (0..n)
                .filter(|&i| illuminated(i) && row(i).gamma_deg.is_finite())
                .collect();
            order.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
            for k in 0..8 {
                let members = order[k * order.len() / 8..(k + 1) * order.len() / 8].to_vec();
                self.add(Coordinate::GammaDeg, "some γ", members);
            }
        }
        for length in PARTS.into_iter().filter(|length| 3 * length < n) {
            for from in (0..=n - length).step_by(length / 2) {
                self.add(
                    Coordinate::Index,
                    "one part of the record",
                    (from..from + length).collect(),
                );
            }
        }
    }

    fn maps(&mut self) {
        let (series, n) = (self.series, self.series.len());
        let row = |i: usize| series.rows[i];
        let illuminated = |i: usize| row(i).light == Light::Lit;
        for members in self.by(|i| Some((row(i).file as u64) << 32 | row(i).group as u64)) {
            self.add(Coordinate::Exposure, "one map", members);
        }
        for (coordinate, name) in [
            (Coordinate::RadiusMm, "one ring"),
            (Coordinate::XMm, "some columns"),
            (Coordinate::YMm, "some rows"),
        ] {
            let at = |i: &usize| row(*i).coordinate(coordinate, 0.0);
            let mut order: Vec<usize> = (0..n).filter(|&i| illuminated(i)).collect();
            order.sort_by(|a, b| at(a).total_cmp(&at(b)));
            for k in 0..8 {
                let members = order[k * order.len() / 8..(k + 1) * order.len() / 8].to_vec();
                self.add(coordinate, name, members);
            }
        }
    }
}
