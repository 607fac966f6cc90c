//! What a measurement says, and what the error numbers mean.

use isolux_protocol_ascii::Number;

/// A measured value as the meter writes it: `1234E-01 LX`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// Illuminance in lx, and its last digit.
    pub lux: Number,
}

/// Why a text is no illuminance.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotAMeasurement {
    /// Not of the form `nnnnnE-xy uu`.
    #[error("\"{0}\" is no measured value (nnnnnE-xy LX)")]
    Form(String),
    /// Another unit than lux.
    #[error("the meter shows {0}, not LX: press its unit key, or send UNI:PHOT LX")]
    Unit(String),
}

impl Measurement {
    /// Reads what stands after the header (section 4.9): up to five digits, an exponent, the unit.
    ///
    /// # Errors
    /// [`NotAMeasurement`].
    pub fn parse(text: &str) -> Result<Self, NotAMeasurement> {
        let wrong = || NotAMeasurement::Form(text.to_owned());
        let (number, unit) = text.rsplit_once(' ').ok_or_else(wrong)?;
        // A blank is allowed on either side of the exponent symbol (section 3.4).
        let number: String = number.split(' ').collect();
        let (digits, exponent) = number.split_once('E').ok_or_else(wrong)?;
        let whole = digits.strip_prefix('-').unwrap_or(digits);
        if !(1..=5).contains(&whole.len()) || !whole.bytes().all(|byte| byte.is_ascii_digit()) || exponent.len() > 3 {
            return Err(wrong());
        }
        let lux = Number::parse(&number).ok_or_else(wrong)?;
        match unit {
            "LX" => Ok(Self { lux }),
            "FC" | "FL" | "CD_M2" => Err(NotAMeasurement::Unit(unit.to_owned())),
            _ => Err(wrong()),
        }
    }
}

/// An error number of section 6.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorCode(pub u16);

impl ErrorCode {
    /// The light exceeds the range.
    pub const fn is_over_range(self) -> bool {
        matches!(self.0, 18 | 19 | 203)
    }

    /// The request was damaged on its way to the meter: asking again is right.
    pub const fn is_transmission(self) -> bool {
        matches!(self.0, 1..=4 | 8)
    }

    /// In words.
    pub const fn meaning(self) -> &'static str {
        match self.0 {
            1 => "UART overrun",
            2 => "stop bit not detected",
            3 => "parity error",
            4 => "receive buffer overrun",
            8 => "no end of the command",
            17 => "converter: phase sequence not adhered to",
            18 => "converter: overflow",
            19 => "measuring range exceeded",
            21 => "EEPROM write error",
            22 => "access to calibration data locked",
            101 => "command not supported",
            102 => "wrong number of parameters",
            103 => "unexpected parameter type",
            104 => "incorrect unit",
            105 => "query not implemented",
            106 => "brackets do not match",
            107 => "setting outside of the permissible range",
            108 => "incorrect index",
            201 => "hardware not supported by this firmware",
            202 => "the sensor is not suitable for this measurement",
            203 => "range exceeded",
            204 => "incorrect password",
            _ => "unknown error",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_manuals_examples() {
        let value = |text: &str| Measurement::parse(text).unwrap().lux;
        assert_eq!((value("1234E-01 LX").value, value("1234E-01 LX").step), (123.4, 0.1));
        assert_eq!(value("123E00 LX").value, 123.0);
        assert_eq!(value("0 E-03 LX").value, 0.0);
        assert_eq!(value("1999 E 03 LX").value, 1_999_000.0);
        assert_eq!(value("-2E-02 LX").value, -0.02);
    }

    #[test]
    fn refuses_other_units_and_other_forms() {
        let error = Measurement::parse("12E-01 FC").unwrap_err();
        assert_eq!(error, NotAMeasurement::Unit("FC".to_owned()));
        for text in [
            "",
            "1234E-01",
            "1234 LX",
            "12.4E-01 LX",
            "123456E-01 LX",
            "1234E-001 LX",
            "E-01 LX",
            "1234E-01 LUX",
            "1234E LX",
            "NANE00 LX",
        ] {
            assert!(
                matches!(Measurement::parse(text), Err(NotAMeasurement::Form(_))),
                "{text}"
            );
        }
        assert!(ErrorCode(19).is_over_range() && !ErrorCode(3).is_over_range() && ErrorCode(3).is_transmission());
    }
}
