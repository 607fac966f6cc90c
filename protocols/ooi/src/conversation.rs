//! One request at a time, and silence after a failure.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

use crate::{Answer, Endpoint, Frame, Framer, Request};

/// How long the line must have been silent after a failed short request. A spectrum that was given up may still come
/// for as long as its integration lasts; [`Host`] takes that time.
const QUIET: Duration = Duration::from_millis(300);

/// The host's side of the line.
#[derive(Debug, Default)]
pub struct Host {
    framer: Framer,
    waiting: Option<Request>,
    quarantine: Option<Instant>,
    /// The integration time that was set.
    integration: Duration,
    /// The longest under which an exposure may still be running: the instrument ends the one it is at.
    exposing: Duration,
}

impl Conversation for Host {
    type Request = Request;
    /// `None` for a request that nobody answers.
    type Answer = Option<Answer>;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quarantine.filter(|until| *until > now).unwrap_or(now)
    }

    fn start(&mut self, _: Instant, request: Request) -> Start<Self::Answer> {
        self.quarantine = None;
        self.framer.clear();
        if let Request::IntegrationTime(us) = request {
            let time = Duration::from_micros(u64::from(us));
            self.exposing = self.integration.max(time);
            self.integration = time;
        }
        let answered = request.is_answered();
        self.waiting = answered.then_some(request);
        let frame = Frame {
            endpoint: Endpoint::Command,
            payload: request.encode(),
        };
        Start {
            frame: frame.encode(),
            at_once: (!answered).then_some(None),
        }
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Self::Answer>> {
        self.heard(now, bytes).into_iter().collect()
    }

    /// A spectrum given up holds the line for its integration time.
    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        let exposing = if self.waiting == Some(Request::Spectrum) {
            self.integration
        } else {
            Duration::ZERO
        };
        self.waiting = None;
        self.quarantine = Some(now + QUIET + exposing);
        let pending = self.framer.pending().to_vec();
        self.framer.clear();
        pending
    }
}

type Heard = Event<<Host as Conversation>::Answer>;

impl Host {
    fn heard(&mut self, now: Instant, bytes: &[u8]) -> Option<Heard> {
        let Some(request) = self.waiting else {
            // Nobody asked: the rest of something late. Let it end.
            self.quarantine = Some(now + QUIET);
            return None;
        };
        self.framer.push(bytes);
        let frame = match self.framer.next_frame() {
            Ok(Some(frame)) => frame,
            Ok(None) => return None,
            Err(error) => return Some(self.damaged(now, &error.to_string(), &[])),
        };
        let expected = if request == Request::Spectrum {
            Endpoint::Spectrum
        } else {
            Endpoint::Control
        };
        if frame.endpoint != expected {
            return Some(self.damaged(
                now,
                &format!("{:?} endpoint speaks, {expected:?} was asked", frame.endpoint),
                &frame.payload,
            ));
        }
        if !self.framer.pending().is_empty() {
            return Some(self.damaged(now, "bytes after the end of the answer", &frame.payload));
        }
        match Answer::parse(request, &frame.payload) {
            Ok(answer) => {
                self.waiting = None;
                if request == Request::Spectrum {
                    self.exposing = self.integration;
                }
                Some(Event::Answer(Some(answer)))
            }
            Err(error) => Some(self.damaged(now, &error.reason, &frame.payload)),
        }
    }

    fn damaged(&mut self, now: Instant, reason: &str, payload: &[u8]) -> Heard {
        let pending = self.framer.pending().to_vec();
        // What was damaged has arrived: nothing is exposing any more.
        self.waiting = None;
        self.abandon(now);
        let frame = if payload.is_empty() { pending } else { payload.to_vec() };
        Event::Malformed {
            reason: reason.to_owned(),
            frame,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PIXELS;
    use proptest::prelude::*;

    fn start(host: &mut Host, request: Request) -> Start<Option<Answer>> {
        host.start(Instant::now(), request)
    }

    fn hear(host: &mut Host, now: Instant, bytes: &[u8]) -> Option<Heard> {
        let mut events = host.handle_input(now, bytes);
        assert!(events.len() < 2, "{events:?}");
        events.pop()
    }

    fn control(payload: &[u8]) -> Vec<u8> {
        Frame {
            endpoint: Endpoint::Control,
            payload: payload.to_vec(),
        }
        .encode()
    }

    fn spectrum(counts: u16) -> Vec<u8> {
        let mut payload: Vec<u8> = std::iter::repeat_n(counts.to_le_bytes(), PIXELS).flatten().collect();
        payload.push(0x69);
        Frame {
            endpoint: Endpoint::Spectrum,
            payload,
        }
        .encode()
    }

    #[test]
    fn a_late_spectrum_is_swallowed() {
        let now = Instant::now();
        let mut talk = Host::default();
        assert_eq!(
            start(&mut talk, Request::IntegrationTime(2_000_000)),
            Start {
                frame: b"\x01\x05\x00\x02\x80\x84\x1e\x00".to_vec(),
                at_once: Some(None)
            }
        );
        start(&mut talk, Request::Spectrum);
        assert_eq!(hear(&mut talk, now, &spectrum(1)[..1000]), None);
        assert_eq!(talk.abandon(now).len(), 1000);
        assert_eq!(
            talk.ready_at(now),
            now + Duration::from_secs(2) + QUIET,
            "as long as the exposure may last"
        );
        let later = now + Duration::from_secs(2);
        assert_eq!(hear(&mut talk, later, &spectrum(1)[1000..]), None);
        assert_eq!(talk.ready_at(later), later + QUIET);
        start(&mut talk, Request::Spectrum);
        assert_eq!(
            hear(&mut talk, later, &spectrum(7)),
            Some(Event::Answer(Some(Answer::Spectrum(vec![7; PIXELS]))))
        );
    }

    #[test]
    fn the_wrong_answer_is_none() {
        let now = Instant::now();
        for bytes in [
            control(&[5; 17]),
            spectrum(1),
            control(&[]),
            vec![0x99, 0, 0],
            vec![0x81, 0xFF, 0xFF],
            [control(&[4, 1, 2]), control(&[4, 1, 2])].concat(),
        ] {
            let mut talk = Host::default();
            start(&mut talk, Request::Register(4));
            assert!(matches!(hear(&mut talk, now, &bytes), Some(Event::Malformed { .. })));
            assert_eq!(talk.ready_at(now), now + QUIET);
        }
    }

    #[test]
    fn split_at_every_byte_it_is_the_same_and_with_garbage_around_it_is_nothing() {
        let now = Instant::now();
        let whole = spectrum(7);
        let ask = |pieces: &[&[u8]]| {
            let mut host = Host::default();
            host.start(now, Request::Spectrum);
            let events = pieces.iter().flat_map(|piece| host.handle_input(now, piece));
            events.filter(|event| matches!(event, Event::Answer(_))).count()
        };
        for cut in 0..=whole.len() {
            assert_eq!(ask(&[&whole[..cut], &whole[cut..]]), 1, "{cut}");
        }
        for garbage in [&b"\0"[..], b"\x82", b"\x81\0\0", b"noise"] {
            assert_eq!(ask(&[garbage, &whole]), 0);
            assert_eq!(ask(&[&[&whole, garbage].concat()]), 0);
        }
    }

    proptest! {
        #[test]
        fn the_pieces_do_not_matter(cuts in proptest::collection::vec(1..600_usize, 1..40), counts: u16) {
            let now = Instant::now();
            let mut talk = Host::default();
            start(&mut talk, Request::Spectrum);
            let bytes = spectrum(counts);
            let (mut rest, mut cuts, mut event) = (&bytes[..], cuts.into_iter().cycle(), None);
            while !rest.is_empty() {
                prop_assert_eq!(&event, &None);
                let (piece, after) = rest.split_at(cuts.next().unwrap_or(1).min(rest.len()));
                event = hear(&mut talk, now, piece);
                rest = after;
            }
            prop_assert_eq!(event, Some(Event::Answer(Some(Answer::Spectrum(vec![counts; PIXELS])))));
        }

        #[test]
        fn noise_is_no_spectrum(bytes in proptest::collection::vec(any::<u8>(), 0..5000)) {
            let mut talk = Host::default();
            start(&mut talk, Request::Spectrum);
            let event = hear(&mut talk, Instant::now(), &bytes);
            prop_assert!(!matches!(event, Some(Event::Answer(_))));
        }
    }
}
