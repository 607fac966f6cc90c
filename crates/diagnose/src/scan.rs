//! The scan: every candidate against the residual, and the same scan on thousands of simulated noise-only repeats.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution as _, StandardNormal};
use rayon::prelude::*;

use crate::basis::Basis;
use crate::evidence::{EvidenceTable, ln_bayes_factor, ln_sum_exp};
use crate::whitening::Sequence;

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
        /// Number of the rival.
        rival: usize,
    },
}

/// A candidate pattern: its columns in the dictionary and what is believed of it before any data.
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

/// ln of the factor that a wrong sign costs: light that is taken away is no ghost, whatever its shape.
const LN_WRONG_SIGN: f64 = -60.0;
/// Less than this share of a pattern left by the nuisance: the data cannot see it.
pub const BLIND: f64 = 2e-3;

/// The dictionary, whitened, with nuisance and all known effects projected out, one orthonormal block a candidate.
#[derive(Debug)]
pub struct Scan {
    /// Orthonormal directions, readings × directions.
    directions: DMatrix<f64>,
    /// The candidates that the data can see, with their columns of `directions`.
    pub seen: Vec<Seen>,
    /// Readings less everything that was projected out when the noise was estimated.
    freedom: f64,
}

/// A candidate that the data can see.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Its number in the list of candidates.
    pub candidate: usize,
    /// Who it is.
    pub who: Who,
    columns: Range<usize>,
    ln_prior: f64,
    one_sided: bool,
    /// Significance of its plausible maximum; infinite where nothing is believed of its size.
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
    /// Projects `out` out of the whitened `dictionary` and orthonormalises each candidate.
    ///
    /// `scale` is the noise in units of the whitened rows; `freedom` the rows less what was fitted to find it.
    pub fn new(dictionary: &DMatrix<f64>, candidates: &[Candidate], out: &Basis, scale: f64, freedom: f64) -> Self {
        let before: Vec<f64> = dictionary.column_iter().map(|column| column.norm_squared()).collect();
        // Directions take the place of what they were made of, never ahead of it.
        let mut directions = dictionary.clone();
        out.project_out(&mut directions);
        let mut seen = Vec::with_capacity(candidates.len());
        let mut rank = 0;
        for (number, candidate) in candidates.iter().enumerate() {
            let start = rank;
            let mut squares = 0.0;
            for k in candidate.columns.clone() {
                let mut column: DVector<f64> = directions.column(k).into_owned();
                squares += column.norm_squared();
                for done in start..rank {
                    let part = directions.column(done).dot(&column);
                    column.axpy(-part, &directions.column(done), 1.0);
                }
                let left = column.norm_squared();
                if before[k].is_normal() && left > BLIND * BLIND * before[k] {
                    directions.set_column(rank, &(column / left.sqrt()));
                    rank += 1;
                }
            }
            if rank > start {
                seen.push(Seen {
                    candidate: number,
                    who: candidate.who,
                    columns: start..rank,
                    ln_prior: candidate.ln_prior,
                    one_sided: candidate.one_sided && rank - start == 1,
                    reach: candidate.plausible.map_or(f64::INFINITY, |plausible| {
                        plausible * (squares / candidate.columns.len() as f64).sqrt() / scale
                    }),
                });
            }
        }
        directions = directions.resize_horizontally(rank, 0.0);
        Self {
            directions,
            seen,
            freedom,
        }
    }

    /// Every candidate against a whitened residual in units of its own noise.
    pub fn look(&self, residual: &DVector<f64>) -> Vec<Found> {
        let z = self.directions.tr_mul(residual);
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

    /// The statistic of the whole scan, ln Σ prior·Bayes factor, for `count` simulated noise-only repeats, rising.
    ///
    /// White unit noise is drawn, because the whitened residual is that; every repeat is divided by a noise scale as
    /// uncertain as the fitted one, and its serial correlation is as far from the fitted `rho` as that is uncertain: smooth
    /// patterns live where a correlation that was underestimated leaves noise. Repeat `k` depends on `seed` and `k` alone.
    pub fn nulls(&self, count: usize, seed: u64, sequence: &Sequence, rho: f64) -> Vec<f64> {
        const BATCH: usize = 50;
        let directions = DMatrix::from_fn(self.directions.ncols(), self.directions.nrows(), |direction, row| {
            self.directions[(row, direction)] as f32
        });
        let width = self.seen.iter().map(|seen| seen.columns.len()).max().unwrap_or(1);
        let table = EvidenceTable::new(width);
        let scale = ChiSquared::new(self.freedom.max(1.0)).ok();
        let rows = directions.ncols();
        // A correlation of white noise's own size is none.
        let u_rho = if sequence.has_neighbours() && rho > 0.1 {
            (2.0 * (1.0 - rho * rho) / self.freedom.max(1.0)).sqrt()
        } else {
            0.0
        };
        let mut statistics: Vec<f64> = (0..count.div_ceil(BATCH))
            .into_par_iter()
            .flat_map_iter(|batch| {
                let size = BATCH.min(count - batch * BATCH);
                let mut noise = DMatrix::<f32>::zeros(rows, size);
                let mut scales = vec![1.0_f64; size];
                for (k, scale_of) in scales.iter_mut().enumerate() {
                    let mut rng = ChaCha8Rng::seed_from_u64(seed);
                    rng.set_stream((batch * BATCH + k) as u64 + 1);
                    let mut values: Vec<f64> = (0..rows).map(|_| rng.sample(StandardNormal)).collect();
                    if u_rho > 0.0 {
                        let off: f64 = rng.sample(StandardNormal);
                        sequence.colour((rho + u_rho * off).clamp(0.0, 0.95), &mut values);
                        sequence.whiten_values(rho, &mut values);
                    }
                    for (target, value) in noise.column_mut(k).iter_mut().zip(values) {
                        *target = value as f32;
                    }
                    if let Some(law) = &scale {
                        *scale_of = law.sample(&mut rng) / self.freedom;
                    }
                }
                let z = &directions * &noise;
                let table = &table;
                let seen = &self.seen;
                (0..size)
                    .map(move |k| {
                        let column = z.column(k);
                        let mut terms = Vec::with_capacity(seen.len());
                        for candidate in seen {
                            let explained: f64 = candidate
                                .columns
                                .clone()
                                .map(|i| f64::from(column[i]).powi(2))
                                .sum::<f64>()
                                / scales[k];
                            let factor = table.at(explained, candidate.columns.len());
                            let sign = f64::from(column[candidate.columns.start]);
                            terms.push(candidate.ln_prior + factor + candidate.believable(explained, sign));
                        }
                        ln_sum_exp(&terms)
                    })
                    .collect::<Vec<_>>()
            })
            .collect();
        statistics.sort_by(f64::total_cmp);
        statistics
    }

    /// Orthonormal directions of a seen candidate.
    pub fn block(&self, seen: &Seen) -> nalgebra::DMatrixView<'_, f64> {
        self.directions.columns(seen.columns.start, seen.columns.len())
    }
}

impl Seen {
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

/// p = (k + 1)/(n + 1) of an observed statistic among simulated ones (rising).
pub fn p_value(observed: f64, nulls: &[f64]) -> f64 {
    let above = nulls.len() - nulls.partition_point(|null| *null < observed);
    (above + 1) as f64 / (nulls.len() + 1) as f64
}
