//! Limits as a person writes them: `smallest`, `largest`, or a `nominal` value with its tolerance.

use serde::{Deserialize, Serialize};

use crate::document::Fault;

/// What a value has to keep, in its own unit. Either end may be missing, not both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Smallest value that is allowed.
    pub smallest: Option<f64>,
    /// Largest value that is allowed.
    pub largest: Option<f64>,
}

/// The keys that state [`Bounds`] in a table.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stated {
    /// Value that is aimed at, or rated.
    pub nominal: Option<f64>,
    /// Allowed difference from it, to either side, in its unit.
    pub tolerance: Option<f64>,
    /// The same relative to it.
    pub tolerance_rel: Option<f64>,
    /// Smallest value.
    pub smallest: Option<f64>,
    /// Largest value.
    pub largest: Option<f64>,
}

impl Stated {
    /// The limits in the table at `path`, whose word for the nominal value is `nominal`; none where it states none.
    ///
    /// # Errors
    /// [`Fault`] for numbers that are not finite, a tolerance without the value that it belongs to, two statements of
    /// the same limits, limits that leave no value.
    pub fn bounds(&self, path: &str, nominal: &str) -> Result<Option<Bounds>, Fault> {
        let fault = |key: &str, message: String| Err(Fault::new(format!("{path}.{key}"), message));
        let keys = [
            (nominal, self.nominal),
            ("tolerance", self.tolerance),
            ("tolerance_rel", self.tolerance_rel),
            ("smallest", self.smallest),
            ("largest", self.largest),
        ];
        for (key, value) in keys {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                return fault(key, format!("{value} is no number to compare with"));
            }
        }
        for (key, value) in &keys[1..3] {
            if let Some(value) = value.filter(|value| value <= &0.0) {
                return fault(
                    key,
                    format!("{value} leaves no value; write the allowed difference, above 0"),
                );
            }
        }
        let tolerance = match (self.nominal, self.tolerance, self.tolerance_rel) {
            (_, Some(_), Some(_)) => {
                return fault("tolerance_rel", "state tolerance or tolerance_rel, not both".to_owned());
            }
            (None, Some(_), None) => {
                return fault("tolerance", format!("belongs to a `{nominal}` value; state that too"));
            }
            (None, None, Some(_)) => {
                return fault(
                    "tolerance_rel",
                    format!("belongs to a `{nominal}` value; state that too"),
                );
            }
            (Some(0.0), None, Some(_)) => {
                return fault("tolerance_rel", format!("is nothing of {nominal} = 0; state tolerance"));
            }
            (Some(value), None, Some(rel)) => Some((value, rel * value.abs())),
            (Some(value), Some(tolerance), None) => Some((value, tolerance)),
            (_, None, None) => None,
        };
        match (tolerance, self.smallest, self.largest) {
            (Some(_), Some(_), _) => fault(
                "smallest",
                format!("the limits are stated by {nominal} and tolerance already"),
            ),
            (Some(_), _, Some(_)) => fault(
                "largest",
                format!("the limits are stated by {nominal} and tolerance already"),
            ),
            (Some((value, tolerance)), None, None) => Ok(Some(Bounds {
                smallest: Some(value - tolerance),
                largest: Some(value + tolerance),
            })),
            (None, Some(smallest), Some(largest)) if smallest > largest => fault(
                "smallest",
                format!("{smallest} is above largest = {largest}: no value keeps both"),
            ),
            (None, None, None) => Ok(None),
            (None, smallest, largest) => Ok(Some(Bounds { smallest, largest })),
        }
    }
}

impl Bounds {
    /// Whether `value` lies within, the limits included.
    pub fn hold(&self, value: f64) -> bool {
        self.smallest.is_none_or(|smallest| value >= smallest) && self.largest.is_none_or(|largest| value <= largest)
    }

    /// Both ends nearer to each other by `by` each: an acceptance interval (JCGM 106, 3.3.9).
    #[must_use]
    pub fn narrowed(&self, by: f64) -> Self {
        Self {
            smallest: self.smallest.map(|smallest| smallest + by),
            largest: self.largest.map(|largest| largest - by),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_stated_in_one_of_three_ways() {
        let rated = Stated {
            nominal: Some(230.0),
            tolerance_rel: Some(0.004),
            ..Stated::default()
        };
        let bounds = rated.bounds("a", "nominal").unwrap().unwrap();
        assert!(bounds.hold(230.92) && !bounds.hold(230.93) && bounds.hold(229.08) && !bounds.hold(229.07));
        assert!(!bounds.narrowed(0.1).hold(230.9) && bounds.narrowed(0.1).hold(230.8));
        let one = Stated {
            largest: Some(0.25),
            ..Stated::default()
        };
        assert!(one.bounds("a", "nominal").unwrap().unwrap().hold(-1.0));
        assert_eq!(Stated::default().bounds("a", "nominal").unwrap(), None);
        let nothing = Stated::default();
        let wrong = [
            (
                "a.tolerance",
                Stated {
                    tolerance: Some(1.0),
                    ..nothing
                },
            ),
            (
                "a.tolerance_rel",
                Stated {
                    tolerance: Some(1.0),
                    ..rated
                },
            ),
            (
                "a.tolerance_rel",
                Stated {
                    nominal: Some(0.0),
                    ..rated
                },
            ),
            (
                "a.tolerance_rel",
                Stated {
                    tolerance_rel: Some(0.0),
                    ..rated
                },
            ),
            (
                "a.smallest",
                Stated {
                    smallest: Some(1.0),
                    ..rated
                },
            ),
            (
                "a.largest",
                Stated {
                    largest: Some(1.0),
                    ..rated
                },
            ),
            (
                "a.smallest",
                Stated {
                    smallest: Some(2.0),
                    largest: Some(1.0),
                    ..nothing
                },
            ),
            (
                "a.nominal",
                Stated {
                    nominal: Some(f64::NAN),
                    ..rated
                },
            ),
        ];
        for (path, stated) in wrong {
            assert_eq!(stated.bounds("a", "nominal").unwrap_err().path, path, "{stated:?}");
        }
    }
}
