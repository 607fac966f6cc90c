//! A number as people and programs write it into photometric files, or why it is none.

use isolux_units::digits::trimmed;
pub use isolux_units::digits::{plain, shortest};

/// Magnitudes above this are damage: the sun has 3·10²⁷ cd, no file here describes it, and a lost decimal point or a
/// stray exponent ends up there.
const LARGEST: f64 = 1e12;

/// Above this a value of a spectrum is damage, also for photons per second.
pub const LARGEST_SPECTRAL: f64 = 1e30;

/// A number that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Its value, finite.
    pub value: f64,
    /// It was written with a decimal comma.
    pub comma: bool,
}

/// Why a text is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotANumber {
    /// Nothing stands there.
    #[error("no number stands here")]
    Blank,
    /// It is NaN or infinite.
    #[error("this is not a finite number")]
    NotFinite,
    /// Its magnitude has no physical meaning in a photometric file.
    #[error("this number is larger than anything a photometric file can hold")]
    TooLarge,
    /// Something else than a number stands there.
    #[error("this is not a number")]
    Malformed,
}

/// Whether nothing but blanks stands there.
pub fn is_blank(text: &str) -> bool {
    matches!(read(text), Err(NotANumber::Blank))
}

/// Reads one number: sign, digits with point or comma, exponent; blanks around it are ignored.
///
/// # Errors
/// [`NotANumber`]; nothing is ever repaired, dropped or guessed.
pub fn read(text: &str) -> Result<Number, NotANumber> {
    read_up_to(text, LARGEST)
}

/// [`read`] with another bound on the magnitude: photons per second and square metre pass 10¹⁸.
///
/// # Errors
/// [`NotANumber`].
pub fn read_up_to(text: &str, largest: f64) -> Result<Number, NotANumber> {
    let bare = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_graphic);
    let text = if bare(text.as_bytes().first()) && bare(text.as_bytes().last()) {
        text
    } else {
        text.trim_matches([' ', '\t', '\u{a0}', '\0', '\u{1a}'])
    };
    if text.is_empty() {
        return Err(NotANumber::Blank);
    }
    let bytes = text.as_bytes();
    // `f64::from_str` also takes "nan", "inf" and "infinity"; a file's number begins with digit, point or sign.
    let unsigned = bytes
        .strip_prefix(b"-")
        .or_else(|| bytes.strip_prefix(b"+"))
        .unwrap_or(bytes);
    if !matches!(unsigned.first(), Some(b'0'..=b'9' | b'.' | b',')) {
        let word = std::str::from_utf8(unsigned).unwrap_or("").to_ascii_lowercase();
        let not_finite = ["nan", "inf"].iter().any(|name| word.starts_with(name));
        return Err(if not_finite {
            NotANumber::NotFinite
        } else {
            NotANumber::Malformed
        });
    }
    let (value, comma) = match text.parse::<f64>() {
        Ok(value) => (value, false),
        Err(_) => (with_comma(text).ok_or(NotANumber::Malformed)?, true),
    };
    if !value.is_finite() || value.abs() > largest {
        return Err(NotANumber::TooLarge);
    }
    Ok(Number { value, comma })
}

/// One decimal comma and no point.
fn with_comma(text: &str) -> Option<f64> {
    // `380,` is a number with a separator behind it.
    if text.contains('.') || text.matches(',').count() != 1 || text.ends_with(',') {
        return None;
    }
    text.replace(',', ".").parse().ok()
}

/// The shortest decimal notation of `value` that is at most `width` characters long and loses the least; plain
/// digits, no exponent, as the old formats want it.
pub fn fitted(value: f64, width: usize) -> String {
    let full = plain(value);
    if full.len() <= width {
        return full;
    }
    for decimals in (0..12).rev() {
        let text = trimmed(format!("{value:.decimals$}"));
        if text.len() <= width {
            return text;
        }
    }
    format!("{value:.0}")
}

/// The number at the beginning of a text such as "4000 K" or "80-89", if it stands there alone.
pub(crate) fn decimal(text: &str) -> Option<String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_alphabetic() || c == ' ');
    read(digits)
        .ok()
        .filter(|number| number.value > 0.0)
        .map(|number| plain(number.value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_a_number_and_what_is_not() {
        assert_eq!(read(" 12.5 ").map(|n| n.value), Ok(12.5));
        assert_eq!(read("-1").map(|n| n.value), Ok(-1.0));
        assert_eq!(read(".5").map(|n| n.value), Ok(0.5));
        assert_eq!(read("1.0E+02").map(|n| n.value), Ok(100.0));
        assert_eq!(
            read("12,5"),
            Ok(Number {
                value: 12.5,
                comma: true
            })
        );
        assert_eq!(read(""), Err(NotANumber::Blank));
        assert_eq!(read("NaN"), Err(NotANumber::NotFinite));
        assert_eq!(read("-inf"), Err(NotANumber::NotFinite));
        assert_eq!(read("1e300"), Err(NotANumber::TooLarge));
        assert_eq!(read("1e999"), Err(NotANumber::TooLarge));
        for damaged in ["1O5", "12.3.4", "1,2,3", "1.234,5", "abc", "--1", "1e", "0x10", "12 3"] {
            assert_eq!(read(damaged), Err(NotANumber::Malformed), "{damaged}");
        }
    }

    #[test]
    fn numbers_fit_their_field() {
        assert_eq!(fitted(1234.5678, 6), "1234.6");
        assert_eq!(fitted(0.000_012, 12), "0.000012");
        assert_eq!(fitted(99.9999, 4), "100");
        assert_eq!(fitted(-0.000_000_1, 4), "0");
        assert_eq!(shortest(1234.56789123, 8), "1234.5679");
        assert_eq!(shortest(0.5, 8), "0.5");
    }

    proptest! {
        #[test]
        fn plain_reads_back(value in -1e9..1e9f64) {
            prop_assert_eq!(read(&plain(value)).map(|n| n.value), Ok(value));
        }
    }
}
