//! The strongest frequency, and the light without what cannot be distinguished from noise.

use isolux_reduce::Quantity;
use rustfft::num_complex::Complex;

use crate::transform;
use crate::window::{self, HANN};

/// Periods that a record must hold of a frequency.
pub(crate) const LEAST_PERIODS: f64 = 10.0;
/// One component of noise in so many records passes for light.
const FALSE_ALARM: f64 = 0.01;
/// Largest error of the frequency between bins, in bins: side lobes of another component that is as strong, ten bins
/// off.
const BETWEEN_BINS: f64 = 2e-3;
/// Scatter of the interpolation under the Hann window over the bound of Cramér and Rao.
const OVER_BOUND: f64 = 1.6;
/// Relative amplitude below which a component is arithmetic.
const NOTHING: f64 = 1e-9;

/// The strongest component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Strongest {
    pub frequency_hz: f64,
    /// Relative to the mean.
    pub amplitude: f64,
}

/// The strongest components of `samples` at frequencies from [`LEAST_PERIODS`] in the record on, and below; none of
/// what noise of `noise_rel` gives.
pub(crate) fn strongest(samples: &[f64], rate_hz: f64, noise_rel: f64) -> (Option<Strongest>, Option<Strongest>) {
    let count = samples.len();
    let mean = samples.iter().sum::<f64>() / count as f64;
    let amplitudes = transform::amplitudes(samples, HANN);
    let square = 4.0 * noise_rel * noise_rel * window::noise_bins(HANN) / count as f64;
    let least = (square * (0.5 * count as f64 / FALSE_ALARM).ln()).sqrt().max(NOTHING);
    let split = (LEAST_PERIODS.ceil() as usize).min(amplitudes.len());
    let best = |from: usize, to: usize| {
        let bin = (from..to).max_by(|a, b| amplitudes[*a].total_cmp(&amplitudes[*b]))?;
        let amplitude = amplitudes[bin] / mean;
        (amplitude > least).then(|| Strongest {
            frequency_hz: (bin as f64 + between(&amplitudes, bin)) * rate_hz / count as f64,
            amplitude,
        })
    };
    (best(split, amplitudes.len()), best(1, split))
}

/// Where between its neighbours the maximum of a sine under the Hann window lies, in bins: exact for one sine.
fn between(amplitudes: &[f64], bin: usize) -> f64 {
    let beside = |at: Option<usize>| at.and_then(|at| amplitudes.get(at)).copied().unwrap_or(0.0);
    let (below, above) = (beside(bin.checked_sub(1)), beside(bin.checked_add(1)));
    let (ratio, sign) = if above >= below {
        (above / amplitudes[bin], 1.0)
    } else {
        (below / amplitudes[bin], -1.0)
    };
    sign * ((2.0 * ratio - 1.0) / (1.0 + ratio)).clamp(-0.5, 1.0)
}

/// The frequency with its uncertainty; the clock of the recorder is not in it.
pub(crate) fn frequency(strongest: Strongest, samples: usize, rate_hz: f64, noise_rel: f64) -> Quantity {
    let duration_s = samples as f64 / rate_hz;
    let bound = 6.0_f64.sqrt() / (std::f64::consts::PI * duration_s) * noise_rel
        / (strongest.amplitude * (samples as f64).sqrt());
    Quantity::new(
        strongest.frequency_hz,
        "Hz",
        [
            ("noise", OVER_BOUND * bound),
            ("sampling", BETWEEN_BINS / 3.0_f64.sqrt() / duration_s),
        ],
    )
}

/// The light of a record without the components that noise gives.
pub(crate) struct Denoised {
    pub samples: Vec<f64>,
    /// The same with its noise.
    pub recorded: Vec<f64>,
    /// The transform of these samples, relative to the mean.
    pub bins: Vec<Complex<f64>>,
    /// What of the noise is left, of one sample, relative to the mean.
    pub noise_rel: f64,
}

impl Denoised {
    /// Of whole periods of `frequency_hz`, where it is known. `noise_rel` is that of one sample.
    pub(crate) fn of(samples: &[f64], rate_hz: f64, frequency_hz: Option<f64>, noise_rel: f64) -> Self {
        let periods = frequency_hz.map_or(0.0, |frequency_hz| {
            (samples.len() as f64 / rate_hz * frequency_hz + 1e-6).floor()
        });
        let whole = frequency_hz.map_or(samples.len(), |frequency_hz| {
            ((periods / frequency_hz * rate_hz).round() as usize).clamp(1, samples.len())
        });
        let samples = &samples[..whole];
        let mean = samples.iter().sum::<f64>() / whole as f64;
        let recorded: Vec<f64> = samples.iter().map(|value| value / mean).collect();
        let mut bins = transform::forward(recorded.iter().copied());
        // |X|² of a bin of noise has the mean N σ² and an exponential distribution.
        let least = whole as f64 * noise_rel * noise_rel * (0.5 * whole as f64 / FALSE_ALARM).ln();
        let least = least.max((0.5 * NOTHING * whole as f64).powi(2));
        // Harmonics stay however weak they are: a sharp turn of the light is made of many weak ones.
        let harmonic = |bin: usize| {
            let cycles = transform::cycles(bin, whole).abs();
            periods > 0.0 && cycles > 0.5 * periods && (cycles - (cycles / periods).round() * periods).abs() <= 1.0
        };
        let mut kept = 0_usize;
        for (place, bin) in bins.iter_mut().enumerate().skip(1) {
            if bin.norm_sqr() > least || (harmonic(place) && noise_rel > 0.0) {
                kept += 1;
            } else {
                *bin = Complex::new(0.0, 0.0);
            }
        }
        Self {
            samples: transform::inverse(bins.clone()),
            recorded,
            bins,
            noise_rel: noise_rel * (kept as f64 / whole as f64).sqrt(),
        }
    }
}

impl Denoised {
    /// What the extremes lose because a turn of the light lies between two samples, relative to the mean: on average a
    /// quarter of the step from the extreme to its nearer neighbour, where the light turns sharply; averaged over
    /// periods of so many samples.
    pub(crate) fn turns(&self, period: usize) -> f64 {
        let (mut low, mut high, mut count) = (0.0_f64, 0.0_f64, 0.0_f64);
        for light in self.samples.chunks_exact(period) {
            let by_value = |a: &usize, b: &usize| light[*a].total_cmp(&light[*b]);
            let step = |at: usize| (light[at] - light[at - 1]).abs().min((light[at + 1] - light[at]).abs());
            let inner = 1..period.saturating_sub(1);
            if let Some((lowest, highest)) = inner.clone().min_by(by_value).zip(inner.max_by(by_value)) {
                low += step(lowest) / 4.0;
                high += step(highest) / 4.0;
                count += 1.0;
            }
        }
        low.max(high) / count.max(1.0)
    }
}

/// Standard deviations by which the noise may move an extreme of a piece of a record.
const BEYOND: f64 = 5.0;

/// Modulation depth and flicker index of a piece of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shape {
    pub lowest: f64,
    pub highest: f64,
    /// Whether an extreme is that of the record, moved by its noise as far as that may be: steps in the light ring
    /// where their weak components go with the noise.
    pub bounded: bool,
    /// Area above the mean over the whole area.
    pub index: f64,
    /// Largest step across the mean, relative to the mean.
    pub step: f64,
    /// Crossings of the mean per sample.
    pub crossings: f64,
}

impl Shape {
    /// Of a piece without its noise, and as it was recorded with noise of `noise_rel`.
    pub(crate) fn of(samples: &[f64], recorded: &[f64], noise_rel: f64) -> Self {
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let highest = |samples: &[f64]| samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = |samples: &[f64]| samples.iter().copied().fold(f64::INFINITY, f64::min);
        let ends = (lowest(samples), highest(samples));
        let (low, high) = (lowest(recorded), highest(recorded));
        let within = (
            ends.0.clamp(low, low + BEYOND * noise_rel),
            ends.1.clamp(high - BEYOND * noise_rel, high),
        );
        let above: f64 = samples.iter().map(|value| (value - mean).max(0.0)).sum();
        let (mut step, mut crossings) = (0.0_f64, 0.0);
        for pair in samples.windows(2) {
            if (pair[0] >= mean) != (pair[1] >= mean) {
                step = step.max((pair[1] - pair[0]).abs() / mean);
                crossings += 1.0 / count;
            }
        }
        Self {
            lowest: within.0,
            highest: within.1,
            bounded: noise_rel > 0.0 && within != ends,
            index: above / (mean * count),
            step,
            crossings,
        }
    }

    /// (highest − lowest)/(highest + lowest).
    pub(crate) fn depth(&self) -> f64 {
        (self.highest - self.lowest) / (self.highest + self.lowest)
    }
}
