//! What a camera sees of modulated light.
//!
//! An exposure of t seconds is a mean over t: a component of frequency f keeps sinc(f t) = sin(πft)/(πft) of its
//! amplitude. The rows of a rolling shutter are exposed one line time after another: the modulation becomes bands,
//! which the diagnosis calls the effect `flicker_banding`.

use rustfft::num_complex::Complex;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::transform;

/// Light as exposures of one length see it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Exposed {
    /// Length of an exposure, ms.
    pub exposure_ms: f64,
    /// Largest less smallest exposure relative to their mean.
    pub peak_to_peak_rel: f64,
    /// Standard deviation of exposures at random times relative to their mean.
    pub rms_rel: f64,
    /// What noise of the record adds to the standard deviation.
    pub noise_rel: f64,
    /// Bands of a rolling shutter; none without a line time.
    pub banding: Option<Banding>,
}

/// Bands of a rolling shutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Banding {
    /// Line time, µs.
    pub line_time_us: f64,
    /// Rows of one band; none where no component is left after the exposure.
    pub period_rows: Option<f64>,
    /// Half the difference of the brightest and the darkest row relative to their mean: `amplitude_rel` of the effect
    /// `flicker_banding`.
    pub amplitude_rel: f64,
}

/// sin(πx)/(πx).
fn sinc(x: f64) -> f64 {
    let turn = std::f64::consts::PI * x;
    if turn.abs() < 1e-9 { 1.0 } else { turn.sin() / turn }
}

impl Exposed {
    /// Of light with these `bins` relative to its mean, and `noise_rel` left in a sample of it.
    pub(crate) fn of(
        bins: &[Complex<f64>],
        rate_hz: f64,
        noise_rel: f64,
        exposure_s: f64,
        line_time_s: Option<f64>,
    ) -> Self {
        let count = bins.len();
        let step_hz = rate_hz / count as f64;
        let seen: Vec<_> = bins
            .iter()
            .enumerate()
            .map(|(bin, value)| value * sinc(transform::cycles(bin, count) * step_hz * exposure_s))
            .collect();
        let square: f64 = seen.iter().skip(1).map(Complex::norm_sqr).sum::<f64>() / (count as f64).powi(2);
        let strongest = (1..=count / 2)
            .max_by(|a, b| seen[*a].norm_sqr().total_cmp(&seen[*b].norm_sqr()))
            .filter(|bin| 2.0 * seen[*bin].norm() / count as f64 > 1e-9);
        let light = transform::inverse(seen);
        let (low, high) = light
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
        let banding = line_time_s.map(|line_time_s| Banding {
            line_time_us: 1e6 * line_time_s,
            period_rows: strongest.map(|bin| {
                // Faster than one period in two rows, the rows sample it as something slower.
                let turns = bin as f64 * step_hz * line_time_s;
                1.0 / (turns - turns.round()).abs()
            }),
            amplitude_rel: (high - low) / (high + low),
        });
        Self {
            exposure_ms: 1e3 * exposure_s,
            peak_to_peak_rel: high - low,
            rms_rel: square.sqrt(),
            noise_rel: noise_rel / (exposure_s * rate_hz).max(1.0).sqrt(),
            banding,
        }
    }
}
