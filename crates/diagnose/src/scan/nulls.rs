//! The same scan on thousands of simulated noise-only repeats.

use std::ops::Range;

use nalgebra::DMatrix;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution as _, StandardNormal};
use rayon::prelude::*;

use super::{AT_A_TIME, Scan, Seen, Whitened};
use crate::calibration::MOST_CORRELATED;
use crate::evidence::{EvidenceTable, ln_sum_exp};
use crate::whitening::{self, Sequence};

/// Values of directions that simulated noise is compared with at a time: noise is drawn again for the next ones, so
/// these are not few.
const NULL_VALUES: usize = 1 << 25;
const LEAST_DIRECTIONS: usize = 640;
/// Values of simulated noise at a time.
const BATCH_VALUES: usize = 1 << 17;

impl Scan {
    /// The statistic of the whole scan, ln Σ prior·Bayes factor, for `count` simulated noise-only repeats, rising.
    ///
    /// Repeat `k` depends on `seed` and `k` alone.
    pub fn nulls(
        &self,
        whitened: Whitened<'_>,
        count: usize,
        seed: u64,
        sequence: &Sequence,
        noise: &whitening::Noise,
    ) -> Vec<f64> {
        let noise = Noise::new(seed, sequence, noise, self.rows, self.freedom);
        self.in_groups(
            whitened,
            count,
            &noise,
            (NULL_VALUES / self.rows.max(1)).max(LEAST_DIRECTIONS),
        )
    }

    /// As [`nulls`](Self::nulls), with up to `most` directions at a time.
    fn in_groups(&self, whitened: Whitened<'_>, count: usize, noise: &Noise<'_>, most: usize) -> Vec<f64> {
        let width = self.seen.iter().map(|seen| seen.columns.len()).max().unwrap_or(1);
        let table = EvidenceTable::new(width);
        let mut parts: Vec<Vec<f64>> = vec![Vec::new(); count];
        let mut blocks = self.blocks.as_slice();
        while !blocks.is_empty() {
            let (directions, seen, rest) = self.transposed(whitened, blocks, most);
            blocks = rest;
            let statistics: Vec<f64> = noise.compared(&directions, count, |z, scale| {
                let terms: Vec<f64> = seen
                    .iter()
                    .map(|candidate| {
                        let columns = candidate.columns.clone();
                        let explained = columns.map(|i| f64::from(z[i]).powi(2)).sum::<f64>() / scale;
                        let factor = table.at(explained, candidate.columns.len());
                        let sign = f64::from(z[candidate.columns.start]);
                        candidate.ln_prior + factor + candidate.believable(explained, sign)
                    })
                    .collect();
                ln_sum_exp(&terms)
            });
            for (parts, statistic) in parts.iter_mut().zip(statistics) {
                parts.push(statistic);
            }
        }
        let mut statistics: Vec<f64> = parts.iter().map(|parts| ln_sum_exp(parts)).collect();
        statistics.sort_by(f64::total_cmp);
        statistics
    }

    /// The directions of as many blocks as have up to `most` columns (of one at least), transposed, who has which of
    /// them, and the other blocks.
    fn transposed<'a>(
        &self,
        whitened: Whitened<'_>,
        blocks: &'a [Range<usize>],
        most: usize,
    ) -> (DMatrix<f32>, Vec<Seen>, &'a [Range<usize>]) {
        let width = |block: &Range<usize>| -> usize {
            self.candidates[block.clone()]
                .iter()
                .map(|candidate| candidate.columns.len())
                .sum()
        };
        let (mut taken, mut columns) = (0, 0);
        while taken < blocks.len() && (taken == 0 || columns + width(&blocks[taken]) <= most) {
            columns += width(&blocks[taken]);
            taken += 1;
        }
        let (these, rest) = blocks.split_at(taken);
        let numbers = these[0].start..these[taken - 1].end;
        let first = self.seen.partition_point(|seen| seen.candidate < numbers.start);
        let last = self.seen.partition_point(|seen| seen.candidate < numbers.end);
        let seen = &self.seen[first..last];
        let (Some(start), Some(end)) = (
            seen.first().map(|seen| seen.columns.start),
            seen.last().map(|seen| seen.columns.end),
        ) else {
            return (DMatrix::zeros(0, self.rows), Vec::new(), rest);
        };
        let mut directions = DMatrix::<f32>::zeros(end - start, self.rows);
        let mut place = 0;
        // Half as many as elsewhere: the directions so far are in memory beside them.
        for some in these.chunks(AT_A_TIME / 2) {
            let computed: Vec<DMatrix<f64>> = some
                .par_iter()
                .map(|block| self.directions(whitened, block.clone()).0)
                .collect();
            for block in computed {
                for row in 0..self.rows {
                    for k in 0..block.ncols() {
                        directions[(place + k, row)] = block[(row, k)] as f32;
                    }
                }
                place += block.ncols();
            }
        }
        let seen = seen
            .iter()
            .map(|seen| Seen {
                columns: seen.columns.start - start..seen.columns.end - start,
                ..seen.clone()
            })
            .collect();
        (directions, seen, rest)
    }
}

/// Simulated noise of whitened rows, one vector and one fitted scale a repeat.
///
/// White unit noise is drawn, because the whitened residual is that; its serial correlation is as far from the fitted
/// `rho` as that is uncertain, for smooth patterns live where a correlation that was underestimated leaves noise; the
/// scale, where it was fitted, is as uncertain as that, and what would have been fitted to noise of that correlation.
struct Noise<'a> {
    seed: u64,
    sequence: &'a Sequence,
    rho: f64,
    u_rho: f64,
    variance_at: [f64; 2],
    rows: usize,
    /// The law of a fitted variance, and its degrees of freedom; none where the scale was not fitted.
    scale: Option<(ChiSquared<f64>, f64)>,
}

impl<'a> Noise<'a> {
    fn new(seed: u64, sequence: &'a Sequence, noise: &whitening::Noise, rows: usize, freedom: Option<f64>) -> Self {
        let (rho, u_rho) = (noise.rho, noise.u_rho);
        Self {
            seed,
            sequence,
            rho,
            u_rho,
            variance_at: noise.variance_at,
            rows,
            scale: freedom.and_then(|freedom| Some((ChiSquared::new(freedom.max(1.0)).ok()?, freedom))),
        }
    }

    /// Repeats `0..count`, each along `directions` (directions × rows): what `judge` makes of that and of the repeat's
    /// variance. Repeat `k` depends on the seed and `k` alone.
    fn compared(&self, directions: &DMatrix<f32>, count: usize, judge: impl Fn(&[f32], f64) -> f64 + Sync) -> Vec<f64> {
        // Few repeats of many readings, so that they need little memory; many of few, for the directions are packed
        // anew for each batch.
        let batch = (BATCH_VALUES / self.rows.max(1)).clamp(50, 250);
        let whiten = self.sequence.whitening(self.rho);
        let batches: Vec<usize> = (0..count).step_by(batch).collect();
        let mut all = Vec::with_capacity(count);
        for some in batches.chunks(AT_A_TIME) {
            let judged: Vec<Vec<f64>> = some
                .par_iter()
                .map(|&first| {
                    let size = batch.min(count - first);
                    let mut noise = DMatrix::<f32>::zeros(self.rows, size);
                    let scales: Vec<f64> = (0..size)
                        .map(|k| self.draw(first + k, &whiten, noise.column_mut(k).as_mut_slice()))
                        .collect();
                    let z = directions * &noise;
                    z.column_iter()
                        .zip(scales)
                        .map(|(z, scale)| judge(z.as_slice(), scale))
                        .collect()
                })
                .collect();
            all.extend(judged.into_iter().flatten());
        }
        all
    }

    /// Draws repeat `k` and returns its variance.
    fn draw(&self, k: usize, whiten: &(impl Fn(&mut [f64]) + Sync), target: &mut [f32]) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(k as u64 + 1);
        let mut values: Vec<f64> = (0..self.rows).map(|_| rng.sample(StandardNormal)).collect();
        let mut variance = 1.0;
        if self.u_rho > 0.0 {
            let off: f64 = rng.sample(StandardNormal);
            let rho = (self.rho + self.u_rho * off).clamp(0.0, MOST_CORRELATED);
            // What would be found of the scale: a parabola through the three known places.
            let (off, [low, high]) = ((rho - self.rho) / self.u_rho, self.variance_at);
            variance = (1.0 + 0.5 * off * (high - low) + off * off * (0.5 * (high + low) - 1.0)).max(0.1);
            self.sequence.colour(rho, &mut values);
            whiten(&mut values);
        }
        for (target, value) in target.iter_mut().zip(values) {
            *target = value as f32;
        }
        match &self.scale {
            Some((law, freedom)) => variance * law.sample(&mut rng) / freedom,
            None => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Basis;
    use crate::scan::{Candidate, Who};
    use nalgebra::DVector;

    /// What is computed at a time is a matter of memory, never of results.
    #[test]
    fn groups_and_blocks_change_nothing() {
        let (rows, count) = (30_000, 160);
        let value = |i: usize, k: usize| (((i * (k + 3)) % 1009) as f64 / 1009.0 * (k + 1) as f64).sin();
        let whitened = |numbers: &[usize]| DMatrix::from_fn(rows, numbers.len(), |i, k| value(i, numbers[k]));
        // Candidates of one and of two columns.
        let candidates: Vec<Candidate> = (0..count / 3 * 2)
            .map(|number| {
                let start = number / 2 * 3 + number % 2;
                Candidate {
                    who: Who::Unnamed { alternative: number },
                    columns: start..start + 1 + number % 2,
                    ln_prior: -0.1 * number as f64,
                    one_sided: number % 5 == 0,
                    plausible: (number % 7 == 0).then_some(0.01),
                }
            })
            .collect();
        let out = Basis::spanning(
            &DMatrix::from_fn(rows, 2, |i, k| (i as f64 / rows as f64).powi(k as i32)),
            1e-9,
        );
        let residual = DVector::from_fn(rows, |i, _| ((i * 7919) % 1013) as f64 / 506.0 - 1.0);
        let scan = Scan::new(
            &whitened,
            candidates.clone(),
            out.clone(),
            &residual,
            1.0,
            Some(rows as f64),
        );
        assert!(scan.blocks.len() > 3, "{} blocks", scan.blocks.len());
        for (one, found) in scan.look().iter().enumerate() {
            let alone = Scan::new(
                &whitened,
                vec![candidates[found.candidate].clone()],
                out.clone(),
                &residual,
                1.0,
                Some(rows as f64),
            );
            let explained = alone.look()[0].explained;
            assert!(
                (found.explained - explained).abs() < 1e-9 * (1.0 + explained),
                "candidate {one}"
            );
        }
        let sequence = Sequence::by_time(&vec![0; rows], &(0..rows).map(|i| i as f64).collect::<Vec<_>>());
        let correlated = whitening::Noise {
            scale: 1.0,
            observed: 1.0,
            rho: 0.4,
            u_rho: 0.01,
            variance_at: [1.01, 0.99],
            weights: Vec::new(),
        };
        let noise = Noise::new(3, &sequence, &correlated, rows, Some(rows as f64));
        let together = scan.in_groups(&whitened, 20, &noise, 1000);
        let apart = scan.in_groups(&whitened, 20, &noise, 40);
        for (a, b) in together.iter().zip(&apart) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
