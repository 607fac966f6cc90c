//! What can be wrong with a recorded sweep.

use camino::Utf8PathBuf;

/// A sweep that cannot be read or written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// A line that cannot be.
    #[error("{file}:{line}: {message}")]
    Content {
        /// The file.
        file: Utf8PathBuf,
        /// One-based line.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A description that TOML cannot hold.
    #[error("the sweep's description cannot be written: {0}")]
    Description(String),
}
