//! A row of a spectrum.

/// One row as it stands in the file.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub line: usize,
    pub column: usize,
    /// The abscissa, in the file's unit.
    pub x: f64,
    /// One value a series; none where blank.
    pub value: Vec<Option<f64>>,
}
