//! Numbers that a document may hold.

use std::ops::RangeInclusive;

use crate::Fault;

/// A value in `range`, both ends included; nothing is in every range. `unit` stands behind the range in the message.
///
/// # Errors
/// [`Fault`] of the key at `path`, with the value and the range.
pub fn within(path: &str, value: impl Into<Option<f64>>, range: RangeInclusive<f64>, unit: &str) -> Result<(), Fault> {
    let (low, high) = (shown(*range.start()), shown(*range.end()));
    hold(
        path,
        value.into(),
        |value| range.contains(&value),
        &format!("{low} to {high}{unit}"),
    )
}

/// A value in `range` without its lower end.
///
/// # Errors
/// As [`within`].
pub fn above(path: &str, value: impl Into<Option<f64>>, range: RangeInclusive<f64>, unit: &str) -> Result<(), Fault> {
    let (low, high) = (shown(*range.start()), shown(*range.end()));
    let inside = |value: f64| range.contains(&value) && value > *range.start();
    hold(
        path,
        value.into(),
        inside,
        &format!("above {low} and up to {high}{unit}"),
    )
}

fn hold(path: &str, value: Option<f64>, holds: impl Fn(f64) -> bool, expected: &str) -> Result<(), Fault> {
    match value {
        Some(value) if !holds(value) => Err(Fault::new(path, format!("is {}, expected {expected}", shown(value)))),
        _ => Ok(()),
    }
}

/// A number without three hundred zeros.
fn shown(value: f64) -> String {
    if value != 0.0 && value.is_finite() && !(1e-6..1e9).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_outside_is_stated_with_its_range() {
        assert!(within("a", 1.0, 1.0..=2.0, "").is_ok() && within("a", None, 1.0..=2.0, "").is_ok());
        assert!(above("a", 2.0, 1.0..=2.0, "").is_ok() && above("a", 1.0, 1.0..=2.0, "").is_err());
        for value in [0.5, -1.0, f64::NAN, f64::INFINITY] {
            assert!(within("a", value, 1.0..=2.0, "").is_err() && above("a", value, 1.0..=2.0, "").is_err());
        }
        let said = |result: Result<(), Fault>| result.unwrap_err().to_string();
        assert_eq!(
            said(within("a.b", 1e308, 1e-9..=1e6, " mm")),
            "a.b: is 1e308, expected 1e-9 to 1000000 mm"
        );
        assert_eq!(
            said(above("a", 0.0, 0.0..=1e9, "")),
            "a: is 0, expected above 0 and up to 1e9"
        );
    }
}
