//! A number with its standard uncertainty, the parts of it, and what is not in it.

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_units::digits::{K, Rounded, rounded};
use isolux_units::json::{nan_for_nulls, nan_if_null};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One number with its standard uncertainty and the parts of it. Where a part was neither measured nor stated, the
/// number has no uncertainty: what is left out would make it smaller, and a reader would take the number for better
/// than it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantity {
    /// The number.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// Standard uncertainty (k = 1); none where `missing` says what is not known.
    pub u: Option<f64>,
    /// What the known parts give: the uncertainty of the number only where nothing is missing.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub u_of_parts: f64,
    /// The known parts by name, in the same unit; they add in squares.
    #[serde(deserialize_with = "nan_for_nulls")]
    #[schemars(with = "BTreeMap<String, Option<f64>>")]
    pub parts: BTreeMap<Cow<'static, str>, f64>,
    /// What was neither measured nor stated, one phrase each.
    pub missing: Vec<String>,
}

impl Quantity {
    /// A quantity from its parts, nothing missing.
    pub fn new(
        value: f64,
        unit: impl Into<Cow<'static, str>>,
        parts: impl IntoIterator<Item = (impl Into<Cow<'static, str>>, f64)>,
    ) -> Self {
        let parts = parts.into_iter().map(|(name, part)| (name.into(), part.abs()));
        let parts: BTreeMap<_, _> = parts.collect();
        let u_of_parts = parts.values().map(|part| part * part).sum::<f64>().sqrt();
        Self {
            value,
            unit: unit.into(),
            u: Some(u_of_parts),
            u_of_parts,
            parts,
            missing: Vec::new(),
        }
    }

    /// The same quantity, of which these parts are not known.
    #[must_use]
    pub fn lacking(mut self, missing: impl IntoIterator<Item = String>) -> Self {
        for phrase in missing {
            if !self.missing.contains(&phrase) {
                self.missing.push(phrase);
            }
        }
        if !self.missing.is_empty() {
            self.u = None;
        }
        self
    }

    /// The same quantity with one more part.
    #[must_use]
    pub fn with_part(&self, name: &'static str, part: f64) -> Self {
        let parts = self.parts.clone().into_iter().chain([(name.into(), part)]);
        Self::new(self.value, self.unit.clone(), parts).lacking(self.missing.iter().cloned())
    }

    /// The same quantity without one of its parts, for a comparison that tests just that.
    #[must_use]
    pub fn without_part(&self, name: &str) -> Self {
        let parts = self.parts.clone().into_iter().filter(|(part, _)| part != name);
        Self::new(self.value, self.unit.clone(), parts).lacking(self.missing.iter().cloned())
    }

    /// The value and its expanded uncertainty (k = 2) of the known parts, to the digits that the uncertainty leaves. A
    /// colour temperature is stated to 1 K, as photometric reports have it.
    pub fn rounded(&self) -> Rounded {
        let finest = if self.unit == "K" { 0 } else { -9 };
        rounded(self.value, K * self.u_of_parts, finest)
    }

    /// As reports state it: the value and its expanded uncertainty (k = 2), to the digits of the latter; where
    /// something is missing in the uncertainty, the value and what is missing.
    pub fn stated(&self) -> String {
        let stated = self.rounded();
        // A chromaticity has no unit; the sign of degrees stands close to its number.
        let unit = match self.unit.as_ref() {
            unit @ ("" | "°") => unit.to_owned(),
            unit => format!(" {unit}"),
        };
        match self.u {
            Some(_) => format!("{} ± {}{unit} (k = 2)", stated.value, stated.expanded),
            None => format!("{}{unit}, {}", stated.value, no_uncertainty(&self.missing)),
        }
    }

    /// As [`stated`](Self::stated), without what is missing: for a table that names it once.
    pub fn brief(&self) -> String {
        if self.u.is_some() {
            return self.stated();
        }
        let unit = match self.unit.as_ref() {
            unit @ ("" | "°") => unit.to_owned(),
            unit => format!(" {unit}"),
        };
        format!("{}{unit}", self.rounded().value)
    }

    /// Relative standard uncertainty, where nothing is missing.
    pub fn u_rel(&self) -> Option<f64> {
        self.u.map(|u| u / self.value.abs())
    }

    /// The known parts relative to the value.
    pub fn u_of_parts_rel(&self) -> f64 {
        self.u_of_parts / self.value.abs()
    }

    /// The same times a constant, in another unit.
    #[must_use]
    pub fn times(&self, factor: f64, unit: &'static str) -> Self {
        let parts = self.parts.iter().map(|(name, part)| (name.clone(), part * factor));
        Self::new(self.value * factor, unit, parts).lacking(self.missing.iter().cloned())
    }

    /// The same times another, independent quantity, whose parts become one.
    #[must_use]
    pub fn by(&self, other: &Self, unit: &'static str, name: &'static str) -> Self {
        let product = self.times(other.value, unit);
        let part = product.value * other.u_of_parts_rel();
        product.with_part(name, part).lacking(other.missing.iter().cloned())
    }

    /// The same divided by another, independent quantity, whose parts become one.
    #[must_use]
    pub fn over(&self, other: &Self, unit: &'static str, name: &'static str) -> Self {
        let value = self.value / other.value;
        let parts = self
            .parts
            .iter()
            .map(|(name, part)| (name.clone(), part / other.value))
            .chain([(name.into(), value * other.u_of_parts_rel())]);
        Self::new(value, unit, parts).lacking(self.missing.iter().chain(&other.missing).cloned())
    }
}

/// Why a number has no ±.
pub fn no_uncertainty(missing: &[String]) -> String {
    format!("no uncertainty: {}", missing.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_takes_the_uncertainty_away_and_is_inherited() {
        let whole = Quantity::new(10.0, "lm", [("noise", 0.3), ("digit", 0.4)]);
        assert_eq!(whole.u, Some(0.5));
        assert_eq!(whole.without_part("digit").u, Some(0.3));
        let lacking = whole.clone().lacking(["not corrected for stray light".to_owned()]);
        assert_eq!((lacking.u, lacking.u_rel(), lacking.u_of_parts), (None, None, 0.5));
        let other = Quantity::new(5.0, "lm/W", [("noise", 0.1)]);
        assert!(whole.over(&other, "W", "efficacy").u.is_some());
        for made in [
            lacking.over(&other, "W", "efficacy"),
            other.over(&lacking, "W", "flux"),
            lacking.with_part("drift", 1.0),
        ] {
            assert_eq!((made.u, &made.missing), (None, &lacking.missing));
        }
    }
}
