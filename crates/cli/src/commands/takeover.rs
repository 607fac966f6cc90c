//! What the commands that open instruments share: taking them over.

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

/// Taking over what another process has.
#[derive(Debug, Args)]
pub struct TakeOver {
    /// Take instruments and run directory over from a process that does not answer, and record why. Never from one that
    /// works.
    #[arg(long, value_name = "REASON", value_parser = NonEmptyStringValueParser::new())]
    force: Option<String>,
}

impl TakeOver {
    /// The reason, where it is asked for.
    pub fn reason(&self) -> Option<&str> {
        self.force.as_deref()
    }
}
