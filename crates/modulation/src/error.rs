//! Why a record is no waveform of light, and what to do.

/// Why a waveform is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WaveformError {
    /// A line of a text file.
    #[error("line {line}: {problem}")]
    Line {
        /// From 1.
        line: usize,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// The file as a whole.
    #[error("{0}")]
    File(String),
    /// Samples at an end of the recorder's range.
    #[error(
        "{count} of {samples} samples are at the end of the range of the recorder, the first at {time_s} s: choose a \
         larger range and record again"
    )]
    OverRange {
        /// Samples there.
        count: usize,
        /// All samples.
        samples: usize,
        /// Time of the first.
        time_s: f64,
    },
    /// No light, or a signal without its mean.
    #[error(
        "the mean, {mean}, is not above zero: record with a DC-coupled input (a sound card has none), and state the \
         dark level"
    )]
    NoMean {
        /// In units of the file.
        mean: f64,
    },
    /// Light below zero.
    #[error(
        "the signal falls to {lowest}, {percent:.1} % of its largest value: light is not negative; record with a \
         DC-coupled input, and state the dark level"
    )]
    Negative {
        /// Lowest sample after the dark level is subtracted.
        lowest: f64,
        /// The same in per cent of the largest.
        percent: f64,
    },
    /// Too short a record.
    #[error(
        "the record of {duration_s} s holds {periods:.1} periods of {frequency_hz:.4} Hz: {least} are needed; record \
         longer"
    )]
    TooFewPeriods {
        /// Length of the record.
        duration_s: f64,
        /// Periods in it.
        periods: f64,
        /// Strongest frequency.
        frequency_hz: f64,
        /// Periods that are needed.
        least: f64,
    },
    /// Too few samples.
    #[error("{samples} samples: at least {least} are needed")]
    TooFewSamples {
        /// In the file.
        samples: usize,
        /// Needed.
        least: usize,
    },
}
