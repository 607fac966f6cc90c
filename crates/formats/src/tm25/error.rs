//! Why bytes are no TM-25 ray file.

/// Why bytes are no TM-25 ray file. Spans are of bytes, the last one exclusive.
#[derive(Debug, thiserror::Error)]
pub enum Tm25Error {
    /// The first four bytes.
    #[error(
        "`TM25` expected, found `{}`: this is no TM-25 ray file",
        String::from_utf8_lossy(found)
    )]
    Magic {
        /// What stands there.
        found: Vec<u8>,
    },
    /// A version that this reader does not know.
    #[error("version {version}: only 2013 is known")]
    Version {
        /// What stands there.
        version: i32,
    },
    /// The file ends early.
    #[error("the file ends at byte {found}, within {within}, which needs {expected} bytes")]
    Truncated {
        /// What was being read.
        within: &'static str,
        /// Bytes that would be needed.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// Bytes and header contradict each other.
    #[error("the header's {rays} rays of {columns} numbers end at byte {expected}, the file at {found}")]
    Length {
        /// Rays by the header.
        rays: u64,
        /// Numbers a ray.
        columns: usize,
        /// Where the rays would end.
        expected: u64,
        /// Where the file ends.
        found: u64,
    },
    /// A flag or count outside what the standard allows.
    #[error("{name} = {value} is not allowed{need}")]
    Field {
        /// Where.
        span: [u64; 2],
        /// Which.
        name: &'static str,
        /// What stands there.
        value: i64,
        /// What may.
        need: &'static str,
    },
    /// The stream.
    #[error("the file cannot be read: {0}")]
    Io(#[from] std::io::Error),
}

impl Tm25Error {
    /// Stable name of the finding.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Magic { .. } => "tm25-magic",
            Self::Version { .. } => "tm25-version",
            Self::Truncated { .. } => "tm25-truncated",
            Self::Length { .. } => "tm25-length",
            Self::Field { .. } => "tm25-field",
            Self::Io(_) => "file-unreadable",
        }
    }

    /// First byte and the one beyond the last that the error is about.
    pub fn span(&self) -> Option<[u64; 2]> {
        match self {
            Self::Magic { found } => Some([0, found.len() as u64]),
            Self::Version { .. } => Some([4, 8]),
            Self::Truncated { expected, found, .. } => Some([*found, *expected]),
            Self::Length { expected, found, .. } => Some([*expected.min(found), *expected.max(found)]),
            Self::Field { span, .. } => Some(*span),
            Self::Io(_) => None,
        }
    }
}
