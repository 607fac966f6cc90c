//! One value of a response: a number, or the reason why there is none.

use isolux_protocol_ascii::Number;

/// A value as the instrument gives it.
#[derive(Debug, Clone, PartialEq)]
pub enum Reading {
    /// A number.
    Value(Number),
    /// The instrument has nothing: `NAN`, 9.91E37, `----`.
    NoData,
    /// The quantity is beyond the range: `INF`, ±9.9E37 and larger.
    OverRange,
    /// No value at all; what there was instead.
    Unusable(String),
}

/// The sentinels of SCPI-99, section 7.2.1.4, are 9.9E37 for infinity and 9.91E37 for "not a number". They are told by
/// magnitude: as single precision 9.9E37 reads back as 9.900000302E37.
const SENTINEL: f64 = 9.89e37;

impl Reading {
    /// Reads one field; `unit` may stand behind the number, with or without a blank.
    pub fn parse(field: &str, unit: &str) -> Self {
        let text = field.trim();
        let bare = text.strip_suffix(unit).map_or(text, str::trim_end);
        match bare.to_ascii_uppercase().as_str() {
            "NAN" | "+NAN" | "-NAN" => return Self::NoData,
            "INF" | "+INF" | "-INF" | "NINF" | "INFINITY" | "+INFINITY" | "-INFINITY" => return Self::OverRange,
            dashes if dashes.len() >= 2 && dashes.bytes().all(|byte| byte == b'-') => return Self::NoData,
            _ => {}
        }
        Number::parse(bare).map_or_else(|| Self::Unusable(field.to_owned()), Self::classify)
    }

    /// Reads one value of a block, single precision. The patterns of no data and over range are NaN and infinity of no
    /// format but 9.91E37 and 9.9E37 (7E951BEE, 7E94F56A).
    pub fn of_single(bits: u32) -> Self {
        let value = f64::from(f32::from_bits(bits));
        if value.is_nan() {
            return Self::NoData;
        }
        if value.is_infinite() {
            return Self::OverRange;
        }
        let step = (f64::from(f32::from_bits(bits)).abs() * f64::from(f32::EPSILON)).max(f64::from(f32::MIN_POSITIVE));
        Self::classify(Number { value, step })
    }

    fn classify(number: Number) -> Self {
        let magnitude = number.value.abs();
        if magnitude < SENTINEL {
            Self::Value(number)
        } else if number.value > 0.0 && (9.905e37..9.915e37).contains(&magnitude) {
            Self::NoData
        } else {
            Self::OverRange
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(text: &str, unit: &str) -> f64 {
        match Reading::parse(text, unit) {
            Reading::Value(number) => number.value,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn numbers_with_and_without_their_unit() {
        assert_eq!(value("127.58E+00", "V"), 127.58);
        assert_eq!(value(" +110.14E+0\r", "V"), 110.14);
        assert_eq!(value("1.2V", "V"), 1.2);
        assert_eq!(value("0.123 A", "A"), 0.123);
        assert_eq!(value("-9.5985", ""), -9.5985);
    }

    #[test]
    fn sentinels_and_words_are_never_numbers() {
        for text in ["NAN", "nan", "9.91E37", "9.91E+37", "----", "--"] {
            assert_eq!(Reading::parse(text, "V"), Reading::NoData, "{text}");
        }
        for text in [
            "INF",
            "-INF",
            "9.9E37",
            "-9.9E37",
            "9.900000302e37",
            "+9999.9E+99",
            "-9.91E37",
            "1E38",
        ] {
            assert_eq!(Reading::parse(text, "V"), Reading::OverRange, "{text}");
        }
        for text in [
            "",
            "-",
            "ERROR",
            "1.2A",
            "1.000E+00;1;300.0E+00;1",
            "G90.00E+00",
            "1.2.3",
        ] {
            assert_eq!(Reading::parse(text, "V"), Reading::Unusable(text.to_owned()), "{text}");
        }
    }

    #[test]
    fn values_of_a_block() {
        assert_eq!(Reading::of_single(0x7E95_1BEE), Reading::NoData);
        assert_eq!(Reading::of_single(0x7E94_F56A), Reading::OverRange);
        assert_eq!(Reading::of_single(0x7FC0_0000), Reading::NoData);
        assert_eq!(Reading::of_single(0xFF80_0000), Reading::OverRange);
        assert!(matches!(Reading::of_single(0x4561_0000), Reading::Value(number) if number.value == 3600.0));
    }

    proptest! {
        #[test]
        fn noise_never_panics_and_a_value_is_finite_and_no_sentinel(text in "\\PC{0,12}") {
            if let Reading::Value(number) = Reading::parse(&text, "W") {
                prop_assert!(number.value.abs() < SENTINEL);
            }
        }
    }
}
