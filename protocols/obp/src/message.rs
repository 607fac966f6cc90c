//! Messages as bytes.

use md5::{Digest, Md5};

const START: [u8; 2] = [0xC1, 0xC0];
const VERSION: u16 = 0x1100;
const FOOTER: [u8; 4] = [0xC5, 0xC4, 0xC3, 0xC2];
const HEADER: usize = 44;
const CHECKSUM: usize = 16;
/// Checksum and footer.
const TAIL: usize = CHECKSUM + FOOTER.len();
/// Data up to this length travel inside the header.
const IMMEDIATE: usize = 16;
/// Longest payload that is believed: the irradiance factors of 4096 pixels.
const LONGEST: usize = 16_384;

const NO_CHECKSUM: u8 = 0;
const MD5: u8 = 1;

/// Flags of a message.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flags(pub u16);

impl Flags {
    /// Answer to a query.
    pub const RESPONSE: Self = Self(0x01);
    /// Acknowledgement of a command.
    pub const ACK: Self = Self(0x02);
    /// The host wants an acknowledgement.
    pub const ACK_REQUEST: Self = Self(0x04);
    /// The request is refused.
    pub const NACK: Self = Self(0x08);
    /// The instrument's hardware has failed.
    pub const EXCEPTION: Self = Self(0x10);

    /// Whether one of the flags of `other` is set.
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// One message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// What it is.
    pub flags: Flags,
    /// Number of an error, 0 for none.
    pub error: u16,
    /// What it is about.
    pub kind: u32,
    /// The host's number for its request.
    pub regarding: u32,
    /// Whether an MD5 sum protects it.
    pub checked: bool,
    /// Its data.
    pub data: Vec<u8>,
}

/// Bytes that are no message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotAMessage {
    /// It does not begin as one.
    #[error("it begins with {0:02X} {1:02X} and not with C1 C0")]
    Start(u8, u8),
    /// A version that is not known.
    #[error("protocol version 0x{0:04X}, not 0x1100")]
    Version(u16),
    /// A field of the header that cannot be.
    #[error("{0} of {1} in the header")]
    Header(&'static str, u64),
    /// It does not end as one.
    #[error("it does not end with C5 C4 C3 C2")]
    Footer,
    /// Its MD5 sum is another.
    #[error("the MD5 sum is not that of the message")]
    Checksum,
}

impl Message {
    /// Its bytes.
    pub fn encode(&self) -> Vec<u8> {
        let (inside, behind): (&[u8], &[u8]) = if self.data.len() <= IMMEDIATE {
            (&self.data, &[])
        } else {
            (&[], &self.data)
        };
        let mut bytes = START.to_vec();
        for word in [VERSION, self.flags.0, self.error] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.kind.to_le_bytes());
        bytes.extend(self.regarding.to_le_bytes());
        bytes.extend([0; 6]);
        bytes.push(if self.checked { MD5 } else { NO_CHECKSUM });
        bytes.push(inside.len() as u8);
        bytes.extend_from_slice(inside);
        bytes.resize(HEADER - 4, 0);
        bytes.extend(((behind.len() + TAIL) as u32).to_le_bytes());
        bytes.extend_from_slice(behind);
        let sum = if self.checked {
            <[u8; CHECKSUM]>::from(Md5::digest(&bytes))
        } else {
            [0; CHECKSUM]
        };
        bytes.extend(sum);
        bytes.extend(FOOTER);
        bytes
    }

    /// Reads the message that `bytes` begin with, and its length; `None` where it is not whole yet.
    ///
    /// # Errors
    /// [`NotAMessage`] as soon as the bytes cannot become one.
    pub fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, NotAMessage> {
        if let Some(&first) = bytes.first() {
            let second = bytes.get(1).copied().unwrap_or(START[1]);
            if [first, second] != START {
                return Err(NotAMessage::Start(first, second));
            }
        }
        let Some(header) = bytes.get(..HEADER) else {
            return Ok(None);
        };
        let half = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        if half(2) != VERSION {
            return Err(NotAMessage::Version(half(2)));
        }
        let checked = match header[22] {
            NO_CHECKSUM => false,
            MD5 => true,
            other => return Err(NotAMessage::Header("a checksum", u64::from(other))),
        };
        let inside = usize::from(header[23]);
        if inside > IMMEDIATE {
            return Err(NotAMessage::Header("immediate data", inside as u64));
        }
        let rest = word(40) as usize;
        let Some(behind) = rest
            .checked_sub(TAIL)
            .filter(|behind| *behind <= LONGEST && (*behind == 0 || inside == 0))
        else {
            return Err(NotAMessage::Header("a rest", rest as u64));
        };
        let end = HEADER + rest;
        let Some(whole) = bytes.get(..end) else {
            return Ok(None);
        };
        let (covered, tail) = whole.split_at(HEADER + behind);
        if tail[CHECKSUM..] != FOOTER {
            return Err(NotAMessage::Footer);
        }
        let sum = if checked {
            <[u8; CHECKSUM]>::from(Md5::digest(covered))
        } else {
            // A flipped bit in the type of the checksum must not take the protection away.
            [0; CHECKSUM]
        };
        if tail[..CHECKSUM] != sum {
            return Err(NotAMessage::Checksum);
        }
        let data = if behind > 0 {
            &covered[HEADER..]
        } else {
            &header[24..24 + inside]
        };
        let message = Self {
            flags: Flags(half(4)),
            error: half(6),
            kind: word(8),
            regarding: word(12),
            checked,
            data: data.to_vec(),
        };
        Ok(Some((message, end)))
    }
}

/// What the number of an error says (STS Data Sheet).
pub const fn error_text(error: u16) -> &'static str {
    match error {
        0 => "no error given",
        1 => "invalid or unsupported protocol",
        2 => "unknown message type",
        3 => "bad checksum",
        4 => "message too large",
        5 => "the payload's length does not match the message type",
        6 => "payload data invalid",
        7 => "not ready for this message",
        8 => "unknown checksum type",
        9 => "reset unexpectedly",
        10 => "commands came over too many interfaces",
        11 => "out of memory",
        12 => "the information does not exist",
        13 => "internal error of the device",
        255 => "deferred",
        _ => "an unknown error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_has_the_bytes_of_seabreeze() {
        // python-seabreeze 2.11.0, OBPProtocol._construct_outgoing_message(0x00110010, struct.pack("<L", 100000),
        // True).
        let message = Message {
            flags: Flags::ACK_REQUEST,
            error: 0,
            kind: 0x0011_0010,
            regarding: 0,
            checked: false,
            data: 100_000_u32.to_le_bytes().to_vec(),
        };
        let mut expected = vec![0xC1, 0xC0, 0x00, 0x11, 0x04, 0x00, 0x00, 0x00, 0x10, 0x00, 0x11, 0x00];
        expected.resize(22, 0);
        expected.extend([0, 4, 0xA0, 0x86, 0x01, 0x00]);
        expected.resize(40, 0);
        expected.extend([20, 0, 0, 0]);
        expected.resize(60, 0);
        expected.extend([0xC5, 0xC4, 0xC3, 0xC2]);
        assert_eq!(message.encode(), expected);
        assert_eq!(Message::parse(&expected), Ok(Some((message, 64))));
    }

    #[test]
    fn the_sum_is_that_of_header_and_payload() {
        let message = Message {
            flags: Flags::RESPONSE,
            error: 0,
            kind: 0x0010_1100,
            regarding: 7,
            checked: true,
            data: vec![0x5A; 2048],
        };
        let bytes = message.encode();
        assert_eq!(bytes.len(), 44 + 2048 + 20);
        assert_eq!(bytes[2092..2108], <[u8; 16]>::from(Md5::digest(&bytes[..2092])));
        assert_eq!(Message::parse(&bytes), Ok(Some((message, bytes.len()))));
    }
}
