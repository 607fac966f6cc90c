//! Numbers as instruments write them: NR1, NR2 and NR3 of IEEE 488.2, section 7.7.2.

/// A decimal number and the weight of its last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// The correctly rounded value; finite.
    pub value: f64,
    /// One unit of the last digit that was written.
    pub step: f64,
}

impl Number {
    /// Reads `12`, `1.25`, `-.5` or `1.25E+02`. Words (`NAN`, `INF`), blanks, a unit, and numbers beyond the doubles
    /// are none.
    pub fn parse(text: &str) -> Option<Self> {
        let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
        let (mantissa, exponent) = match unsigned.split_once(['E', 'e']) {
            Some((mantissa, exponent)) => (mantissa, Some(exponent)),
            None => (unsigned, None),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        if !digits(whole) || !digits(fraction) || (whole.is_empty() && fraction.is_empty()) {
            return None;
        }
        let exponent: i32 = match exponent {
            None => 0,
            Some(text) => {
                let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
                if unsigned.is_empty() || unsigned.len() > 4 || !digits(unsigned) {
                    return None;
                }
                text.parse().ok()?
            }
        };
        let value: f64 = text.parse().ok()?;
        let places = exponent - i32::try_from(fraction.len()).ok()?;
        // A division for negative powers: 10⁻² has no exact double.
        let power = 10_f64.powi(places.abs());
        let step = if places < 0 { 1.0 / power } else { power };
        (value.is_finite() && step.is_finite()).then_some(Self { value, step })
    }

    /// The same number in another unit: both parts times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            step: self.step * factor.abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_all_forms_and_the_weight_of_the_last_digit() {
        for (text, value, step) in [
            ("12", 12.0, 1.0),
            ("-0.50", -0.5, 0.01),
            (".5", 0.5, 0.1),
            ("1.", 1.0, 1.0),
            ("+110.14E+0", 110.14, 0.01),
            ("1234E-01", 123.4, 0.1),
            ("+1.2345e02", 123.45, 0.01),
            ("16E3", 16_000.0, 1000.0),
        ] {
            let number = Number::parse(text).unwrap();
            assert_eq!((number.value, number.step), (value, step), "{text}");
        }
    }

    #[test]
    fn words_units_and_halves_are_no_numbers() {
        for text in [
            "", "+", ".", "E3", "1E", "1E+", "NAN", "nan", "INF", "-inf", "infinity", "1.2V", " 1", "1 ", "1_0", "0x1",
            "--1", "1.2.3", "----", "1E400", "+1,2", "1E00005",
        ] {
            assert_eq!(Number::parse(text), None, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn a_printed_double_reads_back(value in proptest::num::f64::NORMAL) {
            let read = Number::parse(&format!("{value:e}")).unwrap();
            prop_assert_eq!(read.value, value);
        }

        #[test]
        fn noise_never_panics(text in "\\PC{0,12}") {
            if let Some(number) = Number::parse(&text) {
                prop_assert!(number.value.is_finite() && number.step > 0.0);
            }
        }
    }
}
