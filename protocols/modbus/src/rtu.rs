//! RTU: unit, PDU, CRC, silence.

use std::time::{Duration, Instant};

use isolux_conversation::{Conversation, Event, Start};

use crate::reply::{Progress, outcome, progress};
use crate::{Reply, Request};

const ECHO: &str = "what was sent came back: switch off the echo of the adapter or bridge";

/// The check of a frame: CRC-16 with the polynomial A001h (reflected), from FFFFh on, sent low byte first (SL 6.2.2).
pub const fn crc(bytes: &[u8]) -> u16 {
    let mut check = 0xFFFF_u16;
    let mut at = 0;
    while at < bytes.len() {
        check ^= bytes[at] as u16;
        let mut bit = 0;
        while bit < 8 {
            check = if check & 1 == 1 {
                check >> 1 ^ 0xA001
            } else {
                check >> 1
            };
            bit += 1;
        }
        at += 1;
    }
    check
}

/// The silence that separates frames: 3.5 characters of 11 bits; above 19200 baud 1.75 ms (SL 2.5.1.1).
pub fn silent_interval(baud: u32) -> Duration {
    if baud > 19_200 {
        Duration::from_micros(1750)
    } else {
        Duration::from_secs_f64(3.5 * 11.0 / f64::from(baud.max(1)))
    }
}

/// The client's side of an RTU line.
///
/// The language has no request numbers: an answer that comes after its deadline fits the next request just as well.
/// After a timeout or a damaged answer the line must therefore be silent for longer than the slowest answer, and each
/// byte that comes meanwhile makes the silence begin anew. An answer must begin with its first byte: nothing before it
/// is skipped.
///
/// The silence of 1.5 characters *within* a frame (SL 2.5.1.1) is not watched: operating systems and bridges do not
/// keep it. The length that the request implies and the CRC bound the frame instead.
#[derive(Debug)]
pub struct Rtu {
    silence: Duration,
    quarantine: Duration,
    waiting: Option<Waiting>,
    received: Vec<u8>,
    quiet_until: Option<Instant>,
}

#[derive(Debug)]
struct Waiting {
    request: Request,
    sent: Vec<u8>,
}

impl Rtu {
    /// A line whose frames are `silence` apart, and on which no answer is ever complete later than `slowest_answer`
    /// after its request was sent.
    pub fn new(silence: Duration, slowest_answer: Duration) -> Self {
        Self {
            silence,
            quarantine: slowest_answer + silence,
            waiting: None,
            received: Vec::new(),
            quiet_until: None,
        }
    }

    /// What the bytes so far are, if that is known.
    fn judge(&self, waiting: &Waiting) -> Option<Result<Reply, String>> {
        let [unit, pdu @ ..] = self.received.as_slice() else {
            return None;
        };
        if *unit != waiting.request.unit() {
            let requested = waiting.request.unit();
            return Some(Err(format!(
                "the first byte is {unit:02X}h, unit {requested:02X}h was asked"
            )));
        }
        let length = match progress(&waiting.request, pdu) {
            Progress::Part => return None,
            Progress::Wrong(reason) => return Some(Err(reason)),
            Progress::Whole(length) => 1 + length,
        };
        let frame = self.received.get(..length + 2)?;
        if self.received.len() > frame.len() {
            return Some(Err("bytes after the end of the answer".to_owned()));
        }
        let (body, check) = frame.split_at(length);
        let (stated, computed) = (u16::from_le_bytes([check[0], check[1]]), crc(body));
        if stated != computed {
            return Some(Err(format!("CRC {stated:04X}h, computed {computed:04X}h")));
        }
        Some(Ok(Reply {
            outcome: outcome(&waiting.request, &body[1..]),
            frame: frame.to_vec(),
        }))
    }
}

impl Conversation for Rtu {
    type Request = Request;
    type Answer = Reply;

    fn ready_at(&self, now: Instant) -> Instant {
        self.quiet_until.filter(|until| *until > now).unwrap_or(now)
    }

    fn start(&mut self, _: Instant, request: Request) -> Start<Reply> {
        let mut sent = vec![request.unit()];
        sent.extend(request.pdu());
        sent.extend(crc(&sent).to_le_bytes());
        self.received.clear();
        self.waiting = Some(Waiting {
            request,
            sent: sent.clone(),
        });
        Start::answered(sent)
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Reply>> {
        let Some(waiting) = self.waiting.take() else {
            // Nobody asked: the rest of something late. Let it end.
            self.quiet_until = Some(now + self.quarantine);
            return Vec::new();
        };
        self.received.extend_from_slice(bytes);
        match self.judge(&waiting) {
            None => {
                self.waiting = Some(waiting);
                Vec::new()
            }
            Some(Ok(reply)) => {
                self.received.clear();
                self.quiet_until = Some(now + self.silence);
                vec![Event::Answer(reply)]
            }
            Some(Err(reason)) => {
                let echo = self.received.len() > 1 && waiting.sent.starts_with(&self.received);
                let reason = if echo { ECHO.to_owned() } else { reason };
                let frame = self.abandon(now);
                vec![Event::Malformed { reason, frame }]
            }
        }
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.waiting = None;
        self.quiet_until = Some(now + self.quarantine);
        std::mem::take(&mut self.received)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_silence_follows_the_baud_rate() {
        // 3.5 × 11 bits: 4.01 ms at 9600, 2.005 ms at 19200; fixed above (SL 2.5.1.1).
        for (baud, micros) in [(9600, 4010), (19_200, 2005), (38_400, 1750), (115_200, 1750)] {
            assert_eq!(silent_interval(baud).as_micros(), micros, "{baud}");
        }
        assert_eq!(silent_interval(1200).as_micros(), 32_083);
    }

    #[test]
    fn the_check_is_the_published_one() {
        // "123456789" is the usual check string of CRC-16/MODBUS: 4B37h.
        assert_eq!(crc(b"123456789"), 0x4B37);
    }
}
