//! What a long use case tells its front end while it works.

use crate::live::Live;

/// One thing that happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Event<'a> {
    /// A step of the day began ("warm up", "scan", …); `total` counts its units of work where it is known.
    Began {
        /// Name of the step.
        step: &'a str,
        /// Units of work in it.
        total: Option<u64>,
    },
    /// The step stands at `done` units, with a short word on what is being done.
    At {
        /// Units done.
        done: u64,
        /// What is being done now.
        what: &'a str,
    },
    /// The step ended with this sentence.
    Ended(&'a str),
    /// Something worth a line that is no step: a warning, a correction that does not apply.
    Note(&'a str),
    /// An event of a scan, typed; what people should read of it follows in the words above.
    Live(&'a Live),
}

/// Receives the events of a use case; called from the thread that works.
pub trait Progress {
    /// Takes one event. Must not block for long.
    fn event(&self, event: Event<'_>);
}

/// Discards every event: tests and scripts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn event(&self, _: Event<'_>) {}
}
