//! One request at a time, and silence after a failure.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

use crate::{Answer, Request, STX};

/// How long the line must have been silent after a failure before it is used again. The meter answers within some
/// 100 ms of the request, at most a conversion (500 ms) later.
pub const QUIET: Duration = Duration::from_secs(1);

/// The host's side of the line.
///
/// The language has no request numbers, so after a timeout or a damaged answer anything that arrives might be the
/// answer that was given up: it is thrown away, and each byte of it makes the silence begin anew.
#[derive(Debug, Default)]
pub struct Host {
    waiting: Option<(u8, u8)>,
    frame: Vec<u8>,
    quarantine: Option<Instant>,
}

impl Conversation for Host {
    type Request = Request;
    /// The answer and its bytes; `None` for a request that nobody answers.
    type Answer = Option<(Answer, Vec<u8>)>;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quarantine.filter(|until| *until > now).unwrap_or(now)
    }

    fn start(&mut self, _: Instant, request: Request) -> Start<Self::Answer> {
        self.quarantine = None;
        self.frame.clear();
        self.waiting = request.answered_as();
        Start {
            frame: request.encode(),
            at_once: self.waiting.is_none().then_some(None),
        }
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Self::Answer>> {
        self.heard(now, bytes).into_iter().collect()
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.waiting = None;
        self.quarantine = Some(now + QUIET);
        std::mem::take(&mut self.frame)
    }
}

type Heard = Event<<Host as Conversation>::Answer>;

impl Host {
    fn heard(&mut self, now: Instant, bytes: &[u8]) -> Option<Heard> {
        let Some(expected) = self.waiting else {
            // Nobody asked: the rest of something late. Let it end.
            self.quarantine = Some(now + QUIET);
            return None;
        };
        self.frame.extend_from_slice(bytes);
        let end = self.frame.iter().position(|byte| *byte == b'\n');
        let Some(end) = end else {
            return (self.frame.len() > 64).then(|| self.damaged(now, "no end of frame in 64 bytes"));
        };
        // Line noise before STX is no part of the frame: the check would not notice it there.
        let start = self.frame[..end].iter().rposition(|byte| *byte == STX).unwrap_or(0);
        let frame = self.frame[start..=end].to_vec();
        if end + 1 < self.frame.len() {
            return Some(self.damaged(now, "bytes after the end of the answer"));
        }
        match Answer::parse(&frame) {
            Ok(answer) if answer.to() == expected => {
                self.waiting = None;
                self.frame.clear();
                Some(Event::Answer(Some((answer, frame))))
            }
            Ok(answer) => {
                let ((head, command), (asked_head, requested)) = (answer.to(), expected);
                let reason = format!("head {head} answers command {command}, head {asked_head} was asked {requested}");
                Some(self.damaged(now, &reason))
            }
            Err(error) => Some(self.damaged(now, &error.reason)),
        }
    }

    fn damaged(&mut self, now: Instant, reason: &str) -> Heard {
        Event::Malformed {
            reason: reason.to_owned(),
            frame: self.abandon(now),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Range, frame};
    use proptest::prelude::*;

    fn start(host: &mut Host, request: Request) -> Start<Option<(Answer, Vec<u8>)>> {
        host.start(Instant::now(), request)
    }

    fn hear(host: &mut Host, now: Instant, bytes: &[u8]) -> Option<Heard> {
        let mut events = host.handle_input(now, bytes);
        assert!(events.len() < 2, "{events:?}");
        events.pop()
    }

    const READ: Request = Request::Read {
        head: 0,
        range: Range::Auto,
        hold: false,
    };

    fn answer(digits: u16) -> Vec<u8> {
        frame(format!("00100 20+{digits:04}2            ").as_bytes())
    }

    #[test]
    fn a_late_answer_is_swallowed_and_prolongs_the_silence() {
        let now = Instant::now();
        let mut talk = Host::default();
        assert_eq!(talk.ready_at(now), now);
        start(&mut talk, READ);
        assert_eq!(hear(&mut talk, now, &answer(1)[..5]), None);
        assert_eq!(talk.abandon(now), &answer(1)[..5]);
        assert_eq!(talk.ready_at(now), now + QUIET);
        let later = now + Duration::from_millis(900);
        assert_eq!(hear(&mut talk, later, &answer(1)[5..]), None);
        assert_eq!(talk.ready_at(later), later + QUIET);
        start(&mut talk, READ);
        assert!(matches!(
            hear(&mut talk, later + QUIET, &answer(2)),
            Some(Event::Answer(..))
        ));
    }

    #[test]
    fn the_answer_of_another_head_or_command_is_none() {
        let now = Instant::now();
        for body in ["01100 20+34002            ", "00110 20+34002            ", "0054    "] {
            let mut talk = Host::default();
            start(&mut talk, READ);
            assert!(
                matches!(
                    hear(&mut talk, now, &frame(body.as_bytes())),
                    Some(Event::Malformed { .. })
                ),
                "{body}"
            );
            assert_eq!(talk.ready_at(now), now + QUIET);
        }
        let mut talk = Host::default();
        let sent = start(&mut talk, Request::Hold(false));
        assert_eq!(sent.at_once, Some(None), "nobody answers a broadcast");
    }

    #[test]
    fn two_answers_at_once_are_none() {
        let now = Instant::now();
        let mut talk = Host::default();
        start(&mut talk, READ);
        let both = [answer(1), answer(2)].concat();
        assert!(matches!(hear(&mut talk, now, &both), Some(Event::Malformed { .. })));
    }

    proptest! {
        #[test]
        fn the_pieces_do_not_matter(cut in 1..32_usize, digits in 0..10_000_u16) {
            let now = Instant::now();
            let mut talk = Host::default();
            start(&mut talk, READ);
            let bytes = answer(digits);
            let first = hear(&mut talk, now, &bytes[..cut]);
            let second = if cut < 32 { hear(&mut talk, now, &bytes[cut..]) } else { None };
            prop_assert!(matches!(first.or(second), Some(Event::Answer(..))));
        }

        #[test]
        fn noise_is_never_an_answer(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let mut talk = Host::default();
            start(&mut talk, READ);
            let event = hear(&mut talk, Instant::now(), &bytes);
            prop_assert!(!matches!(event, Some(Event::Answer(..))));
        }
    }
}
