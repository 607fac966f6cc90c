//! Periods that come, go or change: a periodogram of each stretch of the record, its peak wherever it lies.

use super::series::Series;
use super::{Finding, Kind, Strongest, Test, digits};
use crate::table::Coordinate;

/// Steps of the table of sines: phases are looked up, or long records would take gigabytes.
const TURN: usize = 4096;
/// Cells of time in a typical step.
const PARTS: f64 = 2.0;

/// Stretches at most: of longer records they are a sample.
const MOST: usize = 300;

/// The peaks of all stretches of one length together.
pub(super) struct Moments {
    length: usize,
    /// First row and first cell of each stretch.
    starts: Vec<usize>,
    cells: Vec<usize>,
    cell_s: f64,
    /// Of an error that multiplies the light, and of one that is added.
    envelopes: [Vec<f64>; 2],
    /// In turns of the table a cell.
    frequencies: Vec<usize>,
    sine: Vec<f64>,
}

impl Moments {
    /// None where the rows have no time or are too few for three stretches of `length` readings.
    pub(super) fn new(series: &Series<'_>, length: usize) -> Option<Self> {
        let n = series.len();
        let first = *series.time.first()?;
        let mut steps: Vec<f64> = series.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if n < 3 * length || steps.iter().any(|step| !step.is_finite()) {
            return None;
        }
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let cell_s = *steps.get(steps.len() / 2)? / PARTS;
        let cell = |time: &f64| ((time - first) / cell_s).round() as usize;
        // From one period in a stretch without pauses to two and a half readings a period.
        let span = length as f64 * PARTS;
        let count = (length as f64 / 2.5) as usize;
        let frequencies = (1..=count)
            .map(|k| (TURN as f64 * k as f64 / span).round() as usize)
            .collect();
        Some(Self {
            length,
            starts: (0..=n - length).step_by((length / 2).max(n / MOST)).collect(),
            cells: series.time.iter().map(cell).collect(),
            cell_s,
            envelopes: [
                series
                    .rows
                    .iter()
                    .zip(&series.level)
                    .map(|(row, level)| level / row.u)
                    .collect(),
                series.rows.iter().map(|row| 1.0 / row.u).collect(),
            ],
            frequencies,
            sine: (0..TURN)
                .map(|k| (std::f64::consts::TAU * k as f64 / TURN as f64).sin())
                .collect(),
        })
    }

    /// The peak of the stretch from row `from` on: half of what it explains in σ², and its period in seconds.
    fn peak(&self, values: &[f64], from: usize) -> (f64, f64) {
        let mut best = (0.0, f64::INFINITY);
        for envelope in &self.envelopes {
            let rows = from..from + self.length;
            let square: f64 = envelope[rows.clone()].iter().map(|weight| weight * weight).sum();
            if square.is_nan() || square <= 0.0 {
                continue;
            }
            let products: Vec<f64> = rows.clone().map(|i| values[i] * envelope[i]).collect();
            for &frequency in &self.frequencies {
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
        let count = self.starts.len() as f64;
        let sum: f64 = self.starts.iter().map(|&from| self.peak(values, from).0).sum();
        // The largest of k exponential laws has the mean ln k + 0.58 and the variance π²/6 (Gumbel 1935).
        let expected = (self.frequencies.len() as f64).ln() + 0.577;
        let z = (sum - count * expected) / (count * std::f64::consts::PI.powi(2) / 6.0).sqrt();
        let mut best = Strongest::default();
        best.raise(0.5 * z.max(0.0).powi(2), 0);
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let mut peaks: Vec<(f64, f64)> = self.starts.iter().map(|&from| self.peak(&series.plain, from)).collect();
        // Neighbouring stretches share half of their readings.
        let explained = peaks.iter().map(|peak| peak.0).sum::<f64>();
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
        Finding::new(Kind::Periodic, Coordinate::TimeS, span, strongest, note).explaining(explained)
    }
}
