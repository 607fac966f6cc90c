//! Readings or bins that are off together: the sum of each place, against the same of other orders.
//!
//! A place is a list of cells with weights, a cell a few rows that every place of its grid takes together: thousands
//! of places of thousands of readings would not fit in memory.

use std::collections::HashMap;

use super::finding::{Finding, Strongest};
use super::limits::RARE;
use super::series::{RELATIVE, Series};
use super::statistic::Test;
use crate::patterns::{Grid, Grids, Place, Shape};

/// Cells whose rows may be off together, with weights such that the whole has unit length.
struct Together {
    cells: Vec<(u32, f32)>,
    place: Place,
}

/// A row that is in no cell of a grid.
const NOWHERE: u32 = u32::MAX;
/// Bumps end so many widths from their centres, where their weight is a twentieth.
const REACH: f64 = 2.5;

/// Places of one kind.
#[derive(Default)]
pub(super) struct Patches {
    /// Of each grid the cell of each row, the first cell of a grid after the last of the one before.
    grids: Vec<Vec<u32>>,
    /// Rows of each cell.
    counts: Vec<u32>,
    /// What an error of one size does to each row, in its stated uncertainty; 1 where this is empty.
    errs: Vec<f64>,
    /// Sum of the squares of the above over the rows of each cell.
    squares: Vec<f64>,
    places: Vec<Together>,
}

impl Patches {
    /// Places of one kind; none where there are none.
    pub(super) fn new(series: &Series<'_>, grids: Grids) -> Option<Self> {
        Self::default().with(series, grids)
    }

    /// The same of errors relative to the light, which are rare.
    pub(super) fn of_the_light(series: &Series<'_>, grids: Grids) -> Option<Self> {
        let errs = series.errors[RELATIVE].clone();
        let all = Self {
            errs,
            ..Self::default()
        };
        all.with(series, grids)
    }

    fn with(mut self, series: &Series<'_>, grids: Grids) -> Option<Self> {
        let least = Shape::Bump(0.0, 1.0).weight(REACH);
        for grid in grids(series) {
            let (first, cells) = self.cells(&grid, series.len());
            for place in grid.places {
                let (along, shape) = place.shape();
                let near = match shape {
                    // (cells of runs are in the order of the readings)
                    Shape::Between(from, to) => {
                        cells.partition_point(|at| at[0] < from)..cells.partition_point(|at| at[0] <= to)
                    }
                    _ => 0..cells.len(),
                };
                let weights = near.map(|cell| (first + cell, shape.weight(along.place(cells[cell]))));
                self.place(weights.filter(|(_, weight)| *weight > least), place);
            }
        }
        (!self.places.is_empty()).then_some(self)
    }

    /// Adds the cells of a grid, and returns the number of the first and the mean position of the rows of each.
    fn cells(&mut self, grid: &Grid<'_>, rows: usize) -> (usize, Vec<[f64; 3]>) {
        let first = self.counts.len();
        let mut known: HashMap<[i64; 3], usize> = HashMap::new();
        let mut sums: Vec<[f64; 3]> = Vec::new();
        let mut cell = |i: usize| {
            let at = (grid.at)(i)?;
            let next = first + sums.len();
            let number = *known
                .entry(at.map(|part| (part / grid.cell).round() as i64))
                .or_insert(next);
            if number == next {
                sums.push([0.0; 3]);
                self.counts.push(0);
                self.squares.push(0.0);
            }
            for (sum, part) in sums[number - first].iter_mut().zip(at) {
                *sum += part;
            }
            self.counts[number] += 1;
            self.squares[number] += self.errs.get(i).map_or(1.0, |errs| errs * errs);
            Some(number as u32)
        };
        self.grids.push((0..rows).map(|i| cell(i).unwrap_or(NOWHERE)).collect());
        let counts = &self.counts[first..];
        let mean = |(sum, count): ([f64; 3], &u32)| sum.map(|part| part / f64::from(*count));
        (first, sums.into_iter().zip(counts).map(mean).collect())
    }

    /// A place of these cells; nothing where fewer than two rows are in them.
    fn place(&mut self, cells: impl Iterator<Item = (usize, f64)>, place: Place) {
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
        self.places.push(Together { cells, place });
    }

    /// Sum of the values of each cell.
    fn sums(&self, values: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.counts.len()];
        for grid in &self.grids {
            for (i, (&cell, value)) in grid.iter().zip(values).enumerate() {
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
        if self.errs.is_empty() { 1.0 } else { RARE }
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let whole = self.amplitude(strongest.place, &self.sums(&series.plain));
        let place = self.places[strongest.place].place;
        let sign = if whole > 0.0 { "above" } else { "below" };
        place.finding(strongest, sign).explaining(whole * whole)
    }
}
