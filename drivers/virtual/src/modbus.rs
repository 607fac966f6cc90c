//! Frames of Modbus as a server sees them: RTU, and MBAP where a request comes in one.
//!
//! After MODBUS Application Protocol Specification V1.1b3, MODBUS over Serial Line V1.02 and MODBUS Messaging on TCP/IP
//! V1.0b.

/// In which frame a request came; its answer goes back in the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Frame {
    Rtu,
    Mbap { transaction: [u8; 2] },
}

/// A whole request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Query {
    frame: Frame,
    pub unit: u8,
    pub function: u8,
    data: Vec<u8>,
}

/// What a unit is asked for, of what the twins know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// Functions 03 and 04.
    Read { from: u16, count: u16 },
    /// Functions 06 and 10h.
    Write { from: u16, values: Vec<u16> },
}

/// Why a unit refuses: the exception code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exception {
    Function = 1,
    Address = 2,
    Value = 3,
}

/// Takes a request off the front of `inbox`. What is none empties it, as the silence after it would.
pub(crate) fn take(inbox: &mut Vec<u8>) -> Option<Query> {
    // Transaction, protocol 0, length below 256: an RTU request has a register there, and no twin has one in 0000h.
    if let [a, b, 0, 0, 0, length, ..] = inbox[..] {
        let whole = 6 + usize::from(length);
        if length < 2 {
            inbox.clear();
            return None;
        }
        if inbox.len() < whole {
            return None;
        }
        let frame: Vec<u8> = inbox.drain(..whole).collect();
        return Some(Query {
            frame: Frame::Mbap { transaction: [a, b] },
            unit: frame[6],
            function: frame[7],
            data: frame[8..].to_vec(),
        });
    }
    let whole = match inbox.get(1)? {
        1..=6 => 8,
        0x0F | 0x10 => 9 + usize::from(*inbox.get(6)?),
        _ => {
            inbox.clear();
            return None;
        }
    };
    if inbox.len() < whole {
        return None;
    }
    let frame: Vec<u8> = inbox.drain(..whole).collect();
    let (body, check) = frame.split_at(whole - 2);
    if checksum(body) != check {
        inbox.clear();
        return None;
    }
    Some(Query {
        frame: Frame::Rtu,
        unit: body[0],
        function: body[1],
        data: body[2..].to_vec(),
    })
}

impl Query {
    /// What is asked for.
    pub fn wanted(&self) -> Result<Wanted, Exception> {
        let word = |at: usize| match self.data.get(at..at + 2) {
            Some(&[high, low]) => Ok(u16::from_be_bytes([high, low])),
            _ => Err(Exception::Value),
        };
        let (from, second) = (word(0)?, word(2)?);
        match self.function {
            3 | 4 if (1..=125).contains(&second) => Ok(Wanted::Read { from, count: second }),
            6 => Ok(Wanted::Write {
                from,
                values: vec![second],
            }),
            0x10 if (1..=123).contains(&second) && self.data.len() == 5 + 2 * usize::from(second) => {
                let values = self.data[5..]
                    .chunks(2)
                    .map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
                Ok(Wanted::Write {
                    from,
                    values: values.collect(),
                })
            }
            3 | 4 | 0x10 => Err(Exception::Value),
            _ => Err(Exception::Function),
        }
    }

    /// The answer to a read.
    pub fn registers(&self, words: &[u16]) -> Vec<u8> {
        let mut pdu = vec![self.function, words.len() as u8 * 2];
        pdu.extend(words.iter().flat_map(|word| word.to_be_bytes()));
        self.framed(&pdu)
    }

    /// The answer to a write.
    pub fn written(&self) -> Vec<u8> {
        let mut pdu = vec![self.function];
        pdu.extend(&self.data[..4]);
        self.framed(&pdu)
    }

    /// The refusal.
    pub fn refused(&self, exception: Exception) -> Vec<u8> {
        self.framed(&[self.function | 0x80, exception as u8])
    }

    /// Bytes of the request, for the time it took on a line.
    pub fn length(&self) -> usize {
        self.data.len() + 4
    }

    fn framed(&self, pdu: &[u8]) -> Vec<u8> {
        let mut frame = Vec::new();
        match self.frame {
            Frame::Rtu => {
                frame.push(self.unit);
                frame.extend(pdu);
                frame.extend(checksum(&frame));
            }
            Frame::Mbap { transaction } => {
                frame.extend(transaction);
                frame.extend([0, 0, 0, pdu.len() as u8 + 1, self.unit]);
                frame.extend(pdu);
            }
        }
        frame
    }
}

/// CRC of SL 6.2.2, in the order in which it is sent.
fn checksum(bytes: &[u8]) -> [u8; 2] {
    let mut sum: u16 = !0;
    for byte in bytes {
        sum ^= u16::from(*byte);
        for _ in 0..8 {
            let odd = sum % 2 == 1;
            sum /= 2;
            if odd {
                sum ^= 0xA001;
            }
        }
    }
    sum.to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published exchange of an RS-485 lux transmitter, and that of the TCP implementation guide.
    #[test]
    fn frames_are_the_published_ones() {
        let mut inbox = vec![0x01, 0x03, 0x00, 0x07, 0x00, 0x02, 0x75, 0xCA, 0x01];
        let query = take(&mut inbox).unwrap();
        assert_eq!(inbox, [0x01], "what follows stays");
        assert_eq!(query.wanted(), Ok(Wanted::Read { from: 7, count: 2 }));
        let answer = query.registers(&[0x0002, 0x06F6]);
        assert_eq!(answer, [0x01, 0x03, 0x04, 0x00, 0x02, 0x06, 0xF6, 0xD8, 0x15]);
        let mut inbox = vec![0x15, 0x01, 0, 0, 0, 6, 0xFF, 3, 0, 4, 0, 1];
        let answer = take(&mut inbox).unwrap().registers(&[5]);
        assert_eq!(answer, [0x15, 0x01, 0, 0, 0, 5, 0xFF, 3, 2, 0, 5]);
    }

    #[test]
    fn damage_is_no_request_and_pieces_are_waited_for() {
        let whole = [0x01, 0x03, 0x00, 0x07, 0x00, 0x02, 0x75, 0xCA];
        for cut in 0..whole.len() {
            let mut inbox = whole[..cut].to_vec();
            assert_eq!(take(&mut inbox), None);
            inbox.extend(&whole[cut..]);
            assert!(take(&mut inbox).is_some());
        }
        for bit in 0..whole.len() * 8 {
            let mut inbox = whole.to_vec();
            inbox[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(take(&mut inbox), None, "bit {bit}");
        }
    }
}
