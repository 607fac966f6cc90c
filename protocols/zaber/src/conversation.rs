//! One request at a time, and only its own answer.

use std::collections::BTreeSet;
use std::time::Instant;

use isolux_conversation::{Conversation, Event, Start};

use crate::{Command, Framer, Message, Reply};

/// The host's side of a line.
///
/// Ids run over all hundred values, so a late answer would have to be late by a hundred requests to be taken for
/// another. The true answer comes as well then, and [`surplus`](Conversation::surplus) counts it. Alerts, and replies
/// that nobody waits for (late, or from another address), are remarks.
///
/// A device sends checksums once it has accepted [`CHECKSUMS_ON`]; from then on an answer of that device without one is
/// damaged.
#[derive(Debug, Default)]
pub struct Host {
    framer: Framer,
    waiting: Option<Command>,
    /// The request that was answered last.
    answered: Option<Command>,
    surplus: u64,
    next_id: u8,
    checked_devices: BTreeSet<u8>,
}

/// Tells a device to end its replies with a checksum.
pub const CHECKSUMS_ON: &str = "set comm.checksum 1";

impl Conversation for Host {
    type Request = Command;
    type Answer = Reply;

    fn start(&mut self, _: Instant, command: Command) -> Start<Reply> {
        let command = command.with_id(self.next_id);
        self.next_id = (self.next_id + 1) % 100;
        let frame = command.encode();
        self.waiting = Some(command);
        Start::answered(frame)
    }

    fn handle_input(&mut self, _: Instant, bytes: &[u8]) -> Vec<Event<Reply>> {
        let mut events = Vec::new();
        for byte in bytes {
            match self.framer.push(*byte) {
                None | Some(Ok(Message::Info(_))) => {}
                Some(Ok(Message::Alert(alert))) => events.push(Event::Remark(format!("alert: {alert:?}"))),
                Some(Ok(Message::Reply(reply))) => events.push(self.sort(reply)),
                // Noise that nobody waits for is noise.
                Some(Err(damaged)) => {
                    if self.waiting.take().is_some() {
                        let (reason, frame) = (damaged.reason, damaged.line);
                        events.push(Event::Malformed { reason, frame });
                    }
                }
            }
        }
        events
    }

    /// Second answers to a request: one of the two, perhaps the one that was believed, is an old one.
    fn surplus(&self) -> u64 {
        self.surplus
    }

    fn abandon(&mut self, _: Instant) -> Vec<u8> {
        self.waiting = None;
        let pending = self.framer.pending().to_vec();
        self.framer.clear();
        pending
    }
}

impl Host {
    fn count_surplus(&mut self, reply: &Reply) {
        let again = self
            .answered
            .as_ref()
            .is_some_and(|command| command.id() == reply.id && command.axis() == reply.axis);
        self.surplus += u64::from(again);
    }

    fn stray(&mut self, reply: &Reply) -> Event<Reply> {
        self.count_surplus(reply);
        Event::Remark(format!("late reply dropped: {reply:?}"))
    }

    fn sort(&mut self, reply: Reply) -> Event<Reply> {
        let Some(command) = &self.waiting else {
            return self.stray(&reply);
        };
        let ours = reply.id == command.id()
            && (command.device() == 0 || reply.device == command.device())
            && reply.axis == command.axis();
        if !ours {
            return self.stray(&reply);
        }
        self.answered = Some(command.clone());
        if command.text() == CHECKSUMS_ON && reply.outcome.is_ok() {
            self.checked_devices.insert(reply.device);
            self.waiting = None;
            return Event::Answer(reply);
        }
        self.waiting = None;
        if reply.checked || !self.checked_devices.contains(&reply.device) {
            Event::Answer(reply)
        } else {
            Event::Malformed {
                reason: "the answer has lost its checksum".into(),
                frame: reply.encode(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Status;
    use proptest::prelude::*;

    fn start(host: &mut Host, command: Command) -> Vec<u8> {
        host.start(Instant::now(), command).frame
    }

    fn hear(host: &mut Host, bytes: &[u8]) -> Vec<Event<Reply>> {
        host.handle_input(Instant::now(), bytes)
    }

    fn get_pos() -> Command {
        Command::new(1, 1, "get pos").unwrap()
    }

    fn answer(id: u8, data: &str) -> Vec<u8> {
        let outcome = Ok(data.to_owned());
        Reply {
            device: 1,
            axis: 1,
            id: Some(id),
            outcome,
            status: Status::Idle,
            flag: None,
            checked: true,
        }
        .encode()
    }

    #[test]
    fn a_late_answer_never_answers_the_next_request() {
        let mut talk = Host::default();
        assert_eq!(start(&mut talk, get_pos()), b"/1 1 0 get pos:5C\n");
        assert_eq!(hear(&mut talk, &answer(0, "5")[..10]), []);
        assert_eq!(talk.abandon(Instant::now()), &answer(0, "5")[..10]);
        assert!(start(&mut talk, get_pos()).starts_with(b"/1 1 1 "));
        assert!(matches!(hear(&mut talk, &answer(0, "5"))[..], [Event::Remark(_)]));
        let events = hear(&mut talk, &answer(1, "6"));
        assert!(matches!(&events[..], [Event::Answer(reply)] if reply.outcome == Ok("6".into())));
        assert!(
            matches!(hear(&mut talk, &answer(1, "6"))[..], [Event::Remark(_)]),
            "an echo answers nothing"
        );
        assert_eq!(
            talk.surplus(),
            1,
            "and is counted; the late answer to a request that was given up is not"
        );
    }

    /// A conversation with a device that was told to send checksums under id 0.
    fn strict() -> Host {
        let mut talk = Host::default();
        start(&mut talk, Command::new(1, 0, CHECKSUMS_ON).unwrap());
        assert!(matches!(
            hear(&mut talk, b"@01 0 00 OK IDLE -- 0\r\n")[..],
            [Event::Answer(_)]
        ));
        talk
    }

    #[test]
    fn an_answer_that_lost_its_check_is_damaged() {
        let mut talk = Host::default();
        start(&mut talk, get_pos());
        assert!(
            matches!(hear(&mut talk, b"@01 1 00 OK IDLE -- 5\r\n")[..], [Event::Answer(_)]),
            "not told yet"
        );
        let mut talk = strict();
        start(&mut talk, get_pos());
        assert!(matches!(
            hear(&mut talk, b"@01 1 01 OK IDLE -- 5\r\n")[..],
            [Event::Malformed { .. }]
        ));
    }

    #[test]
    fn alerts_and_information_pass_by() {
        let mut talk = Host::default();
        start(&mut talk, get_pos());
        let mut bytes = b"!01 1 IDLE FS\r\n#01 0 hello\r\n".to_vec();
        bytes.extend(answer(0, "7"));
        assert!(matches!(
            hear(&mut talk, &bytes)[..],
            [Event::Remark(_), Event::Answer(_)]
        ));
    }

    proptest! {
        #[test]
        fn the_pieces_do_not_matter(cuts in proptest::collection::vec(1..8_usize, 1..60), value in any::<i32>()) {
            let mut whole = Host::default();
            start(&mut whole, get_pos());
            let bytes = [b"\xff garbage\r\n".as_slice(), &answer(0, &value.to_string())].concat();
            let expected = hear(&mut whole, &bytes);
            let mut pieces = Host::default();
            start(&mut pieces, get_pos());
            let mut events = Vec::new();
            let (mut rest, mut cuts) = (&bytes[..], cuts.into_iter().cycle());
            while !rest.is_empty() {
                let (piece, after) = rest.split_at(cuts.next().unwrap_or(1).min(rest.len()));
                events.extend(hear(&mut pieces, piece));
                rest = after;
            }
            prop_assert_eq!(events, expected);
        }

        #[test]
        fn every_damaged_answer_is_refused(value in any::<i32>(), at in 0..40_usize, byte in any::<u8>()) {
            let mut bytes = answer(1, &value.to_string());
            let at = at % (bytes.len() - 2);
            prop_assume!(bytes[at] != byte && !(bytes[at].eq_ignore_ascii_case(&byte)));
            bytes[at] = byte;
            let mut talk = strict();
            start(&mut talk, get_pos());
            for event in hear(&mut talk, &bytes) {
                // A leading zero for a space may still spell the same answer; nothing may spell another one.
                if let Event::Answer(reply) = event {
                    prop_assert_eq!(reply.outcome, Ok(value.to_string()));
                }
            }
        }
    }
}
