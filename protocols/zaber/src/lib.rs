//! The Zaber ASCII protocol as a sans-IO codec: no clock, no I/O.
//!
//! A command is `/device axis id text:HH` and a line end; the device answers `@DD A ID OK|RJ BUSY|IDLE FLAG data:HH`
//! with CR LF. `HH` is a longitudinal redundancy check, always sent by this side and verified wherever the device sends
//! one. `ID` is the message id: an answer that comes after its request was given up carries an old id, so it can never
//! answer the next request. Sources: Zaber "ASCII Protocol Manual" (zaber.com/wiki/Manuals/ASCII_Protocol_Manual);
//! checksum as in the manufacturer's Python package zaber.serial 0.9.1.

mod command;
mod conversation;
mod flags;
mod framer;
mod message;

pub use command::{Command, InvalidCommand, NotACommand};
pub use conversation::{CHECKSUMS_ON, Host};
pub use flags::{Severity, WarningFlag};
pub use framer::{Damaged, Framer, MAX_LINE};
pub use message::{Alert, Info, Message, NotAMessage, Rejection, Reply, Status};

/// The longitudinal redundancy check of `text`: minus the sum of its bytes, modulo 256. `text` is everything after the
/// first character of the frame and before the colon.
pub fn checksum(text: &[u8]) -> u8 {
    text.iter()
        .fold(0_u8, |sum, byte| sum.wrapping_add(*byte))
        .wrapping_neg()
}

/// Splits `text:HH` and verifies the check; text without one comes back whole.
fn verified(text: &str) -> Result<(&str, bool), CheckFailed> {
    let Some((body, digits)) = text.rsplit_once(':').filter(|(_, digits)| digits.len() == 2) else {
        return Ok((text, false));
    };
    let computed = checksum(body.as_bytes());
    match u8::from_str_radix(digits, 16) {
        Ok(stated) if stated == computed => Ok((body, true)),
        _ => Err(CheckFailed {
            stated: digits.to_owned(),
            computed,
        }),
    }
}

/// The check at the end of a frame is not that of its text.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("checksum {stated} stated, {computed:02X} computed")]
struct CheckFailed {
    stated: String,
    computed: u8,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_is_that_of_zaber_serial() {
        // Computed with zaber.serial 0.9.1: "{:02X}".format(((sum & 0xFF) ^ 0xFF) + 1)[-2:].
        for (text, expected) in [
            ("01 0 OK IDLE -- 0", 0x8D),
            ("01 1 23 OK BUSY WR 12345", 0xC4),
            ("1 1 7 get pos", 0x55),
            ("", 0),
        ] {
            assert_eq!(checksum(text.as_bytes()), expected, "{text}");
        }
    }
}
