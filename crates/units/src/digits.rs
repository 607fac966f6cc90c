//! Digits that a value and its uncertainty deserve (JCGM 100, 7.2.6).

/// Coverage factor of every expanded uncertainty that is printed: about 95 % for a normal distribution.
pub const K: f64 = 2.0;

/// A value and its expanded uncertainty, both to the same decimal place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rounded {
    /// The value.
    pub value: String,
    /// Its expanded uncertainty.
    pub expanded: String,
}

/// Rounds the expanded uncertainty to one significant digit, to two where it begins with 1 or 2, and the value to the
/// same place; neither is finer than `finest`, the power of ten of the last digit that means something in this unit.
///
/// ```
/// # use isolux_units::digits::rounded;
/// let cct = rounded(5896.69, 12.7, 0);
/// assert_eq!((cct.value.as_str(), cct.expanded.as_str()), ("5897", "13"));
/// ```
pub fn rounded(value: f64, expanded: f64, finest: i32) -> Rounded {
    let place = place_of(expanded).unwrap_or(-3).max(finest);
    Rounded {
        value: at_place(value, place),
        expanded: at_place(expanded, place),
    }
}

/// A value with its expanded uncertainty for a standard uncertainty `u`: `5897 ± 25 K (k = 2)`.
pub fn stated(value: f64, u: f64, unit: &str) -> String {
    let stated = rounded(value, K * u, -12);
    format!("{} ± {} {unit} (k = 2)", stated.value, stated.expanded)
}

/// A value alone, to the place that its expanded uncertainty leaves.
pub fn value_at(value: f64, expanded: f64, finest: i32) -> String {
    rounded(value, expanded, finest).value
}

/// A number to `digits` significant digits, without an exponent.
pub fn significant(value: f64, digits: i32) -> String {
    match exponent(value) {
        Some(exponent) => at_place(value, exponent + 1 - digits),
        None => at_place(value, 0),
    }
}

/// Plain digits without an exponent: as many significant ones as are asked for, all before the point, no zero at the
/// end behind it.
///
/// ```
/// # use isolux_units::digits::{shortest, significant};
/// assert_eq!((shortest(1234.5, 2), shortest(0.5, 3)), ("1234".to_owned(), "0.5".to_owned()));
/// assert_eq!((significant(1234.5, 2), significant(0.5, 3)), ("1200".to_owned(), "0.500".to_owned()));
/// ```
pub fn shortest(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    // A digit more or less next to a power of ten is a zero that goes: no text is needed to find the exponent.
    let exponent = value.abs().log10().floor() as i32;
    let text = trimmed(format!("{value:.*}", (digits - 1 - exponent).clamp(0, 30) as usize));
    let whole = plain(value);
    if whole.len() <= text.len() { whole } else { text }
}

/// The shortest decimal notation that reads back as the same `f64`; plain digits, no exponent, no negative zero.
pub fn plain(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value}")
    }
}

/// Without the zeros at the end behind the point, and without a negative zero.
pub fn trimmed(text: String) -> String {
    if !text.contains('.') {
        return text;
    }
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" || text == "-" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

/// Power of ten of the last digit of an uncertainty; none for zero and what is not finite.
pub fn place_of(expanded: f64) -> Option<i32> {
    let exponent = exponent(expanded)?;
    // From the shortest text: 0.3 ÷ 0.1 is not 3.
    let first = format!("{:e}", expanded.abs()).as_bytes()[0];
    Some(if first < b'3' { exponent - 1 } else { exponent })
}

/// Power of ten of the first digit.
fn exponent(value: f64) -> Option<i32> {
    (value != 0.0 && value.is_finite()).then(|| {
        // Through the shortest text: log10 is off by one next to powers of ten.
        let text = format!("{value:e}");
        text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok())
    })?
}

/// The number with its last digit at 10^`place`.
fn at_place(value: f64, place: i32) -> String {
    let text = if place > 0 {
        let step = 10f64.powi(place);
        format!("{:.0}", (value / step).round() * step)
    } else {
        format!("{value:.*}", place.unsigned_abs().min(12) as usize)
    };
    // A negative zero says nothing.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_uncertainty_rules_the_digits() {
        for (value, expanded, finest, wanted) in [
            (5896.69, 12.7, 0, ("5897", "13")),
            (5896.69, 1.76, 0, ("5897", "2")),
            (336.981, 2.43, -9, ("337.0", "2.4")),
            (336.981, 3.43, -9, ("337", "3")),
            (336.981, 0.97, -9, ("337.0", "1.0")),
            (12_345.0, 260.0, -9, ("12350", "260")),
            (12_345.0, 960.0, -9, ("12300", "1000")),
            (0.004_567, 0.000_11, -9, ("0.00457", "0.00011")),
            (1.0, 0.1, -9, ("1.00", "0.10")),
            (-0.000_4, 0.3, -9, ("0.0", "0.3")),
            (8.25, 0.0, -9, ("8.250", "0.000")),
        ] {
            let stated = rounded(value, expanded, finest);
            assert_eq!(
                (stated.value.as_str(), stated.expanded.as_str()),
                wanted,
                "{value} ± {expanded}"
            );
        }
    }

    #[test]
    fn a_number_without_uncertainty_keeps_what_it_is_asked_for() {
        assert_eq!(significant(1234.5, 2), "1200");
        assert_eq!(significant(0.012_345, 3), "0.0123");
        assert_eq!(significant(0.0, 3), "0");
    }
}
