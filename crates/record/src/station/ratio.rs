//! Counts a degree or a millimetre as an exact ratio.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// A ratio of two whole numbers, `"n/d"` in files, both above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
pub struct Ratio {
    numerator: i64,
    denominator: i64,
}

/// A text that is no ratio of two positive whole numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a ratio \"n/d\" of two whole numbers above zero, for instance \"6400/9\"")]
pub struct NotARatio(String);

impl Ratio {
    /// n.
    pub const fn numerator(self) -> i64 {
        self.numerator
    }

    /// d.
    pub const fn denominator(self) -> i64 {
        self.denominator
    }

    /// n ÷ d, rounded to an f64.
    pub fn as_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

impl FromStr for Ratio {
    type Err = NotARatio;
    fn from_str(text: &str) -> Result<Self, NotARatio> {
        let fail = || NotARatio(text.to_owned());
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        let whole = |part: &str| {
            part.trim()
                .parse::<i64>()
                .ok()
                .filter(|&value| value > 0)
                .ok_or_else(fail)
        };
        Ok(Self {
            numerator: whole(numerator)?,
            denominator: whole(denominator)?,
        })
    }
}

impl<'de> Deserialize<'de> for Ratio {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl serde::de::Visitor<'_> for Text {
            type Value = Ratio;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a ratio")
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Ratio, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Text)
    }
}

impl From<Ratio> for String {
    fn from(ratio: Ratio) -> String {
        ratio.to_string()
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}
