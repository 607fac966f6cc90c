//! A periodogram of the residuals over time or number (Lomb 1976, Scargle 1982, on a grid).

use std::ops::Range;
use std::sync::Arc;

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use super::finding::{Finding, Kind, Strongest, digits};
use super::limits::CELLS;
use super::series::{ADDED, RELATIVE, Series};
use super::statistic::Test;
use crate::table::Coordinate;

/// Power at every frequency, for an error that multiplies the light and for one that is added to it.
pub(super) struct Spectrum {
    coordinate: Coordinate,
    cells: Vec<usize>,
    size: usize,
    cell: f64,
    range: [f64; 2],
    envelopes: [Vec<f64>; 2],
    bins: Range<usize>,
    fft: Arc<dyn Fft<f64>>,
}

impl Spectrum {
    /// Over `position`, whose typical step is divided into `parts` cells. None where the rows have no position or no
    /// span.
    pub(super) fn new(series: &Series<'_>, coordinate: Coordinate, position: &[f64], parts: f64) -> Option<Self> {
        // Numbers need not rise with the time.
        let mut rising = position.to_vec();
        rising.sort_by(f64::total_cmp);
        let (first, last) = (*rising.first()?, *rising.last()?);
        let span = last - first;
        let mut steps: Vec<f64> = rising.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if !span.is_finite() {
            return None;
        }
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let typical = *steps.get(steps.len() / 2)?;
        let cell = (typical / parts).max(span / (CELLS as f64 / 2.0));
        // A span that is no normal number divides into no cells.
        if !(span / cell).is_finite() {
            return None;
        }
        let size = ((1.5 * span / cell) as usize + 2).next_power_of_two();
        let cells = position
            .iter()
            .map(|at| ((at - first) / cell).round() as usize)
            .collect();
        let unit = |weights: &Vec<f64>| -> Vec<f64> {
            let length = weights.iter().map(|w| w * w).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            weights.iter().map(|w| w / length).collect()
        };
        // From one period in the record to nearly two readings a period, where cosine and sine are no longer two.
        let lowest = (size as f64 * cell / span).ceil() as usize;
        let highest = (0.49 * size as f64 * cell / typical.max(cell)) as usize;
        (highest > lowest).then(|| Self {
            coordinate,
            cells,
            size,
            cell,
            range: [first, last],
            envelopes: [unit(&series.errors[RELATIVE]), unit(&series.errors[ADDED])],
            bins: lowest..highest,
            fft: FftPlanner::new().plan_fft_forward(size),
        })
    }

    /// Half of what each frequency explains, in σ²: both envelopes in one transform.
    fn powers(&self, values: &[f64]) -> Vec<[f64; 2]> {
        let mut buffer = vec![Complex::new(0.0, 0.0); self.size];
        let [relative, added] = &self.envelopes;
        for (((value, &cell), relative), added) in values.iter().zip(&self.cells).zip(relative).zip(added) {
            buffer[cell] += Complex::new(value * relative, value * added);
        }
        self.fft.process(&mut buffer);
        self.bins
            .clone()
            .map(|k| {
                let (here, mirrored) = (buffer[k], buffer[self.size - k].conj());
                [0.25 * (here + mirrored).norm_sqr(), 0.25 * (here - mirrored).norm_sqr()]
            })
            .collect()
    }

    fn period(&self, bin: f64) -> f64 {
        self.size as f64 * self.cell / bin
    }

    /// The frequency near one of the grid that explains most, in its unit, and what it explains, in σ².
    fn refined(&self, values: &[f64], place: usize) -> (f64, f64) {
        let envelope = &self.envelopes[place % 2];
        let middle = (self.bins.start + place / 2) as f64;
        let explained = |bin: f64| {
            let turn = std::f64::consts::TAU * bin / self.size as f64;
            let (mut sine, mut cosine) = (0.0, 0.0);
            for ((value, weight), &cell) in values.iter().zip(envelope).zip(&self.cells) {
                let (s, c) = (turn * cell as f64).sin_cos();
                sine += value * weight * s;
                cosine += value * weight * c;
            }
            2.0 * (sine * sine + cosine * cosine)
        };
        (-10..=10)
            .map(|part| middle + 0.1 * f64::from(part))
            .map(|bin| (bin, explained(bin)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((middle, 0.0))
    }

    /// The strongest periods and half of what each explains, in σ².
    pub(super) fn peaks(&self, values: &[f64], most: usize) -> Vec<(f64, f64)> {
        let powers: Vec<f64> = self.powers(values).iter().map(|both| both[0].max(both[1])).collect();
        let is_peak = |&k: &usize| {
            let near = &powers[k.saturating_sub(2)..(k + 3).min(powers.len())];
            near.iter().all(|power| *power <= powers[k])
        };
        let mut peaks: Vec<usize> = (0..powers.len()).filter(is_peak).collect();
        peaks.sort_by(|&a, &b| powers[b].total_cmp(&powers[a]));
        peaks.truncate(most);
        peaks
            .into_iter()
            .map(|k| (self.period((self.bins.start + k) as f64), powers[k]))
            .collect()
    }

    pub(super) fn coordinate(&self) -> Coordinate {
        self.coordinate
    }
}

impl Test for Spectrum {
    fn strongest(&self, values: &[f64]) -> Strongest {
        let mut best = Strongest::default();
        for (k, both) in self.powers(values).iter().enumerate() {
            for (envelope, power) in both.iter().enumerate() {
                best.raise(*power, 2 * k + envelope);
            }
        }
        best
    }

    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding {
        let (bin, whole) = self.refined(&series.plain, strongest.place);
        let period = self.period(bin);
        let what = match strongest.place % 2 {
            0 => "an error relative to the light",
            _ => "an added error",
        };
        let note = match self.coordinate {
            Coordinate::TimeS => format!("{what} with a period of {} s", digits(period)),
            _ => format!("{what} with a period of {} readings", digits(period)),
        };
        Finding::new(Kind::Period, self.coordinate, self.range, strongest, note)
            .with_period(period)
            .explaining(whole)
    }
}
