//! MBAP: transaction, protocol, length, unit, PDU, on TCP.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

use crate::reply::{Progress, outcome, progress};
use crate::{Reply, Request};

/// Transaction, protocol and length (TCP 3.1.3); unit and PDU follow and are counted by the length.
const HEADER: usize = 6;

/// Unit and function at least, unit and 253 bytes of PDU at most (AP 4.1).
const LENGTHS: std::ops::RangeInclusive<usize> = 2..=254;

/// The client's side of a Modbus TCP connection.
///
/// The transaction number decides: a late answer is dropped with a remark, and the line is ready at once. A stream that
/// loses its frames (a header that is none, or an answer torn off at a deadline) is thrown away until it has been
/// silent for a while, because only silence tells where the next frame begins. TCP itself guards the bytes; MBAP has no
/// check.
#[derive(Debug)]
pub struct Mbap {
    silence: Duration,
    transaction: u16,
    waiting: Option<Request>,
    /// The number that was answered last.
    answered: Option<u16>,
    received: Vec<u8>,
    quiet_until: Option<Instant>,
    /// Until then what comes is the rest of a broken frame.
    in_step: bool,
    surplus: u64,
}

impl Mbap {
    /// A connection on which the rest of a torn answer has arrived `silence` later.
    pub fn new(silence: Duration) -> Self {
        Self {
            silence,
            transaction: 0,
            waiting: None,
            answered: None,
            received: Vec::new(),
            quiet_until: None,
            in_step: true,
            surplus: 0,
        }
    }

    /// The next whole frame of what was received, or why there is none and never will be.
    fn next_frame(&mut self) -> Result<Option<Vec<u8>>, String> {
        let Some(header) = self.received.first_chunk::<HEADER>() else {
            return Ok(None);
        };
        let (protocol, length) = (
            u16::from_be_bytes([header[2], header[3]]),
            usize::from(u16::from_be_bytes([header[4], header[5]])),
        );
        if protocol != 0 {
            return Err(format!("protocol {protocol} in the header, expected 0"));
        }
        if !LENGTHS.contains(&length) {
            return Err(format!("length {length} in the header, expected 2 to 254"));
        }
        if self.received.len() < HEADER + length {
            return Ok(None);
        }
        Ok(Some(self.received.drain(..HEADER + length).collect()))
    }

    fn take(&mut self, frame: Vec<u8>) -> Event<Reply> {
        let number = u16::from_be_bytes([frame[0], frame[1]]);
        let Some(request) = self.waiting.take_if(|_| number == self.transaction) else {
            if self.answered == Some(number) {
                self.surplus += 1;
            }
            return Event::Remark(format!("an answer to transaction {number}, which is over, was dropped"));
        };
        let (unit, pdu) = (frame[HEADER], &frame[HEADER + 1..]);
        self.answered = Some(number);
        let reason = match progress(&request, pdu) {
            _ if unit != request.unit() => format!("unit {unit} answers, unit {} was asked", request.unit()),
            Progress::Whole(length) if length == pdu.len() => {
                let outcome = outcome(&request, pdu);
                return Event::Answer(Reply { outcome, frame });
            }
            Progress::Wrong(reason) => reason,
            Progress::Whole(_) | Progress::Part => format!("{} bytes are no answer to this request", pdu.len()),
        };
        Event::Malformed { reason, frame }
    }

    /// What was received cannot be cut into frames any more.
    fn lose_step(&mut self, now: Instant) -> Vec<u8> {
        self.waiting = None;
        self.in_step = false;
        self.quiet_until = Some(now + self.silence);
        std::mem::take(&mut self.received)
    }
}

impl Conversation for Mbap {
    type Request = Request;
    type Answer = Reply;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quiet_until.filter(|until| *until > now).unwrap_or(now)
    }

    fn start(&mut self, _: Instant, request: Request) -> Start<Reply> {
        self.transaction = self.transaction.wrapping_add(1);
        self.in_step = true;
        let pdu = request.pdu();
        let mut frame = Vec::with_capacity(HEADER + 1 + pdu.len());
        for word in [self.transaction, 0, 1 + pdu.len() as u16] {
            frame.extend(word.to_be_bytes());
        }
        frame.push(request.unit());
        frame.extend(pdu);
        self.waiting = Some(request);
        Start::answered(frame)
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Reply>> {
        if !self.in_step {
            self.quiet_until = Some(now + self.silence);
            return Vec::new();
        }
        self.received.extend_from_slice(bytes);
        let mut events = Vec::new();
        loop {
            match self.next_frame() {
                Ok(Some(frame)) => events.push(self.take(frame)),
                Ok(None) => return events,
                Err(reason) => {
                    let requested = self.waiting.is_some();
                    let frame = self.lose_step(now);
                    events.push(if requested {
                        Event::Malformed { reason, frame }
                    } else {
                        Event::Remark(format!("{reason}: the stream is thrown away until it is silent"))
                    });
                    return events;
                }
            }
        }
    }

    fn surplus(&self) -> u64 {
        self.surplus
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.waiting = None;
        if self.received.is_empty() {
            Vec::new()
        } else {
            self.lose_step(now)
        }
    }
}
