//! Numbers in JSON, which has no word for one that is not finite: it is written as null.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

/// A number that was written as null where it was not finite; then it is NaN.
///
/// # Errors
/// What is neither a number nor null.
pub fn nan_if_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// The same of the values of an object.
///
/// # Errors
/// As [`nan_if_null`].
pub fn nan_for_nulls<'de, K, D>(from: D) -> Result<BTreeMap<K, f64>, D::Error>
where
    K: Deserialize<'de> + Ord,
    D: Deserializer<'de>,
{
    let found = BTreeMap::<K, Option<f64>>::deserialize(from)?.into_iter();
    Ok(found.map(|(name, value)| (name, value.unwrap_or(f64::NAN))).collect())
}
