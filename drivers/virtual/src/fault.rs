//! What happens to replies on a bad link.

use isolux_darkroom::document::{Fault, FaultKind, Instrument};
use isolux_darkroom::noise::{Noise, Stream};

/// The faults of one instrument's link.
#[derive(Debug, Clone)]
pub struct LinkFaults {
    faults: Vec<(Fault, bool)>,
    noise: Noise,
    replies: u64,
}

/// What becomes of one reply.
#[derive(Debug, Clone, PartialEq)]
pub enum Fate {
    /// It is sent, `delay_s` later than it should be.
    Sent {
        /// The bytes, as the link leaves them.
        bytes: Vec<u8>,
        /// Extra delay, s.
        delay_s: f64,
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
    pub fn fate(&mut self, mut bytes: Vec<u8>, now_s: f64) -> Fate {
        let reply = self.replies;
        self.replies += 1;
        let mut delay_s = 0.0;
        for (number, (fault, done)) in self.faults.iter_mut().enumerate() {
            let [chance, place] = self.noise.uniform_pair(reply, number as u32);
            let of_reply = fault.kind != FaultKind::Stall;
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
                FaultKind::Late => delay_s += fault.delay_s,
                FaultKind::Silent => return Fate::Lost,
                FaultKind::Disconnect => return Fate::Disconnected,
                FaultKind::DropByte | FaultKind::Stall => {}
            }
        }
        Fate::Sent { bytes, delay_s }
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

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_darkroom::Darkroom;

    fn faults(text: &str) -> LinkFaults {
        LinkFaults::new(&Darkroom::parse(text).unwrap().fault, Instrument::Luxmeter, 1)
    }

    #[test]
    fn a_fault_without_duration_happens_once() {
        let mut link = faults("[[fault]]\ninstrument = \"luxmeter\"\nkind = \"drop_byte\"\nat_s = 5.0\n");
        let whole = b"0123456789".to_vec();
        assert_eq!(
            link.fate(whole.clone(), 4.0),
            Fate::Sent {
                bytes: whole.clone(),
                delay_s: 0.0
            }
        );
        let Fate::Sent { bytes, .. } = link.fate(whole.clone(), 6.0) else {
            panic!()
        };
        assert_eq!(bytes.len(), 9);
        assert_eq!(
            link.fate(whole.clone(), 7.0),
            Fate::Sent {
                bytes: whole,
                delay_s: 0.0
            }
        );
    }

    #[test]
    fn a_lost_link_stays_lost_until_its_time_is_over() {
        let mut link =
            faults("[[fault]]\ninstrument = \"luxmeter\"\nkind = \"disconnect\"\nat_s = 5.0\nfor_s = 10.0\n");
        assert_eq!(link.fate(vec![1], 5.0), Fate::Disconnected);
        assert!(link.refuses(10.0));
        assert!(!link.refuses(16.0));
        let mut other = faults("[[fault]]\ninstrument = \"axes\"\nkind = \"silent\"\n");
        assert_eq!(
            other.fate(vec![1], 5.0),
            Fate::Sent {
                bytes: vec![1],
                delay_s: 0.0
            }
        );
    }
}
