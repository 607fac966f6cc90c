//! A record of light over time at one sample rate.

use crate::recorded::Recorded;
use crate::{WaveformError, csv, wav};

/// Fewest samples of a record.
const LEAST_SAMPLES: usize = 64;
/// Largest share of the largest value that a sample may lie below zero: what an offset leaves that nobody stated.
const NEGATIVE: f64 = 0.02;
/// Noise below zero is no negative light: standard deviations of the noise that are allowed in addition.
const NOISE: f64 = 6.0;

/// The form of a file of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Text: one column, or time and value.
    Csv,
    /// RIFF WAVE, integers of 8 to 32 bits or 32-bit floats.
    Wav,
}

impl Form {
    /// By the beginning of the content: `RIFF` is WAVE, everything else text.
    pub fn of(bytes: &[u8]) -> Self {
        if bytes.starts_with(b"RIFF") {
            Self::Wav
        } else {
            Self::Csv
        }
    }
}

/// What a person states about a file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Source {
    /// Sample rate in Hz, where the file has none.
    pub rate_hz: Option<f64>,
    /// What the recorder shows in the dark, in units of the file; subtracted. None: zero is dark.
    pub dark: Option<f64>,
}

/// Samples of light in even steps of time, the dark level subtracted, none at an end of the recorder's range.
#[derive(Debug, Clone, PartialEq)]
pub struct Waveform {
    samples: Vec<f64>,
    rate_hz: f64,
    unit: String,
    dark_is_stated: bool,
}

impl Waveform {
    /// Reads a file; its form by its content.
    ///
    /// # Errors
    /// [`WaveformError`], with the line where the file is text.
    pub fn parse(bytes: &[u8], source: Source) -> Result<Self, WaveformError> {
        let recorded = match Form::of(bytes) {
            Form::Csv => csv::read(bytes, source.rate_hz)?,
            Form::Wav => wav::read(bytes, source.rate_hz)?,
        };
        Self::from_recorded(recorded, source.dark)
    }

    /// Samples in `unit` at `rate_hz`; `range` is what the recorder can show, `dark` what it shows without light, both
    /// in `unit`.
    ///
    /// # Errors
    /// [`WaveformError`] for too few samples, what is no number, over-range and signals that no light gives.
    pub fn new(
        samples: Vec<f64>,
        rate_hz: f64,
        unit: &str,
        range: Option<(f64, f64)>,
        dark: Option<f64>,
    ) -> Result<Self, WaveformError> {
        let recorded = Recorded {
            samples,
            rate_hz,
            unit: unit.to_owned(),
            range,
        };
        Self::from_recorded(recorded, dark)
    }

    fn from_recorded(recorded: Recorded, dark: Option<f64>) -> Result<Self, WaveformError> {
        let Recorded {
            mut samples,
            rate_hz,
            unit,
            range,
        } = recorded;
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(WaveformError::File(format!(
                "a sample rate of {rate_hz} Hz: state one above zero"
            )));
        }
        if samples.len() < LEAST_SAMPLES {
            return Err(WaveformError::TooFewSamples {
                samples: samples.len(),
                least: LEAST_SAMPLES,
            });
        }
        if let Some(bad) = samples.iter().position(|value| !value.is_finite()) {
            return Err(WaveformError::File(format!("sample {} is no number", bad + 1)));
        }
        if let Some((low, high)) = range {
            let at_end = |value: &f64| *value <= low || *value >= high;
            if let Some(first) = samples.iter().position(at_end) {
                return Err(WaveformError::OverRange {
                    count: samples.iter().filter(|value| at_end(value)).count(),
                    samples: samples.len(),
                    time_s: first as f64 / rate_hz,
                });
            }
        }
        let dark_is_stated = dark.is_some();
        let dark = dark.unwrap_or(0.0);
        for value in &mut samples {
            *value -= dark;
        }
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let (lowest, highest) = samples
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
        // A sum of finite samples may overflow.
        if !(mean.is_finite() && mean > 0.0) {
            return Err(WaveformError::NoMean { mean });
        }
        let noise = crate::noise::of_differences(&samples);
        if lowest < -(NEGATIVE * highest + NOISE * noise) {
            return Err(WaveformError::Negative {
                lowest,
                percent: 100.0 * lowest / highest,
            });
        }
        Ok(Self {
            samples,
            rate_hz,
            unit,
            dark_is_stated,
        })
    }

    /// Whether a person stated the dark level; else zero is taken for dark.
    pub fn dark_is_stated(&self) -> bool {
        self.dark_is_stated
    }

    /// In units of the file.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// Samples a second.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Unit of the samples; empty where the file does not say.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Samples over sample rate.
    pub fn duration_s(&self) -> f64 {
        self.samples.len() as f64 / self.rate_hz
    }

    /// Mean of the samples, above zero.
    pub fn mean(&self) -> f64 {
        self.samples.iter().sum::<f64>() / self.samples.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(samples: Vec<f64>, range: Option<(f64, f64)>, dark: Option<f64>) -> Result<Waveform, WaveformError> {
        Waveform::new(samples, 1000.0, "V", range, dark)
    }

    fn wave(offset: f64) -> Vec<f64> {
        (0..1000).map(|k| offset + (0.3 * f64::from(k)).sin()).collect()
    }

    #[test]
    fn signals_that_no_light_gives_are_refused() {
        assert!(of(wave(1.5), None, None).is_ok());
        // A dark level moves the mean, and too large a one makes light negative.
        assert!((of(wave(2.0), None, Some(0.5)).unwrap().mean() - 1.5).abs() < 0.01);
        assert!(matches!(
            of(wave(2.0), None, Some(1.2)),
            Err(WaveformError::Negative { .. })
        ));
        assert!(matches!(of(wave(-1.5), None, None), Err(WaveformError::NoMean { .. })));
        assert!(matches!(
            of(wave(0.01), None, None),
            Err(WaveformError::Negative { .. })
        ));
        assert!(matches!(
            of(wave(1.5), Some((0.0, 2.4)), None),
            Err(WaveformError::OverRange { .. })
        ));
        assert!(of(wave(1.5), Some((0.0, 2.6)), None).is_ok());
        let few = of(vec![1.0; 63], None, None);
        assert!(matches!(few, Err(WaveformError::TooFewSamples { .. })));
        let mut hole = wave(1.5);
        hole[7] = f64::NAN;
        assert!(of(hole, None, None).unwrap_err().to_string().contains("sample 8"));
        assert!(
            of(vec![f64::MAX; 100], None, None).is_err(),
            "a mean beyond the numbers"
        );
    }
}
