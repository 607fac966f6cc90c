//! What can be wrong with a readings file.

use camino::Utf8PathBuf;

/// A readings file that cannot be trusted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadingsError {
    /// Its first line is not the header of this version.
    #[error("{file}:1: not the header of a run's readings, found `{found}`")]
    Header {
        /// The file.
        file: Utf8PathBuf,
        /// The line found.
        found: String,
    },
    /// A row whose bytes are not those that were written.
    #[error("{file}:{line}: row {row} is damaged: checksum {found} written, {computed} computed")]
    Checksum {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Number of the row, from 0.
        row: usize,
        /// The checksum in the row.
        found: String,
        /// The checksum of the row.
        computed: String,
    },
    /// A row that does not continue the rows before it.
    #[error(
        "{file}:{line}: row {row} does not continue the rows before it: rows were removed, exchanged or taken from another run"
    )]
    Chain {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Number of the row, from 0.
        row: usize,
    },
    /// A row with a right checksum whose content cannot be.
    #[error("{file}:{line}: column {column}: {message}")]
    Content {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What is wrong.
        message: String,
    },
}
