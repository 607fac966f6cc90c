//! One request at a time, and silence after a failure.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

/// Which bytes ask, and which answer.
pub trait Language: Send + 'static {
    /// One request.
    type Request: Send + 'static;
    /// What an answer says.
    type Answer: Send + 'static;

    /// How long the line must have been silent after a failure: longer than the slowest answer takes to begin.
    fn quiet(&self) -> Duration;

    /// An answer has no more bytes than this.
    fn longest(&self) -> usize {
        256
    }

    /// Begins a request: its bytes, and its outcome where nobody answers it.
    fn start(&mut self, request: Self::Request) -> (Vec<u8>, Option<Self::Answer>);

    /// Judges everything that has arrived since the request. An answer must be all of it: bytes beyond its end are
    /// damage.
    fn judge(&self, received: &[u8]) -> Judgement<Self::Answer>;
}

/// What the bytes since a request are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Judgement<A> {
    /// The beginning of an answer.
    More,
    /// The answer.
    Answer(A),
    /// No answer to this request, for this reason.
    Damaged(String),
}

/// An answer and its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply<A> {
    /// What it says.
    pub answer: A,
    /// As it came; empty where nobody answers.
    pub bytes: Vec<u8>,
}

/// The conversation in a [`Language`].
///
/// These languages do not number their messages, or only within short cycles. After a timeout or a damaged answer
/// anything that arrives may be the answer that was given up: it is thrown away, and each byte of it makes the silence
/// begin anew.
#[derive(Debug)]
pub struct Lines<L> {
    language: L,
    waiting: bool,
    received: Vec<u8>,
    quarantine: Option<Instant>,
}

impl<L: Language> Lines<L> {
    /// A conversation in `language`; nothing has been said yet.
    pub const fn new(language: L) -> Self {
        Self {
            language,
            waiting: false,
            received: Vec::new(),
            quarantine: None,
        }
    }

    fn damaged(&mut self, now: Instant, reason: String) -> Event<Reply<L::Answer>> {
        Event::Malformed {
            reason,
            frame: self.abandon(now),
        }
    }
}

impl<L: Language + Default> Default for Lines<L> {
    fn default() -> Self {
        Self::new(L::default())
    }
}

impl<L: Language> Conversation for Lines<L> {
    type Request = L::Request;
    type Answer = Reply<L::Answer>;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quarantine.map_or(now, |until| until.max(now))
    }

    fn start(&mut self, _: Instant, request: L::Request) -> Start<Self::Answer> {
        self.quarantine = None;
        self.received.clear();
        let (frame, outcome) = self.language.start(request);
        self.waiting = outcome.is_none();
        let at_once = outcome.map(|answer| Reply {
            answer,
            bytes: Vec::new(),
        });
        Start { frame, at_once }
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Self::Answer>> {
        if !self.waiting {
            // Nobody asked: the rest of something late. Let it end.
            self.quarantine = Some(now + self.language.quiet());
            return Vec::new();
        }
        self.received.extend_from_slice(bytes);
        vec![match self.language.judge(&self.received) {
            Judgement::More if self.received.len() <= self.language.longest() => return Vec::new(),
            Judgement::More => {
                let reason = format!("no end of the answer in {} bytes", self.received.len());
                self.damaged(now, reason)
            }
            Judgement::Answer(answer) => {
                self.waiting = false;
                let bytes = std::mem::take(&mut self.received);
                Event::Answer(Reply { answer, bytes })
            }
            Judgement::Damaged(reason) => self.damaged(now, reason),
        }]
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.waiting = false;
        self.quarantine = Some(now + self.language.quiet());
        std::mem::take(&mut self.received)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Line, line};
    use proptest::prelude::*;

    const QUIET: Duration = Duration::from_secs(1);

    /// Asks a word; the answer is the same word in upper case.
    #[derive(Default)]
    struct Shout(String);

    impl Language for Shout {
        type Request = &'static str;
        type Answer = String;

        fn quiet(&self) -> Duration {
            QUIET
        }

        fn longest(&self) -> usize {
            20
        }

        fn start(&mut self, word: &'static str) -> (Vec<u8>, Option<String>) {
            self.0 = word.to_uppercase();
            (format!("{word}\n").into_bytes(), (word == "quit").then(String::new))
        }

        fn judge(&self, received: &[u8]) -> Judgement<String> {
            match line(received) {
                Line::More => Judgement::More,
                Line::Whole(text) if text == self.0 => Judgement::Answer(text.to_owned()),
                Line::Whole(text) => Judgement::Damaged(format!("\"{text}\" is not {}", self.0)),
                Line::Damaged(reason) => Judgement::Damaged(reason),
            }
        }
    }

    fn requested(word: &'static str) -> (Lines<Shout>, Instant) {
        let (mut lines, now) = (Lines::<Shout>::default(), Instant::now());
        assert_eq!(lines.ready_at(now), now);
        lines.start(now, word);
        (lines, now)
    }

    fn answers(events: &[Event<Reply<String>>]) -> bool {
        matches!(events, [Event::Answer(_)])
    }

    #[test]
    fn a_late_answer_is_swallowed_and_prolongs_the_silence() {
        let (mut lines, now) = requested("one");
        assert!(lines.handle_input(now, b"ON").is_empty());
        assert_eq!(lines.abandon(now), b"ON");
        assert_eq!(lines.ready_at(now), now + QUIET);
        let later = now + QUIET * 9 / 10;
        assert!(lines.handle_input(later, b"E\n").is_empty());
        assert_eq!(lines.ready_at(later), later + QUIET);
        lines.start(later + QUIET, "one");
        assert!(answers(&lines.handle_input(later + QUIET, b"ONE\n")));
    }

    #[test]
    fn two_answers_at_once_are_none_and_a_second_one_later_is_not_taken_for_the_next() {
        let (mut lines, now) = requested("one");
        assert!(
            matches!(&lines.handle_input(now, b"ONE\nONE\n")[..], [Event::Malformed { frame, .. }] if frame == b"ONE\nONE\n")
        );
        let (mut lines, now) = requested("one");
        assert!(answers(&lines.handle_input(now, b"ONE\n")));
        assert!(lines.handle_input(now, b"ONE\n").is_empty());
        assert_eq!(lines.ready_at(now), now + QUIET);
    }

    #[test]
    fn an_endless_answer_and_a_request_that_nobody_answers() {
        let (mut lines, now) = requested("one");
        assert!(lines.handle_input(now, &[b'O'; 20]).is_empty());
        assert!(
            matches!(&lines.handle_input(now, b"O")[..], [Event::Malformed { reason, .. }] if reason.contains("21 bytes"))
        );
        let start = lines.start(now, "quit");
        assert_eq!(
            (start.frame, start.at_once.unwrap().bytes),
            (b"quit\n".to_vec(), vec![])
        );
    }

    proptest! {
        #[test]
        fn the_pieces_do_not_matter(cuts in proptest::collection::vec(0..8_usize, 0..6)) {
            let bytes = b"ELEVEN\r\n";
            let mut cuts = cuts;
            cuts.extend([0, bytes.len()]);
            cuts.sort_unstable();
            let (mut lines, now) = requested("eleven");
            let events: Vec<_> = cuts.windows(2).flat_map(|cut| lines.handle_input(now, &bytes[cut[0]..cut[1]])).collect();
            prop_assert_eq!(events, [Event::Answer(Reply { answer: "ELEVEN".to_owned(), bytes: bytes.to_vec() })]);
        }

        #[test]
        fn garbage_before_or_after_is_no_answer(garbage in proptest::collection::vec(any::<u8>(), 1..30), before: bool) {
            // Line ends alone are not garbage: some instruments send CR LF, some LF CR.
            prop_assume!(garbage.iter().any(|byte| !b"\r\n".contains(byte)));
            let bytes = if before { [&garbage[..], b"ONE\n"].concat() } else { [b"ONE\n", &garbage[..]].concat() };
            let (mut lines, now) = requested("one");
            prop_assert!(!answers(&lines.handle_input(now, &bytes)));
        }
    }
}
