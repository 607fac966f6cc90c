//! The scan: every candidate against the residual.

mod nulls;

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::basis::Basis;
use crate::calibration::{BLIND, LN_WRONG_SIGN};
use crate::evidence::{ln_bayes_factor, ln_sum_exp};

/// Who makes a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Who {
    /// An effect of the catalogue, with one shape of its grid.
    Named {
        /// Number of the effect.
        effect: usize,
        /// Number of the shape.
        shape: usize,
    },
    /// A generic pattern.
    Unnamed {
        /// Number of the alternative.
        alternative: usize,
    },
}

/// A candidate pattern: its columns in the dictionary and what is assumed of it before any data.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Who makes it.
    pub who: Who,
    /// Its columns in the dictionary.
    pub columns: Range<usize>,
    /// ln of its prior probability, given that there is something.
    pub ln_prior: f64,
    /// Its one amplitude has a natural sign: +.
    pub one_sided: bool,
    /// Largest plausible size of its one amplitude (or of a direction's), in units of its columns.
    pub plausible: Option<f64>,
}

/// Whitened columns of the dictionary by their numbers, readings × columns: computed where they are asked for.
pub type Whitened<'a> = &'a (dyn Fn(&[usize]) -> DMatrix<f64> + Sync);

/// Values (readings × columns) that are looked at in one piece, and how many of these at a time: what a scan needs of
/// memory whatever the number of processors is.
const BLOCK_VALUES: usize = 1 << 20;
const AT_A_TIME: usize = 8;
/// Columns of a block at least and at most.
const BLOCK_COLUMNS: (usize, usize) = (16, 512);
/// The dictionary, whitened, with nuisance and all known effects projected out, one orthonormal block a candidate, and
/// the residual in it.
#[derive(Debug)]
pub struct Scan {
    candidates: Vec<Candidate>,
    /// Candidates that are looked at together.
    blocks: Vec<Range<usize>>,
    out: Basis,
    rows: usize,
    scale: f64,
    /// The candidates that the data can see, with their directions.
    pub seen: Vec<Seen>,
    /// The residual along every direction.
    z: Vec<f64>,
    /// Readings less everything that was projected out when the noise was estimated; none where it is as stated.
    freedom: Option<f64>,
}

/// A candidate that the data can see.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Its number in the list of candidates.
    pub candidate: usize,
    /// Who it is.
    pub who: Who,
    /// Its directions.
    columns: Range<usize>,
    ln_prior: f64,
    one_sided: bool,
    /// Significance of its plausible maximum; infinite where nothing is assumed of its size.
    reach: f64,
}

/// What the scan found for one candidate.
#[derive(Debug, Clone)]
pub struct Found {
    /// Who.
    pub who: Who,
    /// Number in the list of candidates.
    pub candidate: usize,
    /// Explained squared length, in units of the noise.
    pub explained: f64,
    /// ln(prior · Bayes factor).
    pub ln_evidence: f64,
}

impl Scan {
    /// Projects `out` out of the `whitened` dictionary, orthonormalises each candidate and looks at the whitened
    /// `residual` in units of its own noise.
    ///
    /// `scale` is the noise in units of the whitened rows; `freedom` the rows less what was fitted to find it, none
    /// where it was not fitted.
    pub fn new(
        whitened: Whitened<'_>,
        candidates: Vec<Candidate>,
        out: Basis,
        residual: &DVector<f64>,
        scale: f64,
        freedom: Option<f64>,
    ) -> Self {
        let rows = residual.len();
        let mut scan = Self {
            blocks: blocks(&candidates, rows),
            candidates,
            out,
            rows,
            scale,
            seen: Vec::new(),
            z: Vec::new(),
            freedom,
        };
        for some in scan.blocks.chunks(AT_A_TIME) {
            let looked: Vec<(Vec<Seen>, Vec<f64>)> = some
                .par_iter()
                .map(|block| {
                    let (directions, seen) = scan.directions(whitened, block.clone());
                    let z = directions.tr_mul(residual);
                    (seen, z.iter().copied().collect())
                })
                .collect();
            for (seen, z) in looked {
                let before = scan.z.len();
                scan.seen.extend(seen.into_iter().map(|seen| seen.moved(before)));
                scan.z.extend(z);
            }
        }
        scan
    }

    /// Orthonormal directions of some candidates, readings × directions, and which of them the data can see, their
    /// directions counted from zero.
    fn directions(&self, whitened: Whitened<'_>, candidates: Range<usize>) -> (DMatrix<f64>, Vec<Seen>) {
        let numbers: Vec<usize> = self.candidates[candidates.clone()]
            .iter()
            .flat_map(|candidate| candidate.columns.clone())
            .collect();
        let mut directions = whitened(&numbers);
        let before: Vec<f64> = directions.column_iter().map(|column| column.norm_squared()).collect();
        self.out.project_out(&mut directions);
        let mut seen = Vec::with_capacity(candidates.len());
        // Directions take the place of what they were made of, never ahead of it.
        let (mut rank, mut place) = (0, 0);
        for number in candidates {
            let candidate = &self.candidates[number];
            let start = rank;
            let mut squares = 0.0;
            for _ in candidate.columns.clone() {
                let mut column: DVector<f64> = directions.column(place).into_owned();
                squares += column.norm_squared();
                for done in start..rank {
                    let part = directions.column(done).dot(&column);
                    column.axpy(-part, &directions.column(done), 1.0);
                }
                let left = column.norm_squared();
                if before[place].is_normal() && left > BLIND * BLIND * before[place] {
                    directions.set_column(rank, &(column / left.sqrt()));
                    rank += 1;
                }
                place += 1;
            }
            if rank > start {
                seen.push(Seen {
                    candidate: number,
                    who: candidate.who,
                    columns: start..rank,
                    ln_prior: candidate.ln_prior,
                    one_sided: candidate.one_sided && rank - start == 1,
                    reach: candidate.plausible.map_or(f64::INFINITY, |plausible| {
                        plausible * (squares / candidate.columns.len() as f64).sqrt() / self.scale
                    }),
                });
            }
        }
        (directions.resize_horizontally(rank, 0.0), seen)
    }

    /// Every candidate against the residual.
    pub fn look(&self) -> Vec<Found> {
        let z = &self.z;
        self.seen
            .iter()
            .map(|seen| {
                let explained: f64 = seen.columns.clone().map(|k| z[k] * z[k]).sum();
                let factor = ln_bayes_factor(explained, seen.columns.len());
                let ln_evidence = seen.ln_prior + factor + seen.believable(explained, z[seen.columns.start]);
                Found {
                    who: seen.who,
                    candidate: seen.candidate,
                    explained,
                    ln_evidence,
                }
            })
            .collect()
    }

    /// Orthonormal directions of seen candidates (places in [`seen`](Self::seen)), one after the other, and the
    /// residual along them.
    pub fn of(&self, whitened: Whitened<'_>, places: &[usize]) -> Vec<(DMatrix<f64>, DVector<f64>)> {
        places
            .par_iter()
            .map(|&place| {
                let seen = &self.seen[place];
                let (directions, _) = self.directions(whitened, seen.candidate..seen.candidate + 1);
                (directions, DVector::from_column_slice(&self.z[seen.columns.clone()]))
            })
            .collect()
    }
}

/// Neighbouring candidates with so many columns that a block of them is neither much memory nor too narrow for fast
/// products.
fn blocks(candidates: &[Candidate], rows: usize) -> Vec<Range<usize>> {
    let (least, most) = BLOCK_COLUMNS;
    let wanted = (BLOCK_VALUES / rows.max(1)).clamp(least, most);
    let mut blocks: Vec<Range<usize>> = Vec::new();
    let mut columns = 0;
    for (number, candidate) in candidates.iter().enumerate() {
        match blocks.last_mut() {
            Some(block) if columns < wanted => block.end = number + 1,
            _ => {
                blocks.push(number..number + 1);
                columns = 0;
            }
        }
        columns += candidate.columns.len();
    }
    // A rest of a few columns goes with those before it.
    if columns < least
        && let [.., before, last] = blocks.as_mut_slice()
    {
        before.end = last.end;
        blocks.pop();
    }
    blocks
}

impl Seen {
    /// The same with its directions so many places later.
    fn moved(self, by: usize) -> Self {
        Self {
            columns: self.columns.start + by..self.columns.end + by,
            ..self
        }
    }

    /// ln of what a sign and a size cost: beyond the plausible maximum belief falls like a normal law of that width.
    fn believable(&self, explained: f64, z: f64) -> f64 {
        let sign = if self.one_sided { sign_evidence(z) } else { 0.0 };
        let beyond = explained.max(0.0).sqrt() - self.reach;
        if beyond > 0.0 {
            sign - 0.5 * beyond * beyond / (1.0 + self.reach * self.reach)
        } else {
            sign
        }
    }
}

/// What an amplitude's sign says for an effect that has a natural one.
pub fn sign_evidence(amplitude: f64) -> f64 {
    if amplitude >= 0.0 {
        std::f64::consts::LN_2
    } else {
        LN_WRONG_SIGN
    }
}

/// The statistic of a whole scan: ln Σ prior·Bayes factor.
pub fn statistic(found: &[Found]) -> f64 {
    ln_sum_exp(&found.iter().map(|one| one.ln_evidence).collect::<Vec<_>>())
}

/// The pattern without a name that is the most probable.
pub fn strongest_unnamed(found: &[Found]) -> Option<&Found> {
    found
        .iter()
        .filter(|one| matches!(one.who, Who::Unnamed { .. }))
        .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))
}

/// p = (k + 1)/(n + 1) of an observed statistic among simulated ones (rising).
pub fn p_value(observed: f64, nulls: &[f64]) -> f64 {
    let above = nulls.len() - nulls.partition_point(|null| *null < observed);
    (above + 1) as f64 / (nulls.len() + 1) as f64
}
