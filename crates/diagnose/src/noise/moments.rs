//! Periods that come, go or change: a periodogram of each stretch of the record, its peak wherever it lies.

use std::sync::Arc;

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::{SQUARE_CLIP, STRETCHES};
use super::series::{ADDED, RELATIVE, Series};
use super::statistic::Test;
use crate::table::Coordinate;

/// Steps of the table of sines: phases are looked up, or long records would take gigabytes.
const TURN: usize = 4096;
/// Cells of time in a typical step.
const PARTS: f64 = 2.0;

/// Stretches at most: of longer records they are a sample.
const MOST: usize = 300;

/// The peaks of all stretches of one length together, for each length.
pub(super) struct Moments {
    lengths: Vec<Stretches>,
    cells: Vec<usize>,
    cell_s: f64,
    errors: Arc<[Vec<f64>]>,
    sine: Vec<f64>,
}

/// Stretches of one length.
struct Stretches {
    length: usize,
    /// The first row of each.
    starts: Vec<usize>,
    /// In turns of the table a cell.
    frequencies: Vec<usize>,
}

impl Stretches {
    fn new(length: usize, rows: usize) -> Option<Self> {
        // From one period in a stretch without pauses to two and a half readings a period.
        let span = length as f64 * PARTS;
        let count = (length as f64 / 2.5) as usize;
        (rows >= 3 * length).then(|| Self {
            length,
            starts: (0..=rows - length).step_by((length / 2).max(rows / MOST)).collect(),
            frequencies: (1..=count)
                .map(|k| (TURN as f64 * k as f64 / span).round() as usize)
                .collect(),
        })
    }
}

impl Stretches {
    /// Half of the σ² that the peak of noise explains: the mean of the largest of k exponential laws (Gumbel 1935).
    fn expected(&self) -> f64 {
        (self.frequencies.len() as f64).ln() + 0.577
    }
}

impl Moments {
    /// None where the rows have no time or are too few.
    pub(super) fn new(series: &Series<'_>) -> Option<Self> {
        let first = *series.time.first()?;
        let mut steps: Vec<f64> = series.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.iter().any(|step| !step.is_finite()) {
            return None;
        }
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let cell_s = *steps.get(steps.len() / 2)? / PARTS;
        let lengths: Vec<Stretches> = STRETCHES
            .into_iter()
            .filter_map(|length| Stretches::new(length, series.len()))
            .collect();
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / TURN as f64;
        (!lengths.is_empty()).then(|| Self {
            lengths,
            cells: series
                .time
                .iter()
                .map(|time| ((time - first) / cell_s).round() as usize)
                .collect(),
            cell_s,
            errors: Arc::clone(&series.errors),
            sine: (0..TURN).map(|k| angle(k).sin()).collect(),
        })
    }

    /// The peaks of all stretches of one length: half of what each explains in σ², and its period in seconds.
    fn peaks(&self, of: &Stretches, values: &[f64]) -> Vec<(f64, f64)> {
        of.starts.iter().map(|&from| self.peak(of, values, from)).collect()
    }

    /// The peak of the stretch from row `from` on. Values are held as squares are: one outlier alone is a little of
    /// every period.
    fn peak(&self, of: &Stretches, values: &[f64], from: usize) -> (f64, f64) {
        let mut best = (0.0, f64::INFINITY);
        let rows = from..from + of.length;
        for envelope in [&self.errors[RELATIVE], &self.errors[ADDED]] {
            let square: f64 = envelope[rows.clone()].iter().map(|weight| weight * weight).sum();
            if square.is_nan() || square <= 0.0 {
                continue;
            }
            let product = |i: usize| values[i].clamp(-SQUARE_CLIP, SQUARE_CLIP) * envelope[i];
            let products: Vec<f64> = rows.clone().map(product).collect();
            for &frequency in &of.frequencies {
                let (mut sine, mut cosine) = (0.0, 0.0);
                for (product, cell) in products.iter().zip(&self.cells[rows.clone()]) {
                    let turn = cell * frequency % TURN;
                    sine += product * self.sine[turn];
                    cosine += product * self.sine[(turn + TURN / 4) % TURN];
                }
                let power = (sine * sine + cosine * cosine) / square;
                if power > best.0 {
                    best = (power, self.cell_s * TURN as f64 / frequency as f64);
                }
            }
        }
        best
    }
}

impl Test for Moments {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (place, of) in self.lengths.iter().enumerate() {
            let count = of.starts.len() as f64;
            let sum: f64 = self.peaks(of, values).iter().map(|peak| peak.0).sum();
            // The largest of exponential laws has the variance π²/6 (Gumbel 1935).
            let z = (sum - count * of.expected()) / (count * std::f64::consts::PI.powi(2) / 6.0).sqrt();
            best.raise(0.5 * z.max(0.0).powi(2), place);
        }
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let of = &self.lengths[strongest.place];
        let mut peaks = self.peaks(of, &series.plain);
        // Twice half of σ², of stretches that share half of their readings; noise has peaks, too.
        let more = |peak: &(f64, f64)| peak.0 - of.expected() * series.expected;
        let explained = peaks.iter().map(more).sum::<f64>().max(0.0);
        peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
        peaks.truncate(peaks.len().div_ceil(3));
        let range = peaks
            .iter()
            .map(|peak| peak.1)
            .fold([f64::INFINITY, 0.0], |[low, high], period| {
                [f64::min(low, period), f64::max(high, period)]
            });
        let note = format!(
            "an error oscillates with a period that changes or is not always there, {} … {} s",
            digits(range[0]),
            digits(range[1])
        );
        let span = [series.time[0], series.time[series.len() - 1]];
        Finding::new(Kind::Stretches, Coordinate::TimeS, span, strongest, note).explaining(explained)
    }
}
