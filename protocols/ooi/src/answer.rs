//! What the instrument says.

use crate::{IRRADIANCE_BLOCK, PIXELS, Request};

/// Numbers of the EEPROM slots.
pub mod slots {
    /// Serial number.
    pub const SERIAL: u8 = 0;
    /// Wavelength polynomial, lowest power first, nm.
    pub const WAVELENGTH: std::ops::RangeInclusive<u8> = 1..=4;
    /// Non-linearity polynomial, lowest power first.
    pub const NONLINEARITY: std::ops::RangeInclusive<u8> = 6..=13;
    /// Order of the non-linearity polynomial.
    pub const NONLINEARITY_ORDER: u8 = 14;
    /// Counts at which the detector saturates, binary.
    pub const SATURATION: u8 = 17;
}

/// The byte after the last pixel.
const END_OF_SPECTRUM: u8 = 0x69;

/// An EEPROM slot: 15 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EepromSlot {
    /// Its number.
    pub slot: u8,
    /// Its bytes.
    pub data: [u8; 15],
}

impl EepromSlot {
    /// The text up to the first NUL (or all 15 characters: a full slot has none), without blanks around it.
    pub fn text(&self) -> Option<&str> {
        let end = self.data.iter().position(|byte| *byte == 0).unwrap_or(self.data.len());
        std::str::from_utf8(&self.data[..end])
            .ok()
            .map(str::trim)
            .filter(|text| text.is_ascii())
    }

    /// The text as a finite number.
    pub fn number(&self) -> Option<f64> {
        self.text()?.parse().ok().filter(|number: &f64| number.is_finite())
    }

    /// The saturation of slot 17: little-endian at bytes 4 and 5, 0 for "not set".
    pub fn saturation(&self) -> Option<u16> {
        Some(u16::from_le_bytes([self.data[4], self.data[5]])).filter(|counts| *counts != 0)
    }
}

/// The answer to FE.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InstrumentStatus {
    /// Pixels.
    pub pixels: u16,
    /// Integration time, µs.
    pub integration_us: u32,
    /// Lamp enable line.
    pub lamp: bool,
    /// Trigger mode.
    pub trigger: u8,
    /// The link is high speed: spectra come on endpoint 0x82.
    pub high_speed: bool,
}

/// Marks an irradiance block by its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockTag(pub u16);

/// One answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// To 05.
    Eeprom(EepromSlot),
    /// To 09: raw counts, one a pixel.
    Spectrum(Vec<u16>),
    /// To 6B.
    Register {
        /// Number of the register.
        register: u8,
        /// Its value.
        value: u16,
    },
    /// To 6D: fifteen big-endian floats, as they are stored.
    Irradiance(BlockTag, Vec<u8>),
    /// To FE.
    Status(InstrumentStatus),
}

/// Why a transfer is no answer to the request.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct NotAnAnswer {
    /// What is wrong with it.
    pub reason: String,
}

impl Answer {
    /// Reads a control or spectrum transfer as the answer to `request`.
    ///
    /// # Errors
    /// [`NotAnAnswer`] for a wrong length, another slot or register, or a spectrum without its end mark.
    pub fn parse(request: Request, payload: &[u8]) -> Result<Self, NotAnAnswer> {
        let wrong = |reason: String| NotAnAnswer { reason };
        let length = |expected: usize| {
            let found = payload.len();
            if found == expected {
                Ok(())
            } else {
                Err(wrong(format!("{found} bytes, expected {expected}")))
            }
        };
        match request {
            Request::Eeprom(slot) => {
                length(17)?;
                if payload[..2] != [0x05, slot] {
                    return Err(wrong(format!("slot {} answers, slot {slot} was asked", payload[1])));
                }
                let mut data = [0; 15];
                data.copy_from_slice(&payload[2..]);
                Ok(Self::Eeprom(EepromSlot { slot, data }))
            }
            Request::Spectrum => {
                length(2 * PIXELS + 1)?;
                if payload[2 * PIXELS] != END_OF_SPECTRUM {
                    return Err(wrong(format!(
                        "it ends with 0x{:02X} and not with 0x69",
                        payload[2 * PIXELS]
                    )));
                }
                let pairs = payload[..2 * PIXELS].chunks_exact(2);
                Ok(Self::Spectrum(
                    pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect(),
                ))
            }
            Request::Register(register) => {
                length(3)?;
                if payload[0] != register {
                    return Err(wrong(format!("register {} answers, {register} was asked", payload[0])));
                }
                Ok(Self::Register {
                    register,
                    value: u16::from_le_bytes([payload[1], payload[2]]),
                })
            }
            Request::Irradiance(address) => {
                length(usize::from(IRRADIANCE_BLOCK))?;
                Ok(Self::Irradiance(BlockTag(address), payload.to_vec()))
            }
            Request::Status => {
                length(16)?;
                let number = [payload[2], payload[3], payload[4], payload[5]];
                Ok(Self::Status(InstrumentStatus {
                    pixels: u16::from_le_bytes([payload[0], payload[1]]),
                    integration_us: u32::from_le_bytes(number),
                    lamp: payload[6] != 0,
                    trigger: payload[7],
                    high_speed: payload[14] == 0x80,
                }))
            }
            Request::Initialize | Request::IntegrationTime(_) | Request::Trigger(_) => {
                Err(wrong("nobody answers this command".to_owned()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn slot(slot: u8, text: &[u8]) -> EepromSlot {
        let mut payload = vec![0x05, slot];
        payload.extend_from_slice(text);
        payload.resize(17, 0);
        match Answer::parse(Request::Eeprom(slot), &payload) {
            Ok(Answer::Eeprom(slot)) => slot,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn eeprom_slots_hold_text_and_one_number_in_binary() {
        assert_eq!(slot(0, b"USB2+H16355").text(), Some("USB2+H16355"));
        assert_eq!(slot(1, b"3.3926000E+02\0\0").number(), Some(339.26));
        assert_eq!(slot(2, b" 3.8e-1 \0").number(), Some(0.38));
        // A full slot without NUL is legal; python-seabreeze raises there.
        assert_eq!(slot(3, b"-1.234567890123").number(), Some(-1.234_567_890_123));
        assert_eq!(slot(4, b"\xff\xff").number(), None);
        assert_eq!(slot(6, b"nan").number(), None);
        assert_eq!(slot(17, &[0, 0, 0, 0, 0x58, 0xF2]).saturation(), Some(62_040));
        assert_eq!(slot(17, b"").saturation(), None);
    }

    #[test]
    fn a_spectrum_needs_its_end_mark_and_its_length() {
        let mut bytes: Vec<u8> = (0..PIXELS as u16)
            .flat_map(|pixel| (pixel * 31).to_le_bytes())
            .collect();
        bytes.push(0x69);
        let Ok(Answer::Spectrum(counts)) = Answer::parse(Request::Spectrum, &bytes) else {
            panic!()
        };
        assert_eq!(
            (counts.len(), counts[0], counts[2047]),
            (2048, 0, 2047_u16.wrapping_mul(31))
        );
        bytes[4096] = 0x68;
        assert!(Answer::parse(Request::Spectrum, &bytes).is_err());
        bytes[4096] = 0x69;
        assert!(Answer::parse(Request::Spectrum, &bytes[..4096]).is_err());
    }

    #[test]
    fn status_and_register_are_read_at_their_places() {
        // struct "<HLBBBBBBBBBB" of python-seabreeze: pixels, integration time, …, speed at byte 14.
        let mut payload = vec![0x00, 0x08, 0xa0, 0x86, 0x01, 0x00, 1, 3, 0, 15, 0, 0, 0, 0, 0x80, 0];
        let Ok(Answer::Status(status)) = Answer::parse(Request::Status, &payload) else {
            panic!()
        };
        let expected = InstrumentStatus {
            pixels: 2048,
            integration_us: 100_000,
            lamp: true,
            trigger: 3,
            high_speed: true,
        };
        assert_eq!(status, expected);
        payload.push(0);
        assert!(Answer::parse(Request::Status, &payload).is_err());
        assert_eq!(
            Answer::parse(Request::Register(4), &[4, 0x10, 0x20]),
            Ok(Answer::Register {
                register: 4,
                value: 0x2010
            })
        );
        assert!(Answer::parse(Request::Register(4), &[5, 0x10, 0x20]).is_err());
        assert!(Answer::parse(Request::Eeprom(2), &[5; 17]).is_err(), "slot 5 answers");
    }

    proptest! {
        #[test]
        fn noise_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..100), slot: u8) {
            for request in [Request::Eeprom(slot), Request::Spectrum, Request::Status, Request::Register(slot), Request::Irradiance(0), Request::Initialize] {
                let _ = Answer::parse(request, &bytes);
            }
            let _ = Request::parse(&bytes);
        }
    }
}
