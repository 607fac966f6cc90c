//! Readings that are off together: every n-th, successive ones, neighbouring directions, directions along a great
//! circle, neighbouring bins.
//!
//! A place is a list of cells with weights, a cell a few rows that every place of its level takes together: thousands
//! of places of thousands of readings would not fit in memory.

use std::collections::{BTreeSet, HashMap};

use isolux_photometry::direction;

use super::finding::{Finding, Strongest};
use super::limits::{CENTRES, CIRCLE_DEG, CIRCLES_APART_DEG, EVERY, EVERY_VISIT, PATCH_DEG, PATCH_SHARE, RARE, RUNS};
use super::place::What;
use super::series::{RELATIVE, Series};
use super::statistic::Test;
use crate::table::{Coordinate, Light, Row};

/// Cells whose rows may be off together, with weights such that the whole has unit length.
struct Together {
    cells: Vec<(u32, f32)>,
    what: What,
}

/// A row that is in no cell of a level.
const NOWHERE: u32 = u32::MAX;
/// Cells in the width of a patch.
const CELLS_A_WIDTH: f64 = 4.0;
/// Patches end where their weight is a twentieth.
const REACH: f64 = 2.5;

/// The direction of a lit reading.
fn lit_direction(row: &Row) -> Option<[f64; 3]> {
    let towards = direction(row.c_deg, row.gamma_deg).to_array();
    (row.light == Light::Lit && towards.iter().all(|part| part.is_finite())).then_some(towards)
}

/// Places of one kind.
#[derive(Default)]
pub(super) struct Patches {
    /// Of each level the cell of each row, the first cell of a level after the last of the one before.
    levels: Vec<Vec<u32>>,
    /// Rows of each cell.
    counts: Vec<u32>,
    /// What an error of one size does to each row, in its stated uncertainty; 1 where this is empty.
    errs: Vec<f64>,
    /// Sum of the squares of the above over the rows of each cell.
    squares: Vec<f64>,
    places: Vec<Together>,
}

impl Patches {
    /// Adds a level whose row `i` is in cell `cell(i)`, and returns the number of its first cell and how many it has.
    fn level(&mut self, rows: usize, mut cell: impl FnMut(usize) -> Option<usize>) -> (usize, usize) {
        let first = self.counts.len();
        let errs = |i: usize| self.errs.get(i).map_or(1.0, |errs| errs * errs);
        let numbers: Vec<u32> = (0..rows)
            .map(|i| {
                let Some(number) = cell(i) else { return NOWHERE };
                let number = first + number;
                if number >= self.counts.len() {
                    self.counts.resize(number + 1, 0);
                    self.squares.resize(number + 1, 0.0);
                }
                self.counts[number] += 1;
                self.squares[number] += errs(i);
                number as u32
            })
            .collect();
        self.levels.push(numbers);
        (first, self.counts.len() - first)
    }

    /// A level whose rows are in one cell where their keys are the same, and the mean of `at` over the rows of each
    /// cell.
    fn keyed<const N: usize>(
        &mut self,
        rows: usize,
        width: f64,
        at: impl Fn(usize) -> Option<[f64; N]>,
    ) -> (usize, Vec<[f64; N]>) {
        let mut known: HashMap<[i64; N], usize> = HashMap::new();
        let mut sums: Vec<[f64; N]> = Vec::new();
        let (first, _) = self.level(rows, |i| {
            let at = at(i)?;
            let number = *known
                .entry(at.map(|part| (part / width).round() as i64))
                .or_insert(sums.len());
            if number == sums.len() {
                sums.push([0.0; N]);
            }
            for (sum, part) in sums[number].iter_mut().zip(at) {
                *sum += part;
            }
            Some(number)
        });
        let mean = |(k, sum): (usize, [f64; N])| sum.map(|part| part / f64::from(self.counts[first + k]));
        (first, sums.into_iter().enumerate().map(mean).collect())
    }

    /// A place of these cells; nothing where fewer than two rows are in them.
    fn place(&mut self, cells: impl Iterator<Item = (usize, f64)>, what: What) {
        let mut cells: Vec<(u32, f32)> = cells.map(|(cell, weight)| (cell as u32, weight as f32)).collect();
        let rows = |cell: u32| self.counts[cell as usize];
        let length: f64 = cells
            .iter()
            .map(|&(cell, w)| self.squares[cell as usize] * f64::from(w).powi(2))
            .sum();
        if cells.iter().map(|&(cell, _)| rows(cell)).sum::<u32>() < 2 || length <= 0.0 {
            return;
        }
        for (_, weight) in &mut cells {
            *weight /= length.sqrt() as f32;
        }
        cells.shrink_to_fit();
        self.places.push(Together { cells, what });
    }

    fn some(self) -> Option<Self> {
        (!self.places.is_empty()).then_some(self)
    }

    /// Every second to every [`EVERY`]-th reading.
    pub(super) fn every(series: &Series<'_>) -> Option<Self> {
        let mut all = Self::default();
        let number = |i: usize| series.index[i].round() as i64;
        for n in 2..=EVERY.min(series.len() / 8) {
            let (first, cells) = all.level(series.len(), |i| Some(number(i).rem_euclid(n as i64) as usize));
            for phase in 0..cells {
                all.place(std::iter::once((first + phase, 1.0)), What::Every(n, phase));
            }
        }
        all.some()
    }

    /// Every second to every [`EVERY_VISIT`]-th visit of a half-plane.
    pub(super) fn every_visit(series: &Series<'_>) -> Option<Self> {
        let visits: Vec<Vec<usize>> = series
            .visits()
            .into_iter()
            .filter(|visit| visit.len() > 2 && series.rows[visit[0]].light == Light::Lit)
            .collect();
        let mut number = vec![None; series.len()];
        for (visit, members) in visits.iter().enumerate() {
            for &i in members {
                number[i] = Some(visit);
            }
        }
        let mut all = Self::default();
        for n in (2..=EVERY_VISIT).filter(|n| 2 * n <= visits.len()) {
            let (first, cells) = all.level(series.len(), |i| number[i].map(|visit: usize| visit % n));
            for phase in 0..cells {
                all.place(std::iter::once((first + phase, 1.0)), What::Visits(n, phase));
            }
        }
        all.some()
    }

    /// Runs of successive readings, each begun a third of its length after the one before.
    pub(super) fn runs(series: &Series<'_>) -> Option<Self> {
        let mut all = Self::default();
        for length in RUNS.into_iter().filter(|length| 3 * length < series.len()) {
            let step = (length / 3).max(1);
            let (first, _) = all.level(series.len(), |i| Some(i / step));
            for from in (0..=series.len() - length).step_by(step) {
                let cells = (from / step..(from + length) / step).map(|cell| (first + cell, 1.0));
                all.place(cells, What::Run(from, from + length - 1));
            }
        }
        all.some()
    }

    /// Neighbouring directions of lit readings.
    pub(super) fn directions(series: &Series<'_>) -> Option<Self> {
        let direction = |i: usize| lit_direction(series.rows[i]);
        // Directions two degrees apart or less are one centre.
        let mut known = BTreeSet::new();
        let centres: Vec<(usize, [f64; 3])> = (0..series.len())
            .filter_map(|i| Some((i, direction(i)?)))
            .filter(|(_, towards)| known.insert(towards.map(|part| (30.0 * part).round() as i32)))
            .collect();
        let every = centres.len().div_ceil(CENTRES).max(1);
        let mut all = Self::default();
        for width in PATCH_DEG {
            let (first, cells) = all.keyed(series.len(), width.to_radians() / CELLS_A_WIDTH, direction);
            for (at, centre) in centres.iter().step_by(every) {
                let near = cells.iter().enumerate().filter_map(|(k, towards)| {
                    let cosine: f64 = towards.iter().zip(centre).map(|(a, b)| a * b).sum();
                    let apart = cosine.clamp(-1.0, 1.0).acos().to_degrees() / width;
                    (apart < REACH).then(|| (first + k, (-0.5 * apart * apart).exp()))
                });
                let row = series.rows[*at];
                all.place(near, What::Directions(row.c_deg, row.gamma_deg, width));
            }
        }
        all.some()
    }

    /// Lit readings near one great circle of directions: what a wire across the beam shades.
    pub(super) fn circles(series: &Series<'_>) -> Option<Self> {
        let mut all = Self {
            errs: series.errors[RELATIVE].clone(),
            ..Self::default()
        };
        for width in CIRCLE_DEG {
            let illuminated = |i: usize| lit_direction(series.rows[i]);
            let (first, cells) = all.keyed(series.len(), width.to_radians() / CELLS_A_WIDTH, illuminated);
            // Poles of one hemisphere: those of the other are of the same circles.
            let rings = (90.0 / CIRCLES_APART_DEG).round() as usize;
            for ring in 1..=rings {
                let gamma_deg = ring as f64 * CIRCLES_APART_DEG;
                let half = if ring == rings { 180.0 } else { 360.0 };
                let count = (half * gamma_deg.to_radians().sin() / CIRCLES_APART_DEG)
                    .round()
                    .max(1.0) as usize;
                for k in 0..count {
                    let c_deg = half * k as f64 / count as f64;
                    let pole = direction(c_deg, gamma_deg).to_array();
                    let near = cells.iter().enumerate().filter_map(|(k, towards)| {
                        let sine: f64 = towards.iter().zip(&pole).map(|(a, b)| a * b).sum();
                        let apart = sine.clamp(-1.0, 1.0).asin().to_degrees() / width;
                        (apart.abs() < REACH).then(|| (first + k, (-0.5 * apart * apart).exp()))
                    });
                    all.place(near, What::Circle(c_deg, gamma_deg, width));
                }
            }
        }
        all.some()
    }

    /// Every second to every eighth column and row of the bins.
    pub(super) fn lines(series: &Series<'_>) -> Option<Self> {
        let mut all = Self::default();
        for coordinate in [Coordinate::XMm, Coordinate::YMm] {
            let at = |i: usize| series.rows[i].coordinate(coordinate, 0.0);
            let mut places: Vec<f64> = (0..series.len()).map(at).collect();
            places.sort_by(f64::total_cmp);
            places.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
            let line: Vec<usize> = (0..series.len())
                .map(|i| places.partition_point(|place| *place < at(i) - 1e-9))
                .collect();
            for n in 2..=8 {
                let (first, cells) = all.level(series.len(), |i| Some(line[i] % n));
                for phase in 0..cells {
                    all.place(std::iter::once((first + phase, 1.0)), What::Lines(coordinate, n));
                }
            }
        }
        all.some()
    }

    /// Neighbouring bins, the same in all lit maps.
    pub(super) fn bins(series: &Series<'_>) -> Option<Self> {
        let at = |i: usize| {
            let row = series.rows[i];
            (row.light == Light::Lit).then_some([row.x_mm, row.y_mm])
        };
        let reach = (0..series.len())
            .filter_map(at)
            .fold(0.0_f64, |most, [x, _]| most.max(x.abs()));
        let centre = |k: usize| reach * (2.0 * k as f64 / 11.0 - 1.0);
        let mut all = Self::default();
        for share in PATCH_SHARE {
            let width = 2.0 * share * reach;
            if width <= 0.0 {
                continue;
            }
            let (first, cells) = all.keyed(series.len(), width / CELLS_A_WIDTH, at);
            for k in 0..144 {
                let (x, y) = (centre(k % 12), centre(k / 12));
                let near = cells.iter().enumerate().filter_map(|(k, place)| {
                    let apart = (place[0] - x).hypot(place[1] - y) / width;
                    (apart < REACH).then(|| (first + k, (-0.5 * apart * apart).exp()))
                });
                all.place(near, What::Bins(x, y, width));
            }
        }
        all.some()
    }

    /// Sum of the values of each cell.
    fn sums(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.counts.len()];
        for level in &self.levels {
            for (i, (&cell, value)) in level.iter().zip(values).enumerate() {
                if cell != NOWHERE {
                    sums[cell as usize] += value * self.errs.get(i).unwrap_or(&1.0);
                }
            }
        }
        sums
    }

    fn amplitude(&self, place: usize, sums: &[f64]) -> f64 {
        self.places[place]
            .cells
            .iter()
            .map(|&(cell, weight)| f64::from(weight) * sums[cell as usize])
            .sum()
    }
}

impl Test for Patches {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        let sums = self.sums(values);
        for place in 0..self.places.len() {
            best.raise(0.5 * self.amplitude(place, &sums).powi(2), place);
        }
        best
    }

    fn share(&self) -> f64 {
        // Great circles alone have errors.
        if self.errs.is_empty() { 1.0 } else { RARE }
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let whole = self.amplitude(strongest.place, &self.sums(&series.plain));
        let what = self.places[strongest.place].what;
        let (kind, coordinate, range, note) = what.stated(series, if whole > 0.0 { "above" } else { "below" });
        let mut finding = Finding::new(kind, coordinate, range, strongest, note).explaining(whole * whole);
        match what {
            What::Every(n, _) => finding.period = Some(n as f64),
            What::Directions(c_deg, gamma_deg, width) => finding.direction = Some([c_deg, gamma_deg, width]),
            _ => {}
        }
        finding
    }
}
