//! Rays from the emitter, drawn from the very interpolant that the inverse solver evaluates.
//!
//! The density of directions is I(C, γ)·sin γ dγ dC. The grid is refined (which leaves the interpolant as it is)
//! until its cells are small where the sensor can be reached; a cell is drawn by its flux, γ within it by inverting
//! the exact integral of (linear × sine), C by inverting the linear density at that γ. Cells that no ray can leave
//! towards the sensor stand at the end of the list: a ray's first number says whether it matters, and the flux of the
//! others is the cone of the thinned mode.

mod cell;
mod grid;

use glam::{DMat3, DVec3};

pub(crate) use self::cell::{Cell, MOST_STEPS};
use self::grid::{Grid, cell_reaches, targets};
use crate::random::{unit32, unit53};
use crate::sensor::Sensor;
use crate::source::{LightSource, Shape};
use crate::sum::Sum;

/// A ray: origin in mm and unit direction, luminaire frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it leaves.
    pub origin: DVec3,
    /// Where it goes, unit length.
    pub direction: DVec3,
}

/// The emitter's rays, sorted by whether they can reach a given sensor.
#[derive(Debug, Clone)]
pub struct Emission {
    parts: Vec<(Shape, Option<DMat3>)>,
    cells: Vec<Cell>,
    /// Flux up to the end of each reaching cell over the whole flux.
    cumulative: Vec<f64>,
    guide: Vec<u32>,
    flux_lm: f64,
    refused_lm: f64,
}

impl Emission {
    /// The rays of `source`, refined round the directions of `sensor`.
    pub fn new(source: &LightSource, sensor: &Sensor) -> Self {
        let mut cells = Vec::new();
        let mut fluxes = Vec::new();
        let (mut total, mut refused) = (Sum::default(), Sum::default());
        for (index, part) in source.parts().iter().enumerate() {
            let targets = targets(part, sensor);
            let grid = Grid::of(&part.table, &targets);
            for ic in 0..grid.c.len() - 1 {
                for ig in 0..grid.gamma.len() - 1 {
                    let (cell, flux) = grid.cell(&part.table, index as u32, ic, ig);
                    let flux = flux * part.share;
                    let negative = grid.negative(&part.table, ic, ig) * part.share;
                    refused.add(negative);
                    if flux > 0.0 {
                        total.add(flux);
                        if cell_reaches(&cell, grid.c[ic], &targets) {
                            cells.push(cell);
                            fluxes.push(flux);
                        }
                    }
                }
            }
        }
        let flux_lm = total.value();
        let mut run = Sum::default();
        let cumulative: Vec<f64> = fluxes
            .iter()
            .map(|flux| {
                run.add(*flux);
                run.value() / flux_lm
            })
            .collect();
        let guide = guide(&cumulative);
        let parts = source.parts().iter().map(|part| (part.shape, part.aim)).collect();
        Self {
            parts,
            cells,
            cumulative,
            guide,
            flux_lm,
            refused_lm: refused.value(),
        }
    }

    /// Flux of the emitter in lm: the exact integral of the interpolant where it is positive.
    pub fn flux_lm(&self) -> f64 {
        self.flux_lm
    }

    /// Negative flux that no ray can carry (readings below zero in the distribution), lm.
    pub fn refused_lm(&self) -> f64 {
        self.refused_lm
    }

    /// Share of the flux that leaves through cells from which the sensor can be reached.
    pub fn cone(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// The ray for a first number `u` below [`Emission::cone`] and four words; `None` for a ray of the other cells.
    #[inline]
    pub fn ray(&self, u: f64, words: [u32; 4]) -> Option<Ray> {
        let cell = self.cell_of(u)?;
        let (shape, aim) = self.parts[cell.part as usize];
        let direction = cell.direction(unit32(words[0]), unit32(words[1]));
        let origin = shape.point(unit32(words[2]), unit32(words[3]));
        Some(Ray {
            origin,
            direction: aim.map_or(direction, |aim| aim * direction),
        })
    }

    /// Shape and aim of the part that a cell belongs to.
    #[inline]
    pub(crate) fn part(&self, cell: &Cell) -> &(Shape, Option<DMat3>) {
        &self.parts[cell.part as usize]
    }

    /// Cells from which the sensor can be reached, each with its share of what the cells from it on emit.
    pub(crate) fn shares(&self) -> impl Iterator<Item = (&Cell, f64)> {
        let last = self.cone();
        let mut before = 0.0;
        self.cells.iter().zip(&self.cumulative).map(move |(cell, &end)| {
            let share = if end >= last {
                1.0
            } else {
                (end - before) / (last - before)
            };
            before = end;
            (cell, share)
        })
    }

    #[inline]
    pub(crate) fn cell_of(&self, u: f64) -> Option<&Cell> {
        let last = *self.cumulative.last()?;
        if u >= last {
            return None;
        }
        let bucket = (u / last * (self.guide.len() - 1) as f64) as usize;
        let mut index = self.guide[bucket.min(self.guide.len() - 1)] as usize;
        while self.cumulative[index] <= u {
            index += 1;
        }
        Some(&self.cells[index])
    }
}

/// First cell of each of equal shares of the cone.
fn guide(cumulative: &[f64]) -> Vec<u32> {
    let Some(&last) = cumulative.last() else { return vec![0] };
    let buckets = (4 * cumulative.len()).next_power_of_two();
    let mut index = 0;
    (0..=buckets)
        .map(|bucket| {
            let start = last * (bucket as f64 / buckets as f64) * (1.0 - 1e-12);
            while index + 1 < cumulative.len() && cumulative[index] <= start {
                index += 1;
            }
            index as u32
        })
        .collect()
}

/// The first number of ray: 53 bits of two words.
#[inline]
pub(crate) fn first_number(words: [u32; 4]) -> f64 {
    unit53(words[0], words[1])
}
