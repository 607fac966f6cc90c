//! What the host says.

/// One command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// 01: initialise. No answer; wait 0.1 s.
    Initialize,
    /// 02: integration time in µs. No answer.
    IntegrationTime(u32),
    /// 05: an EEPROM slot.
    Eeprom(u8),
    /// 09: a spectrum.
    Spectrum,
    /// 0A: trigger mode, 0 is free running. No answer.
    Trigger(u16),
    /// 6B: a register of the FPGA.
    Register(u8),
    /// 6D: 60 bytes of the irradiance calibration, from this byte address.
    Irradiance(u16),
    /// FE: the status.
    Status,
}

/// Why bytes are no command.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no command of this language: {}", .bytes.escape_ascii())]
pub struct NotARequest {
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl Request {
    /// The bytes of the USB transfer to endpoint 0x01.
    pub fn encode(&self) -> Vec<u8> {
        match *self {
            Self::Initialize => vec![0x01],
            Self::IntegrationTime(us) => [&[0x02], &us.to_le_bytes()[..]].concat(),
            Self::Eeprom(slot) => vec![0x05, slot],
            Self::Spectrum => vec![0x09],
            Self::Trigger(mode) => [&[0x0A], &mode.to_le_bytes()[..]].concat(),
            Self::Register(register) => vec![0x6B, register],
            Self::Irradiance(address) => [&[0x6D], &address.to_le_bytes()[..]].concat(),
            Self::Status => vec![0xFE],
        }
    }

    /// Reads the bytes as the instrument does.
    ///
    /// # Errors
    /// [`NotARequest`] for an unknown opcode or a wrong length.
    pub fn parse(bytes: &[u8]) -> Result<Self, NotARequest> {
        Ok(match *bytes {
            [0x01] => Self::Initialize,
            [0x02, a, b, c, d] => Self::IntegrationTime(u32::from_le_bytes([a, b, c, d])),
            [0x05, slot] => Self::Eeprom(slot),
            [0x09] => Self::Spectrum,
            [0x0A, a, b] => Self::Trigger(u16::from_le_bytes([a, b])),
            [0x6B, register] => Self::Register(register),
            [0x6D, a, b] => Self::Irradiance(u16::from_le_bytes([a, b])),
            [0xFE] => Self::Status,
            _ => return Err(NotARequest { bytes: bytes.to_vec() }),
        })
    }

    /// Whether the instrument answers.
    pub const fn is_answered(&self) -> bool {
        !matches!(self, Self::Initialize | Self::IntegrationTime(_) | Self::Trigger(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_seabreeze() {
        // python-seabreeze 2.11, pyseabreeze.protocol.OOIProtocol.msgs: struct "<BI", "<BB", "<BH", "<B".
        for (request, bytes) in [
            (Request::Initialize, &b"\x01"[..]),
            (Request::IntegrationTime(100_000), b"\x02\xa0\x86\x01\x00"),
            (Request::IntegrationTime(655_350_000), b"\x02\xf0\xd8\x0f\x27"),
            (Request::Eeprom(17), b"\x05\x11"),
            (Request::Spectrum, b"\x09"),
            (Request::Trigger(3), b"\x0a\x03\x00"),
            (Request::Register(4), b"\x6b\x04"),
            (Request::Irradiance(60), b"\x6d\x3c\x00"),
            (Request::Status, b"\xfe"),
        ] {
            assert_eq!(request.encode(), bytes, "{request:?}");
            assert_eq!(Request::parse(bytes), Ok(request));
        }
        assert!(Request::parse(&[0x02, 1]).is_err());
        assert!(Request::parse(&[]).is_err());
    }
}
