//! The language of the Konica Minolta T-10A illuminance meter as a sans-IO codec: no clock, no I/O.
//!
//! 9600 baud, 7 data bits, even parity, 1 stop bit. A request is `STX head command parameter ETX BCC CR LF`, 14 bytes;
//! an answer is the same with a status for the parameter, or 32 bytes with three values of six characters. BCC is the
//! exclusive or of all bytes after STX up to and including ETX, as two hexadecimal digits. There is no request number:
//! after a timeout the line must be quiet before the next request, which is what [`Host`] sees to. Source: Konica
//! Minolta "T-10A communication manual" (T-10-E.pdf), sections 3 to 5.

mod answer;
mod conversation;
mod request;

pub use answer::{Answer, HeadError, Measurement, NotAnAnswer, Status, Value};
pub use conversation::{Host, QUIET};
pub use request::{BROADCAST, NotARequest, Range, Request};

pub(crate) const STX: u8 = 0x02;
pub(crate) const ETX: u8 = 0x03;

/// The block check: exclusive or of `bytes`, which run from after STX through ETX.
pub fn block_check(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |check, byte| check ^ byte)
}

/// STX, `body`, ETX, BCC, CR LF.
pub(crate) fn frame(body: &[u8]) -> Vec<u8> {
    let mut frame = vec![STX];
    frame.extend_from_slice(body);
    frame.push(ETX);
    let check = block_check(&frame[1..]);
    frame.extend_from_slice(format!("{check:02X}\r\n").as_bytes());
    frame
}

/// Why bytes are no frame of this language.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NotAFrame {
    #[error("{0} bytes, expected 14 or 32")]
    Length(usize),
    #[error("no STX, ETX, CR or LF where it must be")]
    Marks,
    #[error("check characters {stated}, computed {computed:02X}")]
    Check { stated: String, computed: u8 },
}

/// The bytes between STX and ETX of a whole frame, its check verified.
pub(crate) fn unframe(frame: &[u8]) -> Result<&[u8], NotAFrame> {
    if frame.len() != 14 && frame.len() != 32 {
        return Err(NotAFrame::Length(frame.len()));
    }
    let etx = frame.len() - 5;
    if frame[0] != STX || frame[etx] != ETX || &frame[etx + 3..] != b"\r\n" {
        return Err(NotAFrame::Marks);
    }
    let computed = block_check(&frame[1..=etx]);
    if frame[etx + 1..etx + 3] != *format!("{computed:02X}").as_bytes() {
        let stated = frame[etx + 1..etx + 3].escape_ascii().to_string();
        return Err(NotAFrame::Check { stated, computed });
    }
    Ok(&frame[1..etx])
}
