//! What the meter says.

use crate::{frame, unframe};

/// Why a head did not measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HeadError {
    /// Error 1.
    #[error("the receptor head has no power (error 1): switch the meter off and on")]
    NoPower,
    /// Error 2.
    #[error("EEPROM error 1 (error 2): switch the meter off and on")]
    Eeprom1,
    /// Error 3.
    #[error("EEPROM error 2 (error 3): switch the meter off and on")]
    Eeprom2,
}

/// The four status characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// The meter holds its reading.
    pub hold: bool,
    /// Error 5: the light exceeds the measuring range.
    pub over_range: bool,
    /// An error that leaves no measurement.
    pub error: Option<HeadError>,
    /// Range of the measurement, 1 to 5; 0 while the meter has none.
    pub range: u8,
    /// The battery is low.
    pub low_battery: bool,
}

/// One value as the meter writes it: sign, four digits, exponent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Value {
    /// Signed digits, −9999 to 9999.
    pub digits: i16,
    /// Exponent character: the value is digits × 10^(exponent − 4).
    pub exponent: u8,
}

impl Value {
    /// The number.
    pub fn number(&self) -> f64 {
        // A division for negative powers: 10⁻² has no exact double, 3400/100 is correctly rounded.
        let power = 10_f64.powi((i32::from(self.exponent) - 4).abs());
        if self.exponent < 4 {
            f64::from(self.digits) / power
        } else {
            f64::from(self.digits) * power
        }
    }

    /// The weight of the last digit.
    pub fn digit(&self) -> f64 {
        Self {
            digits: 1,
            exponent: self.exponent,
        }
        .number()
    }

    fn parse(text: &[u8]) -> Option<Self> {
        let [sign, digits @ .., exponent] = text else {
            return None;
        };
        // The manual pads with spaces; a blank field is no value.
        let digits = std::str::from_utf8(digits).ok()?.trim_start_matches(' ');
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) || !exponent.is_ascii_digit() {
            return None;
        }
        let magnitude: i16 = digits.parse().ok()?;
        let digits = match sign {
            b'+' | b'=' | b' ' => magnitude,
            b'-' => -magnitude,
            _ => return None,
        };
        Some(Self {
            digits,
            exponent: exponent - b'0',
        })
    }

    fn encode(self) -> String {
        // "=" stands for ±0.
        let sign = match self.digits {
            0 => '=',
            1.. => '+',
            _ => '-',
        };
        format!("{sign}{:04}{}", self.digits.unsigned_abs(), self.exponent)
    }
}

/// A long answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measurement {
    /// The status.
    pub status: Status,
    /// Illuminance in lx; `None` when the field is blank.
    pub illuminance_lx: Option<Value>,
    /// Difference to the meter's reference in lx; `None` without a reference.
    pub delta_lx: Option<Value>,
    /// Per cent of the meter's reference; `None` without a reference.
    pub percent: Option<Value>,
}

/// One answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// 14 bytes: done.
    Short {
        /// Head number.
        head: u8,
        /// The command that it answers.
        command: u8,
        /// The four status characters.
        status: [u8; 4],
    },
    /// 32 bytes: a measurement.
    Long {
        /// Head number.
        head: u8,
        /// The command that it answers.
        command: u8,
        /// The measurement.
        measurement: Measurement,
    },
}

/// Why a frame is no answer.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct NotAnAnswer {
    /// What is wrong with it.
    pub reason: String,
}

impl Answer {
    /// Reads a whole frame.
    ///
    /// # Errors
    /// [`NotAnAnswer`] with the reason.
    pub fn parse(bytes: &[u8]) -> Result<Self, NotAnAnswer> {
        let wrong = |reason: &str| NotAnAnswer {
            reason: reason.to_owned(),
        };
        let body = unframe(bytes).map_err(|error| wrong(&error.to_string()))?;
        let two = |digits: &[u8]| match digits {
            [a @ b'0'..=b'9', b @ b'0'..=b'9'] => Some((a - b'0') * 10 + (b - b'0')),
            _ => None,
        };
        let head = two(&body[..2]).ok_or_else(|| wrong("the head is no number"))?;
        let command = two(&body[2..4]).ok_or_else(|| wrong("the command is no number"))?;
        let status = [body[4], body[5], body[6], body[7]];
        if body.len() == 8 {
            return Ok(Self::Short { head, command, status });
        }
        let field = |at: usize| -> Result<Option<Value>, NotAnAnswer> {
            let text = &body[at..at + 6];
            if text.iter().all(|byte| *byte == b' ') {
                return Ok(None);
            }
            Value::parse(text)
                .map(Some)
                .ok_or_else(|| wrong(&format!("\"{}\" is no value", text.escape_ascii())))
        };
        let measurement = Measurement {
            status: Status::parse(status).map_err(|reason| wrong(&reason))?,
            illuminance_lx: field(8)?,
            delta_lx: field(14)?,
            percent: field(20)?,
        };
        Ok(Self::Long {
            head,
            command,
            measurement,
        })
    }

    /// Head and command.
    pub const fn to(&self) -> (u8, u8) {
        match self {
            Self::Short { head, command, .. } | Self::Long { head, command, .. } => (*head, *command),
        }
    }

    /// The bytes that a meter sends.
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Short { head, command, status } => {
                let mut body = format!("{head:02}{command:02}").into_bytes();
                body.extend_from_slice(status);
                frame(&body)
            }
            Self::Long {
                head,
                command,
                measurement,
            } => {
                let value = |value: Option<Value>| value.map_or_else(|| " ".repeat(6), Value::encode);
                let body = format!(
                    "{head:02}{command:02}{}{}{}{}",
                    measurement.status.encode(),
                    value(measurement.illuminance_lx),
                    value(measurement.delta_lx),
                    value(measurement.percent)
                );
                frame(body.as_bytes())
            }
        }
    }
}

impl Status {
    fn parse([hold, error, range, battery]: [u8; 4]) -> Result<Self, String> {
        let digit = |name: &str, byte: u8, largest: u8| match byte {
            b'0'..=b'9' if byte - b'0' <= largest => Ok(byte - b'0'),
            _ => Err(format!("{name} status \"{}\" is unknown", byte.escape_ascii())),
        };
        let (over_range, error) = match error {
            b' ' | b'7' => (false, None),
            b'1' => (false, Some(HeadError::NoPower)),
            b'2' => (false, Some(HeadError::Eeprom1)),
            b'3' => (false, Some(HeadError::Eeprom2)),
            b'5' => (true, None),
            other => return Err(format!("error status \"{}\" is unknown", other.escape_ascii())),
        };
        Ok(Self {
            // Odd: hold; the other bits say how the meter's own keys stand.
            hold: digit("hold", hold, 7)? % 2 == 1,
            over_range,
            error,
            range: digit("range", range, 5)?,
            low_battery: digit("battery", battery, 3)? % 2 == 1,
        })
    }

    fn encode(self) -> String {
        let error = match (self.over_range, self.error) {
            (true, _) => '5',
            (_, Some(HeadError::NoPower)) => '1',
            (_, Some(HeadError::Eeprom1)) => '2',
            (_, Some(HeadError::Eeprom2)) => '3',
            _ => ' ',
        };
        format!(
            "{}{error}{}{}",
            u8::from(self.hold),
            self.range,
            u8::from(self.low_battery)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn measured(body: &str) -> Measurement {
        match Answer::parse(&frame(body.as_bytes())) {
            Ok(Answer::Long { measurement, .. }) => measurement,
            other => panic!("{body}: {other:?}"),
        }
    }

    #[test]
    fn reads_values_and_status() {
        // d × 10^(e − 4): 3400 with exponent 1 is 3.400 lx, with 6 it is 340 000 lx.
        let near = measured("00100 20+34001            ");
        assert_eq!(near.illuminance_lx.unwrap().number(), 3.4);
        assert_eq!(near.illuminance_lx.unwrap().digit(), 0.001);
        assert_eq!(
            (near.status.range, near.status.hold, near.status.over_range),
            (2, false, false)
        );
        assert_eq!(near.delta_lx, None);
        assert_eq!(
            measured("00100750+34006-00014=00004").illuminance_lx.unwrap().number(),
            340_000.0
        );
        let all = measured("00101 31+ 3382-  012+10003");
        assert!(all.status.hold && all.status.low_battery);
        assert_eq!(all.illuminance_lx.unwrap().number(), 3.38);
        assert_eq!(all.delta_lx.unwrap().number(), -0.01);
        assert_eq!(all.percent.unwrap().number(), 100.0);
        assert!(measured("00100550                  ").status.over_range);
        assert_eq!(
            measured("00100150                  ").status.error,
            Some(HeadError::NoPower)
        );
    }

    #[test]
    fn refuses_what_it_does_not_know() {
        for body in [
            "00100450+34001            ",
            "00100 90+34001            ",
            "00108 50+34001            ",
            "00100 50+3x001            ",
            "00100 50*34001            ",
            "0x100 50+34001            ",
            "00100 54+34001            ",
        ] {
            assert!(Answer::parse(&frame(body.as_bytes())).is_err(), "{body}");
        }
        assert!(Answer::parse(b"").is_err());
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(head in 0..30_u8, digits in -9999..=9999_i16, exponent in 0..=9_u8, range in 1..=5_u8, hold: bool, low_battery: bool) {
            let status = Status { hold, over_range: false, error: None, range, low_battery };
            let value = Some(Value { digits, exponent });
            let measurement = Measurement { status, illuminance_lx: value, delta_lx: None, percent: value };
            let answer = Answer::Long { head, command: 10, measurement };
            prop_assert_eq!(answer.encode().len(), 32);
            prop_assert_eq!(Answer::parse(&answer.encode()), Ok(answer));
        }

        #[test]
        fn a_changed_byte_is_refused(digits in -9999..=9999_i16, at in 0..32_usize, byte in 0..128_u8) {
            let status = Status { hold: false, over_range: false, error: None, range: 3, low_battery: false };
            let measurement = Measurement { status, illuminance_lx: Some(Value { digits, exponent: 3 }), delta_lx: None, percent: None };
            let mut frame = Answer::Long { head: 0, command: 10, measurement }.encode();
            prop_assume!(frame[at] != byte);
            frame[at] = byte;
            prop_assert!(Answer::parse(&frame).is_err());
        }

        #[test]
        fn noise_never_panics(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = Answer::parse(&bytes);
            let _ = crate::Request::parse(&bytes);
        }
    }
}
