//! What the instrument says.

use crate::{Flags, Message, PIXELS, Request, error_text};

/// An answer and how far it is to be believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// What it says.
    pub value: Value,
    /// An MD5 sum protects it. Without one, an answer is worth what a second equal one makes it.
    pub checked: bool,
}

/// What an answer says.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A command was acknowledged.
    Done,
    /// The request was refused.
    Refused {
        /// Number of the error.
        error: u16,
        /// What it says.
        reason: &'static str,
    },
    /// A text.
    Text(String),
    /// A whole number.
    Count(u32),
    /// A number; not finite where nothing was stored.
    Number(f32),
    /// A raw spectrum, one count a pixel.
    Spectrum(Vec<u16>),
    /// One number a pixel.
    Numbers(Vec<f32>),
}

impl Value {
    /// Reads a message as the answer to `request`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(crate) fn read(request: Request, message: &Message) -> Result<Self, String> {
        let data = &message.data[..];
        if message.flags.has(Flags(Flags::NACK.0 | Flags::EXCEPTION.0)) || message.error != 0 {
            return Ok(Self::Refused {
                error: message.error,
                reason: error_text(message.error),
            });
        }
        if request.is_command() {
            return if message.flags.has(Flags::ACK) {
                Ok(Self::Done)
            } else {
                Err("neither acknowledged nor refused".to_owned())
            };
        }
        if !message.flags.has(Flags::RESPONSE) {
            return Err("it is not marked as an answer".to_owned());
        }
        let length = |expected: usize| match data.len() {
            found if found == expected => Ok(()),
            found => Err(format!("{found} bytes of data, expected {expected}")),
        };
        Ok(match request {
            Request::Serial => {
                let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
                let text = std::str::from_utf8(&data[..end]).ok().filter(|text| text.is_ascii());
                Self::Text(text.ok_or("a serial number that is no text")?.trim().to_owned())
            }
            Request::Spectrum => {
                length(2 * PIXELS)?;
                Self::Spectrum(
                    data.chunks_exact(2)
                        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
                        .collect(),
                )
            }
            Request::Irradiance => {
                length(4 * PIXELS)?;
                Self::Numbers(data.chunks_exact(4).map(float).collect())
            }
            Request::Wavelength(_)
            | Request::Nonlinearity(_)
            | Request::Stray(_)
            | Request::IrradianceArea
            | Request::Temperature(_) => {
                length(4)?;
                Self::Number(float(data))
            }
            // The length differs between models; the number does not.
            _ => match *data {
                [a] => Self::Count(u32::from(a)),
                [a, b] => Self::Count(u32::from(u16::from_le_bytes([a, b]))),
                [a, b, c, d] => Self::Count(u32::from_le_bytes([a, b, c, d])),
                _ => return Err(format!("{} bytes of data, expected 1, 2 or 4", data.len())),
            },
        })
    }
}

fn float(bytes: &[u8]) -> f32 {
    f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
