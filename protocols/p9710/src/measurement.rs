//! What a measurement says, and what the error bits mean.

use isolux_protocol_ascii::Number;

/// The eight ranges: full scale of the detector's current in A, 0 first. Manual, section 12.2.
pub const RANGES: [f64; 8] = [2e-3, 2e-4, 2e-5, 2e-6, 2e-7, 2e-8, 2e-9, 2e-10];

/// The answer to `MV`, `GR` and `GP`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// The value in the unit of the calibration data that are selected, and its last digit.
    pub value: Number,
    /// The range in use, 0 (2 mA) to 7 (200 pA).
    pub range: u8,
    /// Share of the range that the measurement used, %.
    pub percent: f64,
}

/// A number of the form `+x.xxxxE+xx`, sign and all five digits.
pub(crate) fn scientific(text: &str) -> Option<Number> {
    let form = text.bytes().enumerate().all(|(at, byte)| match at {
        0 | 8 => matches!(byte, b'+' | b'-'),
        2 => byte == b'.',
        7 => byte == b'E',
        _ => byte.is_ascii_digit(),
    });
    (form && text.len() == 11).then(|| Number::parse(text)).flatten()
}

/// The number behind `?`, section 15.4.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ErrorCode(pub u8);

impl ErrorCode {
    /// The signal is above the range.
    pub const fn is_overload(self) -> bool {
        self.0 & 16 != 0
    }

    /// The signal is below the range.
    pub const fn is_underload(self) -> bool {
        self.0 & 32 != 0
    }

    /// In words.
    pub const fn meaning(self) -> &'static str {
        match self.0 {
            1 => "command not allowed",
            2 => "command parameter not allowed",
            4 => "wrong code number",
            8 => "parameter out of limits",
            16 => "input signal overload",
            32 => "input signal underload",
            64 => "EEPROM write error",
            _ => "unknown error",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_all_its_places() {
        let value = scientific("+1.2345E+02").unwrap();
        assert_eq!((value.value, value.step), (123.45, 0.01));
        assert_eq!(scientific("-0.0012E-03").unwrap().value, -1.2e-6);
        for text in [
            "",
            "1.2345E+02",
            "+1.234E+02",
            "+1.2345E+2",
            "+1.2345E02",
            "+1,2345E+02",
            "+1.2345E+022",
            "1+1.2345E+02",
        ] {
            assert_eq!(scientific(text), None, "{text}");
        }
        assert!(ErrorCode(48).is_overload() && ErrorCode(48).is_underload() && !ErrorCode(8).is_overload());
    }
}
