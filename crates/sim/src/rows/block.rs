//! Polynomials that neighbouring rows share: where the same kinks follow each other along all of them, the coefficients of
//! each run between two kinks are polynomials of the row.

use super::{Rows, Work};
use crate::angles::LANES;
use crate::number::TERMS;

/// Rows below which each makes its own.
pub(super) const FEW: usize = 12;

/// Rows between which the same kinks follow each other.
pub(super) struct Block {
    /// Row in the middle, and one over half the rows.
    pub middle: f64,
    pub per: f64,
    pub kinks: Vec<u32>,
    /// For each run between two cuts; `None` where the polynomials do not converge.
    pub pieces: Vec<Option<Piece>>,
}

/// A run of pixels through all rows of a block: `[power of the row][power of the place between its cuts]`.
pub(super) struct Piece {
    pub powers: [[f64; TERMS]; TERMS],
    pub tail: f64,
    pub least: f64,
}

impl Rows<'_> {
    /// The polynomials of a block of rows; `None` where kinks change their order within it.
    pub(super) fn block(&self, first: usize, rows: usize, work: &mut Work) -> Option<Block> {
        if rows < FEW {
            return None;
        }
        let half = 0.5 * (rows - 1) as f64;
        let middle = first as f64 + 0.5 + half;
        let mut kinks: Vec<u32> = Vec::new();
        let mut places: [Vec<f64>; TERMS] = std::array::from_fn(|_| vec![0.0]);
        for (row, t) in places.iter_mut().zip(self.nodes) {
            self.cut(middle + half * t, &mut work.cuts);
            if kinks.is_empty() {
                kinks.extend(work.cuts.iter().map(|cut| cut.1));
            } else if !kinks.iter().eq(work.cuts.iter().map(|cut| &cut.1)) {
                return None;
            }
            row.extend(work.cuts.iter().map(|cut| cut.0));
        }
        let pieces = (0..kinks.len()).map(|k| self.piece(middle, half, k, &places)).collect();
        Some(Block {
            middle,
            per: half.recip(),
            kinks,
            pieces,
        })
    }

    fn piece(&self, middle: f64, half: f64, k: usize, places: &[Vec<f64>; TERMS]) -> Option<Piece> {
        let mut along = [[0.0; TERMS]; TERMS];
        let (mut tail, mut least) = (0.0_f64, f64::INFINITY);
        for ((coefficients, row), t) in along.iter_mut().zip(places).zip(self.nodes) {
            let (from, to) = (row[k], row[k + 1]);
            let mut u = self.nodes;
            for u in &mut u {
                *u = from + 0.5 * (to - from) * (1.0 + *u);
            }
            let values = self.values(middle + half * t, &u, LANES / 2);
            let (found, rest) = self.fit.polynomial(&values);
            *coefficients = found;
            tail = tail.max(rest);
            for value in values {
                least = if value.abs() < least { value.abs() } else { least };
            }
        }
        let mut powers = [[0.0; TERMS]; TERMS];
        for power in 0..TERMS {
            let mut column = [0.0; TERMS];
            for (value, row) in column.iter_mut().zip(&along) {
                *value = row[power];
            }
            let (found, rest) = self.fit.polynomial(&column);
            tail += rest;
            for (row, value) in powers.iter_mut().zip(found) {
                row[power] = value;
            }
        }
        (tail <= self.tail * least).then_some(Piece { powers, tail, least })
    }
}

/// The polynomial of one row of a block, `t` from −1 to 1.
#[multiversion::multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512bw+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn at_row(powers: &[[f64; TERMS]; TERMS], t: f64) -> [f64; TERMS] {
    let mut row = powers[TERMS - 1];
    for power in powers.iter().rev().skip(1) {
        for k in 0..TERMS {
            row[k] = row[k] * t + power[k];
        }
    }
    row
}
