//! What the host says.

use crate::{frame, unframe};

/// The head address that reaches all heads; only hold and run may be sent there, and nobody answers.
pub const BROADCAST: u8 = 99;

/// Measuring range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Range {
    /// The meter chooses.
    Auto,
    /// 1 (most sensitive) to 5.
    Fixed(u8),
}

/// One request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// Command 54: put the meter under the control of the computer. The first request of all.
    Connect,
    /// Command 55: hold the readings of all heads, or let them run. Nobody answers.
    Hold(bool),
    /// Command 10: the latest measurement of `head`.
    Read {
        /// Head number, 0 to 29.
        head: u8,
        /// Range for this and the following measurements.
        range: Range,
        /// Whether the meter is to hold.
        hold: bool,
    },
}

/// Why bytes are no request.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct NotARequest {
    /// What is wrong.
    pub reason: String,
}

impl Request {
    /// The 14 bytes.
    pub fn encode(&self) -> Vec<u8> {
        let body = match self {
            Self::Connect => "00541   ".to_owned(),
            Self::Hold(hold) => format!("{BROADCAST}55{}  0", u8::from(*hold)),
            Self::Read { head, range, hold } => {
                let range = match range {
                    Range::Auto => 0,
                    Range::Fixed(range) => *range,
                };
                // Third parameter: 2, the colour correction factor is not used (3 would be with it).
                format!("{:02}10{}2{}0", head, u8::from(*hold), range)
            }
        };
        frame(body.as_bytes())
    }

    /// Head and command that the answer must carry, or `None` when nobody answers.
    pub const fn answered_as(&self) -> Option<(u8, u8)> {
        match self {
            Self::Connect => Some((0, 54)),
            Self::Hold(_) => None,
            Self::Read { head, .. } => Some((*head, 10)),
        }
    }

    /// Reads 14 bytes as the meter does.
    ///
    /// # Errors
    /// [`NotARequest`] for a damaged frame or an unknown command.
    pub fn parse(bytes: &[u8]) -> Result<Self, NotARequest> {
        let wrong = |reason: String| NotARequest { reason };
        let body = unframe(bytes).map_err(|error| wrong(error.to_string()))?;
        let digit = |byte: u8| byte.is_ascii_digit().then(|| byte - b'0');
        match body {
            b"00541   " => Ok(Self::Connect),
            b"99551  0" => Ok(Self::Hold(true)),
            b"99550  0" => Ok(Self::Hold(false)),
            [
                tens,
                ones,
                b'1',
                b'0',
                hold @ (b'0' | b'1'),
                b'2' | b'3',
                range @ b'0'..=b'5',
                b'0',
            ] => {
                let (Some(tens), Some(ones)) = (digit(*tens), digit(*ones)) else {
                    return Err(wrong("head is no number".into()));
                };
                let range = match range - b'0' {
                    0 => Range::Auto,
                    range => Range::Fixed(range),
                };
                Ok(Self::Read {
                    head: tens * 10 + ones,
                    range,
                    hold: *hold == b'1',
                })
            }
            _ => Err(wrong(format!("unknown request {}", body.escape_ascii()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_those_of_the_manual() {
        // Golden vectors: BCC of each recomputed by hand from the manual's examples.
        for (request, frame) in [
            (Request::Connect, b"\x0200541   \x0313\r\n"),
            (Request::Hold(true), b"\x0299551  0\x0302\r\n"),
            (Request::Hold(false), b"\x0299550  0\x0303\r\n"),
            (
                Request::Read {
                    head: 0,
                    range: Range::Auto,
                    hold: false,
                },
                b"\x0200100200\x0300\r\n",
            ),
        ] {
            assert_eq!(request.encode(), frame, "{request:?}");
            assert_eq!(Request::parse(frame), Ok(request));
        }
        let fifth = Request::Read {
            head: 7,
            range: Range::Fixed(5),
            hold: true,
        };
        assert_eq!(Request::parse(&fifth.encode()), Ok(fifth));
        assert!(Request::parse(b"\x0200100200\x0301\r\n").is_err());
    }
}
