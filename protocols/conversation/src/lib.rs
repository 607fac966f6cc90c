//! What every codec implements: one request at a time, and which bytes answer it.
//!
//! A conversation is the host's side of a line, without a clock and without input or output of its own. The owner of
//! the link (`isolux-transport`) sends the bytes, passes on those that arrive, and keeps the deadlines.

use std::time::Instant;

/// The host's side of one language on one line.
///
/// Contract of the caller: no [`start`](Self::start) before [`ready_at`](Self::ready_at); every byte that arrives goes
/// to [`handle_input`](Self::handle_input), between requests too; [`abandon`](Self::abandon) once the deadline has
/// passed. A request is over with its answer, with [`Event::Malformed`] or when it is abandoned, and only then may the
/// next one start.
///
/// Contract of the codec: bytes that belong to an older request never answer a newer one. Where the language numbers
/// its messages, the number decides; where it does not, the codec demands silence on the line after every failure.
pub trait Conversation: Send + 'static {
    /// One request.
    type Request: Send + 'static;
    /// One answer.
    type Answer: Send + 'static;

    /// Earliest moment at which a request may be sent.
    fn ready_at(&self, now: Instant) -> Instant {
        now
    }

    /// Begins a request.
    fn start(&mut self, now: Instant, request: Self::Request) -> Start<Self::Answer>;

    /// Takes bytes in whatever pieces they arrive. At most one event of a call ends the request in flight.
    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Self::Answer>>;

    /// Answers so far beyond the first to one request, where the language can tell.
    fn surplus(&self) -> u64 {
        0
    }

    /// Gives the request in flight up; returns what had arrived of an answer.
    fn abandon(&mut self, now: Instant) -> Vec<u8>;
}

/// How a request begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Start<A> {
    /// The bytes to send.
    pub frame: Vec<u8>,
    /// The outcome, for a request that nobody answers: it is over once it has been sent.
    pub at_once: Option<A>,
}

impl<A> Start<A> {
    /// A request that will be answered.
    pub const fn answered(frame: Vec<u8>) -> Self {
        Self { frame, at_once: None }
    }
}

/// What came of the bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event<A> {
    /// The answer to the request in flight.
    Answer(A),
    /// The request in flight met bytes that are no answer to it.
    Malformed {
        /// What is wrong with them.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
    /// Something for the log: an alert, a late answer that was dropped.
    Remark(String),
}
