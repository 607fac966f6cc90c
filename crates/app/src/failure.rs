//! What a use case answers when it cannot do what was asked, and the exit code that stands for it.

use std::fmt;

use isolux_report::sensor::ViewError;

/// Why a use case ended without its result; each kind is one documented exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FailureKind {
    /// The answer is "no": a check failed, a file has a finding of level error, a discrepancy stays unexplained. Exit
    /// 1.
    No,
    /// Bad usage or bad input; nothing was written. Exit 2.
    BadInput,
    /// An instrument or the operating system failed, or an axis could not be verified at rest. Exit 3, wins over all.
    Instrument,
    /// A signal: SIGINT, SIGTERM, SIGHUP or SIGQUIT; the axes were stopped first. Exit 130.
    Interrupted,
    /// The reader of standard output closed it before everything was written; nothing is said. Exit 141, as a shell
    /// shows for programs that SIGPIPE ends.
    Closed,
}

impl FailureKind {
    /// The process exit code.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::No => 1,
            Self::BadInput => 2,
            Self::Instrument => 3,
            Self::Interrupted => 130,
            Self::Closed => 141,
        }
    }
}

/// A failure as a person reads it: what happened, where, and what to do.
#[derive(Debug)]
pub struct Failure {
    /// Decides the exit code.
    pub kind: FailureKind,
    /// What happened, with file, line, register or frame: one sentence in lower case, no full stop.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Failure {
    /// Bad usage or bad input (exit 2).
    pub fn bad_input(error: impl fmt::Display) -> Self {
        Self {
            kind: FailureKind::BadInput,
            message: error.to_string(),
            help: None,
        }
    }

    /// An instrument or the operating system failed (exit 3).
    pub fn instrument(error: impl fmt::Display) -> Self {
        Self {
            kind: FailureKind::Instrument,
            message: error.to_string(),
            help: None,
        }
    }

    /// The answer is "no" (exit 1).
    pub fn no(error: impl fmt::Display) -> Self {
        Self {
            kind: FailureKind::No,
            message: error.to_string(),
            help: None,
        }
    }

    /// The same failure with advice.
    #[must_use]
    pub fn help(mut self, advice: impl Into<String>) -> Self {
        self.help = Some(advice.into());
        self
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::Model(error) => Self::bad_input(error),
            ViewError::Rating(error) => Self::bad_input(error),
            ViewError::Script(error) => Self::instrument(error),
        }
    }
}
