//! What can be wrong with a file of observations, and where.

use std::fmt;

use camino::{Utf8Path, Utf8PathBuf};

/// A file of observations cannot be used: the file, the line where there is one, and what is wrong there.
#[derive(Debug, Clone, PartialEq)]
pub struct ObservationError {
    /// The file.
    pub path: Utf8PathBuf,
    /// One-based line.
    pub line: Option<u64>,
    /// What is wrong.
    pub problem: Problem,
}

/// What is wrong with a file of observations.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The operating system refused.
    #[error("cannot be read: {0}")]
    Read(String),
    /// Bytes that are no text.
    #[error("is not UTF-8 text")]
    NotText,
    /// TOML that is none, or a key that nobody knows.
    #[error("{0}")]
    Toml(String),
    /// A folder without readings.
    #[error("is a folder without readings.csv; give a run directory, a readings CSV, a maps.toml or a spectra.toml")]
    NotARun,
    /// A run whose record cannot be used.
    #[error("{0}")]
    Record(String),
    /// The readings of a run without its run.toml.
    #[error(
        "has readings.csv of a run and no run.toml: what was recorded cannot be compared; restore run.toml from a copy"
    )]
    NoRunToml,
    /// Another document of this program.
    #[error("is no file of observations; give a run directory, a readings CSV, a maps.toml or a spectra.toml")]
    NotObservations,
    /// A column that must be there.
    #[error("column `{column}` is missing; needed are {needed}")]
    MissingColumn {
        /// The missing column.
        column: &'static str,
        /// All that are needed.
        needed: String,
    },
    /// A column that is there twice.
    #[error("column `{0}` is there twice")]
    DuplicateColumn(String),
    /// A row with another number of fields than the header.
    #[error("has {found} fields where the header has {expected}")]
    FieldCount {
        /// Fields in the row.
        found: usize,
        /// Fields in the header.
        expected: usize,
    },
    /// A field that must not be empty.
    #[error("`{0}` is empty")]
    Empty(&'static str),
    /// A field that is no finite number.
    #[error("`{column}` = `{found}` is no finite number")]
    NotANumber {
        /// The column.
        column: &'static str,
        /// Its text.
        found: String,
    },
    /// A number outside what is possible.
    #[error("`{column}` = {found}: it must be {expected}")]
    OutOfRange {
        /// The column or key.
        column: &'static str,
        /// Its value.
        found: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// A word that is not known.
    #[error("`{column}` = `{found}` is none of {expected}")]
    UnknownWord {
        /// The column.
        column: &'static str,
        /// Its text.
        found: String,
        /// Known words.
        expected: &'static str,
    },
    /// Two rows for the same thing.
    #[error("{what} is there twice; the first is on line {first}")]
    Duplicate {
        /// What is repeated.
        what: String,
        /// Line of the first.
        first: u64,
    },
    /// A row whose checksum does not fit.
    #[error("`row_crc` is {found}, the row's bytes give {computed}: the row was changed after it was written")]
    Checksum {
        /// As written.
        found: String,
        /// As computed.
        computed: String,
    },
    /// No rows.
    #[error("holds no {0}")]
    NoRows(&'static str),
    /// A row of a map that maps.toml does not have.
    #[error("map `{0}` is not in the maps file")]
    UnknownMap(String),
    /// A bin outside the map.
    #[error("{column} = {found} is outside 0…{last}")]
    OutsideMap {
        /// "iy" or "ix".
        column: &'static str,
        /// The index.
        found: String,
        /// The largest possible.
        last: usize,
    },
    /// A map that has no measured values.
    #[error("map `{0}` has no values; give its rows, or say held_out = true where it is only a pose to predict")]
    MapWithoutValues(String),
    /// A map in which every bin has the same value.
    #[error(
        "map `{name}`: all {bins} bins hold {value}: it is saturated or empty; measure it again with another exposure"
    )]
    Saturated {
        /// Its name.
        name: String,
        /// Number of bins.
        bins: usize,
        /// The value of all of them.
        value: f64,
    },
    /// Images come without uncertainties.
    #[error("images need [noise] u_abs and u_rel in the maps file")]
    NoNoise,
    /// An image that cannot be used.
    #[error("image: {0}")]
    Image(String),
    /// An image of another size.
    #[error("image is {found:?} pixels (width, height), the maps file says {expected:?}")]
    ImageSize {
        /// Its size.
        found: [usize; 2],
        /// The size expected.
        expected: [usize; 2],
    },
}

impl ObservationError {
    /// A problem in a file.
    pub fn new(path: &Utf8Path, line: Option<u64>, problem: Problem) -> Self {
        Self {
            path: path.to_owned(),
            line,
            problem,
        }
    }
}

impl fmt::Display for ObservationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path, self.problem),
            None => write!(f, "{}: {}", self.path, self.problem),
        }
    }
}

impl std::error::Error for ObservationError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.problem)
    }
}
