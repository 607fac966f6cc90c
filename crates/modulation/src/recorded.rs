//! Samples as a file has them.

/// What a reader finds in a file.
pub(crate) struct Recorded {
    pub samples: Vec<f64>,
    pub rate_hz: f64,
    pub unit: String,
    /// Ends of the recorder's range, where the file says.
    pub range: Option<(f64, f64)>,
}
