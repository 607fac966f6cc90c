//! A device without input and output of its own: transfers in, answers out.

use std::collections::{BTreeSet, HashMap, VecDeque};

use crate::control;
use crate::model::{Model, Packing};
use crate::wire::{Answer, Urb};

/// Errors of the kernel, as USB/IP passes them on.
const STALL: i32 = -32;
const OVERFLOW: i32 = -75;
const UNLINKED: i32 = -104;
const SHORT: i32 = -121;

/// The state of an attached device.
#[derive(Debug)]
pub struct Device {
    model: Model,
    /// Packets to the host, by endpoint.
    packets: HashMap<u8, VecDeque<Vec<u8>>>,
    /// Transfers that wait for packets, by endpoint: a device that has nothing answers NAK, and the host asks again.
    waiting: HashMap<u8, VecDeque<Waiting>>,
    halted: BTreeSet<u8>,
    /// Endpoints whose next packet is longer than a packet may be.
    overflowing: BTreeSet<u8>,
    /// Bytes of the twin that are no whole frame yet.
    inbox: Vec<u8>,
}

#[derive(Debug)]
struct Waiting {
    urb: Urb,
    gathered: Vec<Vec<u8>>,
}

impl Device {
    pub fn new(model: Model) -> Self {
        Self {
            model,
            packets: HashMap::new(),
            waiting: HashMap::new(),
            halted: BTreeSet::new(),
            overflowing: BTreeSet::new(),
            inbox: Vec::new(),
        }
    }

    /// Halts an endpoint, or frees it.
    pub fn halt(&mut self, endpoint: u8, halted: bool) {
        if halted {
            self.halted.insert(endpoint);
        } else {
            self.halted.remove(&endpoint);
        }
    }

    /// Lets the next packet of an endpoint be too long.
    pub fn overflow(&mut self, endpoint: u8) {
        self.overflowing.insert(endpoint);
    }

    /// Takes a transfer: what can be answered now, and what the twin is to get.
    pub fn submit(&mut self, urb: Urb) -> (Vec<Answer>, Vec<u8>) {
        let done = |number, status, taken, data| Answer::Done {
            number,
            status,
            taken,
            data,
        };
        let number = urb.number;
        if matches!(urb.endpoint, 0x00 | 0x80) {
            let answer = match control::answer(&self.model, &mut self.halted, urb.setup) {
                Some(data) if urb.endpoint & 0x80 != 0 => done(number, 0, 0, data),
                Some(_) => done(number, 0, urb.data.len(), Vec::new()),
                None => done(number, STALL, 0, Vec::new()),
            };
            return (vec![answer], Vec::new());
        }
        if !self.model.endpoints.contains(&urb.endpoint) || self.halted.contains(&urb.endpoint) {
            return (vec![done(number, STALL, 0, Vec::new())], Vec::new());
        }
        if urb.endpoint & 0x80 == 0 {
            let bytes = match self.model.packing {
                Packing::Bytes => urb.data.clone(),
                Packing::Transfers => {
                    let mut frame = vec![urb.endpoint];
                    frame.extend((urb.data.len() as u16).to_le_bytes());
                    frame.extend_from_slice(&urb.data);
                    frame
                }
            };
            return (vec![done(number, 0, urb.data.len(), Vec::new())], bytes);
        }
        let endpoint = urb.endpoint;
        let waiting = Waiting {
            urb,
            gathered: Vec::new(),
        };
        self.waiting.entry(endpoint).or_default().push_back(waiting);
        (self.answers(), Vec::new())
    }

    /// Gives a transfer up. What it had gathered counts as not sent yet.
    pub fn unlink(&mut self, number: u32, forget: u32) -> Answer {
        for (endpoint, queue) in &mut self.waiting {
            if let Some(place) = queue.iter().position(|one| one.urb.number == forget) {
                let gathered = queue.remove(place).map(|one| one.gathered).unwrap_or_default();
                let packets = self.packets.entry(*endpoint).or_default();
                for packet in gathered.into_iter().rev() {
                    packets.push_front(packet);
                }
                return Answer::Forgotten {
                    number,
                    status: UNLINKED,
                };
            }
        }
        Answer::Forgotten { number, status: 0 }
    }

    /// Takes what the twin says; what can be answered with it.
    pub fn stated(&mut self, bytes: &[u8]) -> Vec<Answer> {
        match (self.model.packing, self.model.answers_on()) {
            (Packing::Bytes, Some(endpoint)) => self.send(endpoint, bytes, false),
            (Packing::Bytes, None) => {}
            (Packing::Transfers, _) => {
                self.inbox.extend_from_slice(bytes);
                while let &[endpoint, low, high, ..] = &self.inbox[..] {
                    let end = 3 + usize::from(u16::from_le_bytes([low, high]));
                    if self.inbox.len() < end {
                        break;
                    }
                    let frame: Vec<u8> = self.inbox.drain(..end).collect();
                    self.send(endpoint, &frame[3..], true);
                }
            }
        }
        self.answers()
    }

    /// Queues one transfer in packets. Where its end matters, full packets are followed by an empty one (5.8.3).
    fn send(&mut self, endpoint: u8, payload: &[u8], ends: bool) {
        let size = self.model.speed.packet();
        let queue = self.packets.entry(endpoint).or_default();
        queue.extend(payload.chunks(size).map(<[u8]>::to_vec));
        if ends && payload.len().is_multiple_of(size) {
            queue.push_back(Vec::new());
        }
    }

    /// Ends the transfers that have got what they wait for.
    pub fn answers(&mut self) -> Vec<Answer> {
        let size = self.model.speed.packet();
        let mut answers = Vec::new();
        for (endpoint, queue) in &mut self.waiting {
            let packets = self.packets.entry(*endpoint).or_default();
            while let Some(first) = queue.front_mut() {
                let status = if self.halted.contains(endpoint) {
                    first.gathered.clear();
                    STALL
                } else {
                    let Some(packet) = packets.pop_front() else { break };
                    let so_far: usize = first.gathered.iter().map(Vec::len).sum();
                    let short = packet.len() < size;
                    let all = so_far + packet.len();
                    if self.overflowing.remove(endpoint) || all > first.urb.length {
                        OVERFLOW
                    } else {
                        first.gathered.push(packet);
                        match (short, all == first.urb.length) {
                            (false, false) => continue,
                            (true, false) if first.urb.whole => SHORT,
                            _ => 0,
                        }
                    }
                };
                if let Some(ended) = queue.pop_front() {
                    answers.push(Answer::Done {
                        number: ended.urb.number,
                        status,
                        taken: 0,
                        data: ended.gathered.concat(),
                    });
                }
            }
        }
        answers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Speed;

    fn device(packing: Packing, speed: Speed) -> Device {
        Device::new(Model {
            id: (1, 2),
            release: 0,
            strings: [String::new(), String::new(), String::new()],
            speed,
            endpoints: vec![0x01, 0x81, 0x82],
            packing,
        })
    }

    fn urb(number: u32, endpoint: u8, length: usize) -> Urb {
        Urb {
            number,
            endpoint,
            whole: false,
            length,
            setup: [0; 8],
            data: Vec::new(),
        }
    }

    fn done(number: u32, status: i32, data: &[u8]) -> Answer {
        Answer::Done {
            number,
            status,
            taken: 0,
            data: data.to_vec(),
        }
    }

    fn frame(endpoint: u8, payload: &[u8]) -> Vec<u8> {
        [&[endpoint][..], &(payload.len() as u16).to_le_bytes(), payload].concat()
    }

    #[test]
    fn a_read_waits_for_its_endpoint_and_ends_with_the_transfer() {
        let mut device = device(Packing::Transfers, Speed::High);
        assert_eq!(device.submit(urb(1, 0x81, 512)).0, []);
        assert_eq!(device.submit(urb(2, 0x82, 8192)).0, []);
        let spectrum: Vec<u8> = (0..4097_u32).map(|place| place as u8).collect();
        let bytes = frame(0x82, &spectrum);
        assert_eq!(device.stated(&bytes[..3000]), []);
        assert_eq!(device.stated(&bytes[3000..]), [done(2, 0, &spectrum)]);
        assert_eq!(device.stated(&frame(0x81, &[7; 17])), [done(1, 0, &[7; 17])]);
    }

    #[test]
    fn two_transfers_are_two_reads_also_when_the_first_fills_its_packets() {
        let mut device = device(Packing::Transfers, Speed::Full);
        device.stated(&[frame(0x81, &[1; 64]), frame(0x81, &[2; 5])].concat());
        assert_eq!(device.submit(urb(1, 0x81, 512)).0, [done(1, 0, &[1; 64])]);
        assert_eq!(device.submit(urb(2, 0x81, 512)).0, [done(2, 0, &[2; 5])]);
    }

    #[test]
    fn bytes_fill_reads_of_packets_without_an_end() {
        let mut device = device(Packing::Bytes, Speed::Full);
        device.stated(&[9; 128]);
        assert_eq!(device.submit(urb(1, 0x81, 64)).0, [done(1, 0, &[9; 64])]);
        assert_eq!(
            device.submit(urb(2, 0x81, 128)).0,
            [],
            "64 of 128 bytes: the host waits for more"
        );
        assert_eq!(
            device.unlink(3, 2),
            Answer::Forgotten {
                number: 3,
                status: -104
            }
        );
        assert_eq!(
            device.submit(urb(4, 0x81, 64)).0,
            [done(4, 0, &[9; 64])],
            "nothing was lost"
        );
        assert_eq!(device.unlink(5, 4), Answer::Forgotten { number: 5, status: 0 });
    }

    #[test]
    fn a_halted_endpoint_stalls_until_it_is_cleared() {
        let mut device = device(Packing::Bytes, Speed::Full);
        assert_eq!(device.submit(urb(1, 0x81, 64)).0, []);
        device.halt(0x81, true);
        assert_eq!(device.answers(), [done(1, -32, &[])]);
        assert_eq!(device.submit(urb(2, 0x81, 64)).0, [done(2, -32, &[])]);
        let mut clear = urb(3, 0x00, 0);
        clear.setup = [0x02, 1, 0, 0, 0x81, 0, 0, 0];
        assert_eq!(device.submit(clear).0, [done(3, 0, &[])]);
        assert_eq!(device.submit(urb(4, 0x81, 64)).0, []);
        assert_eq!(
            device.submit(urb(5, 0x03, 0)).0,
            [done(5, -32, &[])],
            "no such endpoint"
        );
    }

    #[test]
    fn what_is_longer_than_the_read_overflows() {
        let mut device = device(Packing::Transfers, Speed::Full);
        device.stated(&frame(0x81, &[1; 17]));
        assert_eq!(device.submit(urb(1, 0x81, 16)).0, [done(1, -75, &[])]);
        device.overflow(0x81);
        device.stated(&frame(0x81, &[1; 17]));
        assert_eq!(device.submit(urb(2, 0x81, 512)).0, [done(2, -75, &[])]);
        let mut whole = urb(3, 0x81, 512);
        whole.whole = true;
        device.stated(&frame(0x81, &[1; 17]));
        assert_eq!(device.submit(whole).0, [done(3, -121, &[1; 17])]);
    }

    #[test]
    fn the_twin_gets_what_the_host_writes() {
        let mut device = device(Packing::Transfers, Speed::Full);
        let mut written = urb(1, 0x01, 1);
        written.data = vec![0xFE];
        let (answers, bytes) = device.submit(written);
        assert_eq!(bytes, [0x01, 1, 0, 0xFE]);
        let taken = Answer::Done {
            number: 1,
            status: 0,
            taken: 1,
            data: vec![],
        };
        assert_eq!(answers, [taken]);
    }
}
