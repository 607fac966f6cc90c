//! What happens to replies on a bad link, and the words for it while the twins serve.

use std::str::FromStr;

use isolux_darkroom::noise::{Noise, Stream};
use isolux_darkroom::{Darkroom, Fault, FaultKind, Instrument};

/// The faults of one instrument's link.
#[derive(Debug, Clone)]
pub struct LinkFaults {
    faults: Vec<(Fault, bool)>,
    noise: Noise,
    replies: u64,
}

/// What becomes of one reply.
#[derive(Debug, Clone, PartialEq)]
pub enum Delivery {
    /// It is sent, `delay_s` later than it should be.
    Sent {
        /// The bytes, as the link leaves them.
        bytes: Vec<u8>,
        /// Extra delay, s.
        delay_s: f64,
        /// So long after that it is sent once more, s.
        again_s: Option<f64>,
    },
    /// It is not sent.
    Lost,
    /// The link ends.
    Disconnected,
}

impl LinkFaults {
    /// The faults of `instrument`.
    pub fn new(all: &[Fault], instrument: Instrument, seed: u64) -> Self {
        let faults = all
            .iter()
            .filter(|fault| fault.instrument == instrument)
            .map(|fault| (fault.clone(), false))
            .collect();
        Self {
            faults,
            noise: Noise::new(seed, Stream::Fault),
            replies: 0,
        }
    }

    /// What becomes of `bytes` at `now_s`.
    pub fn delivery(&mut self, mut bytes: Vec<u8>, now_s: f64) -> Delivery {
        let reply = self.replies;
        self.replies += 1;
        let (mut delay_s, mut again_s) = (0.0, None);
        for (number, (fault, done)) in self.faults.iter_mut().enumerate() {
            let [chance, place] = self.noise.uniform_pair(reply, number as u32);
            let of_reply = !matches!(fault.kind, FaultKind::Stall | FaultKind::Alarm | FaultKind::Saturate);
            if !of_reply || !active(fault, *done, now_s) || chance > fault.probability {
                continue;
            }
            *done = true;
            let at = ((place * bytes.len() as f64) as usize).min(bytes.len().saturating_sub(1));
            match fault.kind {
                FaultKind::DropByte if !bytes.is_empty() => {
                    bytes.remove(at);
                }
                FaultKind::FlipBit => {
                    if let Some(byte) = bytes.get_mut(at) {
                        *byte ^= 1 << (reply % 7);
                    }
                }
                FaultKind::WrongDigit => change_digit(&mut bytes, place, reply),
                FaultKind::Late => delay_s += fault.delay_s,
                FaultKind::Double => again_s = Some(fault.delay_s),
                FaultKind::Silent => return Delivery::Lost,
                FaultKind::Disconnect => return Delivery::Disconnected,
                FaultKind::DropByte | FaultKind::Stall | FaultKind::Alarm | FaultKind::Saturate => {}
            }
        }
        Delivery::Sent {
            bytes,
            delay_s,
            again_s,
        }
    }

    /// One more from now on.
    pub fn add(&mut self, fault: Fault) {
        self.faults.push((fault, false));
    }

    /// None from now on.
    pub fn clear(&mut self) {
        self.faults.clear();
    }

    /// Whether an alarm is due that has not been raised; it counts as raised from then on.
    pub fn alarm_due(&mut self, now_s: f64) -> bool {
        let due = self
            .faults
            .iter_mut()
            .find(|(fault, done)| fault.kind == FaultKind::Alarm && !*done && fault.at_s <= now_s);
        due.is_some_and(|(_, done)| !std::mem::replace(done, true))
    }

    /// True if the link refuses to be opened at `now_s`.
    pub fn refuses(&self, now_s: f64) -> bool {
        self.faults.iter().any(|(fault, done)| {
            fault.kind == FaultKind::Disconnect && *done && fault.for_s.is_none_or(|for_s| now_s < fault.at_s + for_s)
        })
    }

    /// From when the next stall waits for a motion to stop; `None` if none is left.
    pub fn stall_from_s(&self) -> Option<f64> {
        let waiting = self
            .faults
            .iter()
            .find(|(fault, done)| fault.kind == FaultKind::Stall && !*done);
        waiting.map(|(fault, _)| fault.at_s)
    }

    /// The stall has happened.
    pub fn stalled(&mut self) {
        if let Some((_, done)) = self
            .faults
            .iter_mut()
            .find(|(fault, done)| fault.kind == FaultKind::Stall && !*done)
        {
            *done = true;
        }
    }
}

/// Makes one decimal digit of `bytes`, at the share `place` of them, another one.
fn change_digit(bytes: &mut [u8], place: f64, reply: u64) {
    let digits: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at].is_ascii_digit()).collect();
    if let Some(&at) = digits.get((place * digits.len() as f64) as usize) {
        let by = 1 + (reply % 9) as u8;
        bytes[at] = b'0' + (bytes[at] - b'0' + by) % 10;
    }
}

/// Without a duration a fault happens once; a lost link stays lost.
fn active(fault: &Fault, done: bool, now_s: f64) -> bool {
    if now_s < fault.at_s {
        return false;
    }
    match fault.for_s {
        Some(for_s) => now_s < fault.at_s + for_s,
        None => !done || fault.kind == FaultKind::Disconnect,
    }
}

/// What a person asks of twins that serve: a line of text.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// `luxmeter late delay_s=0.8 for_s=10`: instrument, kind and keys as in a `darkroom.toml`; `at_s` counts from now
    /// on.
    Fault(Fault),
    /// `clear`, `clear axes`: all faults of all or of one instrument end.
    Clear(Option<Instrument>),
}

/// A line that asks for nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}; a fault is `INSTRUMENT KIND [at_s=N] [for_s=N] [delay_s=N] [probability=N]` or `clear [INSTRUMENT]`")]
pub struct NoOrder(String);

impl FromStr for Order {
    type Err = NoOrder;

    fn from_str(line: &str) -> Result<Self, NoOrder> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words[..] {
            ["clear"] => Ok(Self::Clear(None)),
            ["clear", name] => {
                let known = Instrument::ALL.into_iter().find(|instrument| instrument.name() == name);
                let known = known.ok_or_else(|| NoOrder(format!("{name:?} is no instrument of a darkroom")))?;
                Ok(Self::Clear(Some(known)))
            }
            [instrument, kind, ref keys @ ..] => {
                // Read as what it would be in a darkroom.toml: one set of words, one set of rules.
                let mut text = format!("[[fault]]\ninstrument = {instrument:?}\nkind = {kind:?}\n");
                for key in keys {
                    let (key, value) = key
                        .split_once('=')
                        .ok_or_else(|| NoOrder(format!("{key:?} is no key=value")))?;
                    text.push_str(&format!("{key:?} = {value}\n"));
                }
                let room = Darkroom::parse(&text).map_err(|error| NoOrder(error.message))?;
                match &room.fault[..] {
                    [fault] => Ok(Self::Fault(fault.clone())),
                    _ => Err(NoOrder(format!("{line:?} is no fault"))),
                }
            }
            _ => Err(NoOrder(format!("{line:?} is no fault"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_fault_of_a_darkroom() {
        let order: Order = "luxmeter late delay_s=0.5 for_s=10".parse().unwrap();
        let Order::Fault(fault) = order else { panic!() };
        assert_eq!((fault.kind, fault.instrument), (FaultKind::Late, Instrument::Luxmeter));
        assert_eq!((fault.at_s, fault.for_s, fault.delay_s), (0.0, Some(10.0), 0.5));
        assert_eq!("clear axes".parse(), Ok(Order::Clear(Some(Instrument::Axes))));
        for (line, word) in [
            ("luxmeter slow", "flip_bit"),
            ("meter late", "luxmeter"),
            ("luxmeter late delay=1", "delay_s"),
            ("luxmeter late delay_s=soon", "luxmeter late"),
            ("luxmeter late now", "\"now\""),
            ("luxmeter alarm", "axes"),
            ("axes saturate", "luxmeter"),
            ("axes late probability=2", "probability"),
            ("clear meter", "meter"),
            ("late", "INSTRUMENT KIND"),
        ] {
            let error = line.parse::<Order>().unwrap_err().to_string();
            assert!(error.contains(word) || word == "luxmeter late", "{line}: {error}");
            assert!(error.contains("INSTRUMENT KIND"), "{line}: {error}");
        }
    }

    fn faults(text: &str) -> LinkFaults {
        LinkFaults::new(&Darkroom::parse(text).unwrap().fault, Instrument::Luxmeter, 1)
    }

    #[test]
    fn a_fault_without_duration_happens_once() {
        let mut link = faults("[[fault]]\ninstrument = \"luxmeter\"\nkind = \"drop_byte\"\nat_s = 5.0\n");
        let whole = b"0123456789".to_vec();
        assert_eq!(
            link.delivery(whole.clone(), 4.0),
            Delivery::Sent {
                bytes: whole.clone(),
                delay_s: 0.0,
                again_s: None
            }
        );
        let Delivery::Sent { bytes, .. } = link.delivery(whole.clone(), 6.0) else {
            panic!()
        };
        assert_eq!(bytes.len(), 9);
        assert_eq!(
            link.delivery(whole.clone(), 7.0),
            Delivery::Sent {
                bytes: whole,
                delay_s: 0.0,
                again_s: None
            }
        );
    }

    #[test]
    fn a_wrong_digit_is_a_digit_and_a_double_comes_twice() {
        let kinds = |kind: &str| {
            format!("[[fault]]\ninstrument = \"luxmeter\"\nkind = \"{kind}\"\nfor_s = 9.0\ndelay_s = 0.05\n")
        };
        let sent = b"+1.2345E+02;3\n";
        let mut places = std::collections::BTreeSet::new();
        let mut link = faults(&kinds("wrong_digit"));
        for _ in 0..100 {
            let Delivery::Sent { bytes, .. } = link.delivery(sent.to_vec(), 1.0) else {
                panic!()
            };
            let other: Vec<usize> = (0..sent.len()).filter(|&at| bytes[at] != sent[at]).collect();
            assert!(other.len() == 1 && bytes.len() == sent.len() && bytes[other[0]].is_ascii_digit());
            places.extend(other);
        }
        assert_eq!(places.len(), 8, "every digit in its turn: {places:?}");
        let mut link = faults(&kinds("double"));
        let Delivery::Sent { bytes, again_s, .. } = link.delivery(sent.to_vec(), 1.0) else {
            panic!()
        };
        assert_eq!((bytes.as_slice(), again_s), (&sent[..], Some(0.05)));
    }

    #[test]
    fn a_lost_link_stays_lost_until_its_time_is_over() {
        let mut link =
            faults("[[fault]]\ninstrument = \"luxmeter\"\nkind = \"disconnect\"\nat_s = 5.0\nfor_s = 10.0\n");
        assert_eq!(link.delivery(vec![1], 5.0), Delivery::Disconnected);
        assert!(link.refuses(10.0));
        assert!(!link.refuses(16.0));
        let mut other = faults("[[fault]]\ninstrument = \"axes\"\nkind = \"silent\"\n");
        assert_eq!(
            other.delivery(vec![1], 5.0),
            Delivery::Sent {
                bytes: vec![1],
                delay_s: 0.0,
                again_s: None
            }
        );
    }
}
