//! Readings that are off together: every n-th, successive ones, neighbouring directions, neighbouring bins.

use std::collections::BTreeSet;

use super::limits::{CENTRES, EVERY, PATCH_DEG, PATCH_SHARE, RUNS};
use super::series::Series;
use super::{Finding, Kind, Strongest, Test, digits};
use crate::table::{Coordinate, Light};

/// Rows that may be off together, with weights of unit length.
struct Together {
    /// In single precision: there are thousands of places of thousands of readings.
    members: Vec<(u32, f32)>,
    what: What,
}

#[derive(Clone, Copy)]
enum What {
    /// Every so-manieth reading, from which.
    Every(usize, usize),
    /// Columns or rows of bins.
    Lines(Coordinate, usize),
    /// From and to which of the series.
    Run(usize, usize),
    /// C, γ and width in degrees.
    Directions(f64, f64, f64),
    /// x, y and width in mm.
    Bins(f64, f64, f64),
}

/// Places of one kind.
pub(super) struct Patches {
    places: Vec<Together>,
}

impl Patches {
    fn of(places: impl Iterator<Item = (Vec<(u32, f64)>, What)>) -> Option<Self> {
        let unit = |(members, what): (Vec<(u32, f64)>, What)| {
            let length = members.iter().map(|(_, w)| w * w).sum::<f64>().sqrt();
            let members: Vec<(u32, f32)> = members.into_iter().map(|(i, w)| (i, (w / length) as f32)).collect();
            (members.len() >= 2 && length > 0.0).then_some(Together { members, what })
        };
        let places: Vec<Together> = places.filter_map(unit).collect();
        (!places.is_empty()).then_some(Self { places })
    }

    /// Every second to every [`EVERY`]-th reading.
    pub(super) fn every(series: &Series<'_>) -> Option<Self> {
        let number = |i: usize| series.index[i].round() as i64;
        Self::of((2..=EVERY.min(series.len() / 8)).flat_map(|n| {
            (0..n).map(move |phase| {
                let members = (0..series.len())
                    .filter(|&i| number(i).rem_euclid(n as i64) == phase as i64)
                    .map(|i| (i as u32, 1.0))
                    .collect();
                (members, What::Every(n, phase))
            })
        }))
    }

    /// Runs of successive readings.
    pub(super) fn runs(series: &Series<'_>) -> Option<Self> {
        let n = series.len();
        Self::of(RUNS.into_iter().filter(|length| 3 * length < n).flat_map(|length| {
            (0..=n - length).step_by((length / 3).max(1)).map(move |from| {
                let members = (from..from + length).map(|i| (i as u32, 1.0)).collect();
                (members, What::Run(from, from + length - 1))
            })
        }))
    }

    /// Neighbouring directions of lit readings.
    pub(super) fn directions(series: &Series<'_>) -> Option<Self> {
        let direction = |i: usize| {
            let (sin_c, cos_c) = series.rows[i].c_deg.to_radians().sin_cos();
            let (sin_g, cos_g) = series.rows[i].gamma_deg.to_radians().sin_cos();
            [sin_g * cos_c, sin_g * sin_c, cos_g]
        };
        let lit: Vec<(usize, [f64; 3])> = (0..series.len())
            .filter(|&i| series.rows[i].light == Light::Lit)
            .map(|i| (i, direction(i)))
            .filter(|(_, d)| d.iter().all(|part| part.is_finite()))
            .collect();
        // Directions two degrees apart or less are one centre.
        let mut known = BTreeSet::new();
        let cell = |d: &[f64; 3]| d.map(|part| (30.0 * part).round() as i32);
        let centres: Vec<&(usize, [f64; 3])> = lit.iter().filter(|(_, d)| known.insert(cell(d))).collect();
        let every = centres.len().div_ceil(CENTRES).max(1);
        let row = |i: usize| (series.rows[i].c_deg, series.rows[i].gamma_deg);
        Self::of(centres.into_iter().step_by(every).flat_map(|(at, centre)| {
            let lit = &lit;
            PATCH_DEG.into_iter().map(move |width| {
                let near = lit.iter().filter_map(|(i, d)| {
                    let cosine: f64 = d.iter().zip(centre).map(|(a, b)| a * b).sum();
                    let apart = cosine.clamp(-1.0, 1.0).acos().to_degrees() / width;
                    (apart < 2.5).then(|| (*i as u32, (-0.5 * apart * apart).exp()))
                });
                let (c_deg, gamma_deg) = row(*at);
                (near.collect(), What::Directions(c_deg, gamma_deg, width))
            })
        }))
    }

    /// Every second to every eighth column and row of the bins.
    pub(super) fn lines(series: &Series<'_>) -> Option<Self> {
        let of = |coordinate: Coordinate| {
            let at = |i: usize| series.rows[i].coordinate(coordinate, 0.0);
            let mut places: Vec<f64> = (0..series.len()).map(at).collect();
            places.sort_by(f64::total_cmp);
            places.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            let number: Vec<usize> = (0..series.len())
                .map(|i| places.partition_point(|place| *place < at(i) - 1e-9))
                .collect();
            (2..=8_usize).flat_map(move |n| {
                let number = number.clone();
                (0..n).map(move |phase| {
                    let chosen = number.iter().enumerate().filter(|(_, line)| *line % n == phase);
                    (
                        chosen.map(|(i, _)| (i as u32, 1.0)).collect(),
                        What::Lines(coordinate, n),
                    )
                })
            })
        };
        Self::of(of(Coordinate::XMm).chain(of(Coordinate::YMm)))
    }

    /// Neighbouring bins, the same in all lit maps.
    pub(super) fn bins(series: &Series<'_>) -> Option<Self> {
        let lit: Vec<usize> = (0..series.len())
            .filter(|&i| series.rows[i].light == Light::Lit)
            .collect();
        let reach = lit.iter().fold(0.0_f64, |most, &i| most.max(series.rows[i].x_mm.abs()));
        let lit = &lit;
        let centre = move |k: usize| reach * (2.0 * k as f64 / 11.0 - 1.0);
        Self::of((0..144).flat_map(move |k| {
            let (x, y) = (centre(k % 12), centre(k / 12));
            PATCH_SHARE.into_iter().map(move |share| {
                let width = 2.0 * share * reach;
                let near = lit.iter().filter_map(|&i| {
                    let row = series.rows[i];
                    let apart = (row.x_mm - x).hypot(row.y_mm - y) / width;
                    (apart < 2.5).then(|| (i as u32, (-0.5 * apart * apart).exp()))
                });
                (near.collect(), What::Bins(x, y, width))
            })
        }))
    }

    fn amplitude(&self, place: usize, values: &[f64]) -> f64 {
        self.places[place]
            .members
            .iter()
            .map(|&(i, weight)| f64::from(weight) * values[i as usize])
            .sum()
    }
}

impl Test for Patches {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for place in 0..self.places.len() {
            best.raise(0.5 * self.amplitude(place, values).powi(2), place);
        }
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let whole = self.amplitude(strongest.place, &series.plain);
        let sign = if whole > 0.0 { "above" } else { "below" };
        let (kind, coordinate, range, note) = match self.places[strongest.place].what {
            What::Every(n, phase) => {
                let (first, last) = (series.index[0], series.index[series.len() - 1]);
                let from = (0..series.len())
                    .find(|&i| (series.index[i].round() as i64).rem_euclid(n as i64) == phase as i64)
                    .map_or(0.0, |i| series.index[i]);
                let note = format!("every {n}th reading from number {from} on is {sign} the model");
                (Kind::Every, Coordinate::Index, [first, last], note)
            }
            What::Lines(coordinate, n) => {
                let reach = series.rows.iter().fold(0.0_f64, |most, row| most.max(row.x_mm.abs()));
                let of = if coordinate == Coordinate::XMm { "column" } else { "row" };
                let note = format!("every {n}th {of} of bins is {sign} the model");
                (Kind::Every, coordinate, [-reach, reach], note)
            }
            What::Run(from, to) => {
                let note = format!("{} successive readings are {sign} the model", to - from + 1);
                (
                    Kind::Run,
                    Coordinate::Index,
                    [series.index[from], series.index[to]],
                    note,
                )
            }
            What::Directions(c_deg, gamma_deg, width) => {
                let note = format!(
                    "a patch of neighbouring directions around C {}°, γ {}° (about {} ° wide) is {sign} the model",
                    digits(c_deg),
                    digits(gamma_deg),
                    digits(2.4 * width)
                );
                let range = [gamma_deg - 1.2 * width, gamma_deg + 1.2 * width];
                (Kind::Patch, Coordinate::GammaDeg, range, note)
            }
            What::Bins(x, y, width) => {
                let note = format!(
                    "a patch of bins around x {} mm, y {} mm is {sign} the model",
                    digits(x),
                    digits(y)
                );
                (Kind::Patch, Coordinate::XMm, [x - 1.2 * width, x + 1.2 * width], note)
            }
        };
        let mut finding = Finding::new(kind, coordinate, range, strongest, note).explaining(whole * whole);
        match self.places[strongest.place].what {
            What::Every(n, _) => finding.period = Some(n as f64),
            What::Directions(c_deg, gamma_deg, width) => finding.direction = Some([c_deg, gamma_deg, width]),
            _ => {}
        }
        finding
    }
}
