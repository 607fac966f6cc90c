//! One request at a time, known by its number.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

use crate::{Answer, Flags, Message, Request, Value};

/// How long the line must have been silent after a failure. A spectrum that was given up may still come for as long as
/// its integration lasts; [`Host`] takes that time.
const QUIET: Duration = Duration::from_millis(300);

/// The instrument will answer later.
const DEFERRED: u16 = 255;
/// The request's sum was wrong: the line damaged it, and nothing was refused.
const BAD_CHECKSUM: u16 = 3;

/// The host's side of the line.
#[derive(Debug, Default)]
pub struct Host {
    bytes: Vec<u8>,
    waiting: Option<(Request, u32)>,
    last_number: u32,
    /// The instrument has sent a number back, so all its answers have theirs.
    numbered: bool,
    quarantine: Option<Instant>,
    integration: Duration,
}

impl Conversation for Host {
    type Request = Request;
    type Answer = Answer;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quarantine.filter(|until| *until > now).unwrap_or(now)
    }

    fn start(&mut self, _: Instant, request: Request) -> Start<Answer> {
        self.quarantine = None;
        self.bytes.clear();
        // 0 is what an instrument without numbers sends.
        self.last_number = self.last_number.wrapping_add(1).max(1);
        if let Request::SetIntegration(us) = request {
            self.integration = self.integration.max(Duration::from_micros(u64::from(us)));
        }
        self.waiting = Some((request, self.last_number));
        let flags = if request.is_command() {
            Flags::ACK_REQUEST
        } else {
            Flags::default()
        };
        let message = Message {
            flags,
            error: 0,
            kind: request.kind(),
            regarding: self.last_number,
            checked: true,
            data: request.data(),
        };
        Start::answered(message.encode())
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Answer>> {
        let Some((request, number)) = self.waiting else {
            // Nobody asked: the rest of something late. Let it end.
            self.quarantine = Some(now + QUIET);
            return Vec::new();
        };
        self.bytes.extend_from_slice(bytes);
        let mut events = Vec::new();
        while !self.bytes.is_empty() {
            let (message, length) = match Message::parse(&self.bytes) {
                Ok(None) => break,
                Ok(Some(found)) => found,
                Err(error) => {
                    events.push(self.damaged(now, &error.to_string()));
                    break;
                }
            };
            self.numbered |= message.regarding == number;
            if message.regarding != number && (message.regarding != 0 || self.numbered) {
                self.bytes.drain(..length);
                let late = format!("an answer to request {}, request {number} was asked", message.regarding);
                events.push(Event::Remark(late));
                continue;
            }
            if message.kind != request.kind() {
                let reason = format!("0x{:06X} answers, 0x{:06X} was asked", message.kind, request.kind());
                events.push(self.damaged(now, &reason));
                break;
            }
            if message.error == DEFERRED {
                self.bytes.drain(..length);
                events.push(Event::Remark("the instrument will answer later".to_owned()));
                continue;
            }
            if self.bytes.len() > length {
                events.push(self.damaged(now, "bytes after the end of the answer"));
                break;
            }
            if message.error == BAD_CHECKSUM {
                events.push(self.damaged(now, "the request reached the instrument with a wrong sum"));
                break;
            }
            match Value::read(request, &message) {
                Ok(value) => {
                    self.waiting = None;
                    self.bytes.clear();
                    if let (Request::SetIntegration(us), Value::Done) = (request, &value) {
                        self.integration = Duration::from_micros(u64::from(us));
                    }
                    events.push(Event::Answer(Answer {
                        value,
                        checked: message.checked,
                    }));
                }
                Err(reason) => events.push(self.damaged(now, &reason)),
            }
            break;
        }
        events
    }

    /// A spectrum given up holds the line for its integration time.
    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        let exposing = match self.waiting {
            Some((Request::Spectrum, _)) => self.integration,
            _ => Duration::ZERO,
        };
        self.waiting = None;
        self.quarantine = Some(now + QUIET + exposing);
        std::mem::take(&mut self.bytes)
    }
}

impl Host {
    fn damaged(&mut self, now: Instant, reason: &str) -> Event<Answer> {
        let frame = self.abandon(now);
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

    fn reply(request: Request, regarding: u32, flags: Flags, data: Vec<u8>) -> Vec<u8> {
        let message = Message {
            flags,
            error: 0,
            kind: request.kind(),
            regarding,
            checked: true,
            data,
        };
        message.encode()
    }

    fn spectrum(regarding: u32) -> Vec<u8> {
        let counts = (0..PIXELS as u16)
            .flat_map(|pixel| (pixel * 15).to_le_bytes())
            .collect();
        reply(Request::Spectrum, regarding, Flags::RESPONSE, counts)
    }

    fn values(events: &[Event<Answer>]) -> usize {
        events.iter().filter(|event| matches!(event, Event::Answer(_))).count()
    }

    fn requested(request: Request) -> Host {
        let mut host = Host::default();
        host.start(Instant::now(), request);
        host
    }

    #[test]
    fn split_at_every_byte_it_is_the_same_spectrum() {
        let whole = spectrum(1);
        for cut in 0..=whole.len() {
            let mut host = requested(Request::Spectrum);
            let now = Instant::now();
            let mut events = host.handle_input(now, &whole[..cut]);
            events.extend(host.handle_input(now, &whole[cut..]));
            let [Event::Answer(answer)] = &events[..] else {
                panic!("{cut}: {events:?}")
            };
            let Value::Spectrum(counts) = &answer.value else {
                panic!()
            };
            assert!(answer.checked && counts[1023] == 1023 * 15);
        }
    }

    #[test]
    fn a_request_that_the_line_damaged_was_not_refused() {
        let nack = |error: u16| {
            let message = Message {
                flags: Flags::NACK,
                error,
                kind: Request::Irradiance.kind(),
                regarding: 1,
                checked: true,
                data: Vec::new(),
            };
            requested(Request::Irradiance).handle_input(Instant::now(), &message.encode())
        };
        assert!(matches!(nack(BAD_CHECKSUM)[..], [Event::Malformed { .. }]));
        let [Event::Answer(answer)] = &nack(2)[..] else {
            panic!()
        };
        assert!(matches!(answer.value, Value::Refused { error: 2, .. }));
    }

    #[test]
    fn one_bit_flipped_anywhere_is_no_value() {
        for (request, whole) in [
            (Request::Spectrum, spectrum(1)),
            (
                Request::Serial,
                reply(Request::Serial, 1, Flags::RESPONSE, b"S01234".to_vec()),
            ),
            (Request::Abort, reply(Request::Abort, 1, Flags::ACK, vec![])),
        ] {
            for bit in 0..8 * whole.len() {
                let mut flipped = whole.clone();
                flipped[bit / 8] ^= 1 << (bit % 8);
                let events = requested(request).handle_input(Instant::now(), &flipped);
                assert_eq!(values(&events), 0, "bit {bit}: {events:?}");
            }
        }
    }

    #[test]
    fn garbage_before_or_after_is_no_value() {
        let whole = spectrum(1);
        for garbage in [&b"\0"[..], b"\xC1", b"\xC0\xC1", b"noise"] {
            let before = [garbage, &whole].concat();
            let after = [&whole, garbage].concat();
            for bytes in [before, after] {
                let now = Instant::now();
                let mut host = requested(Request::Spectrum);
                assert_eq!(values(&host.handle_input(now, &bytes)), 0);
                assert_eq!(host.ready_at(now), now + QUIET, "and the line is left to fall silent");
            }
        }
    }

    #[test]
    fn late_answers_are_told_by_their_number() {
        let mut host = requested(Request::Serial);
        let now = Instant::now();
        host.abandon(now);
        host.start(now, Request::Serial);
        let old = reply(Request::Serial, 1, Flags::RESPONSE, b"OLD".to_vec());
        let new = reply(Request::Serial, 2, Flags::RESPONSE, b"NEW".to_vec());
        let events = host.handle_input(now, &[old, new].concat());
        assert!(matches!(&events[0], Event::Remark(_)), "{events:?}");
        let expected = Answer {
            value: Value::Text("NEW".into()),
            checked: true,
        };
        assert_eq!(events[1], Event::Answer(expected));
        // Once numbers have come back, an answer without one is none.
        host.start(now, Request::Serial);
        let without = reply(Request::Serial, 0, Flags::RESPONSE, b"OLD".to_vec());
        assert_eq!(values(&host.handle_input(now, &without)), 0);
    }

    #[test]
    fn refusals_and_deferrals_are_no_values() {
        let refused = Message {
            flags: Flags::NACK,
            error: 2,
            kind: Request::Saturation.kind(),
            regarding: 1,
            checked: true,
            data: vec![],
        };
        let now = Instant::now();
        let events = requested(Request::Saturation).handle_input(now, &refused.encode());
        let [
            Event::Answer(Answer {
                value: Value::Refused { error: 2, reason },
                ..
            }),
        ] = &events[..]
        else {
            panic!("{events:?}")
        };
        assert_eq!(*reason, "unknown message type");
        let deferred = Message {
            error: DEFERRED,
            ..refused
        };
        let mut host = requested(Request::Saturation);
        assert_eq!(values(&host.handle_input(now, &deferred.encode())), 0);
        let answer = reply(Request::Saturation, 1, Flags::RESPONSE, vec![0xFF, 0x3F]);
        let expected = Answer {
            value: Value::Count(16_383),
            checked: true,
        };
        assert_eq!(host.handle_input(now, &answer), [Event::Answer(expected)]);
    }

    #[test]
    fn a_spectrum_given_up_holds_the_line_for_its_exposure() {
        let now = Instant::now();
        let mut host = requested(Request::SetIntegration(2_000_000));
        let done = reply(Request::SetIntegration(0), 1, Flags::ACK, vec![]);
        assert_eq!(values(&host.handle_input(now, &done)), 1);
        host.start(now, Request::Spectrum);
        host.abandon(now);
        assert_eq!(host.ready_at(now), now + Duration::from_secs(2) + QUIET);
    }

    proptest! {
        #[test]
        fn noise_is_never_a_value(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
            let mut host = requested(Request::Serial);
            prop_assert_eq!(values(&host.handle_input(Instant::now(), &bytes)), 0);
        }
    }
}
