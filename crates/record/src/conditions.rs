//! `[conditions]` of a job: the limits within which the conditions of a measurement have to lie, and what the bench
//! does not measure of them.
//!
//! The program has no limits of its own: they are those of the laboratory's edition of its standard, and stand in the
//! job that `init` writes.

use serde::{Deserialize, Serialize};

use crate::bounds::{Bounds, Stated};
use crate::document::Fault;

/// One condition as written.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Condition {
    /// Value that is aimed at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// Allowed difference from it, to either side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// The same relative to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance_rel: Option<f64>,
    /// Smallest value that is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Largest value that is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
    /// Standard uncertainty (k = 1) of what is measured, in the unit of the condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// What was measured beside the bench, where the bench does not: smallest and largest during the scan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<[f64; 2]>,
    /// Clause of the standard that sets the limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clause: Option<String>,
}

/// A key of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ConditionKey {
    /// Its name in the table, with its unit.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

/// Every condition that is judged, in the order of EN 13032-4, clauses 4.2 to 4.5.
pub const KEYS: [ConditionKey; 10] = [
    key("ambient_c", "ambient temperature", "°C"),
    key("air_movement_m_s", "air movement", "m/s"),
    key("orientation_rel", "change of the light with the burning position", ""),
    key("supply_voltage_v", "supply voltage", "V"),
    key("supply_frequency_hz", "supply frequency", "Hz"),
    key("supply_thd_rel", "harmonic distortion of the supply voltage", ""),
    key(
        "operating_time_min",
        "time in operation before the first reading",
        "min",
    ),
    key("stabilisation_rel", "stabilisation of the light, (max − min)/mean", ""),
    key(
        "power_stabilisation_rel",
        "stabilisation of the power, (max − min)/mean",
        "",
    ),
    key("distance_ratio", "distance ÷ luminous diameter", ""),
];

/// Those that direct current does not have.
const OF_AC: [&str; 2] = ["supply_frequency_hz", "supply_thd_rel"];

const fn key(name: &'static str, what: &'static str, unit: &'static str) -> ConditionKey {
    ConditionKey { name, what, unit }
}

/// What feeds the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SupplyKind {
    /// Alternating current.
    Ac,
    /// Direct current: it has no frequency and no harmonics.
    Dc,
}

/// `[conditions]` as written. What is not stated has no limit, and is not known to be met.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Conditions {
    /// Standard and edition that the limits were taken from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard: Option<String>,
    /// What feeds the lamp; without it alternating current.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply: Option<SupplyKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ambient_c: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    air_movement_m_s: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orientation_rel: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    supply_voltage_v: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    supply_frequency_hz: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    supply_thd_rel: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operating_time_min: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stabilisation_rel: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    power_stabilisation_rel: Option<Condition>,
    #[serde(skip_serializing_if = "Option::is_none")]
    distance_ratio: Option<Condition>,
}

impl Conditions {
    /// Every condition that the supply has, with its key, in the order of [`KEYS`]; none where nothing is stated of it.
    pub fn all(&self) -> Vec<(ConditionKey, Option<&Condition>)> {
        let stated = [
            &self.ambient_c,
            &self.air_movement_m_s,
            &self.orientation_rel,
            &self.supply_voltage_v,
            &self.supply_frequency_hz,
            &self.supply_thd_rel,
            &self.operating_time_min,
            &self.stabilisation_rel,
            &self.power_stabilisation_rel,
            &self.distance_ratio,
        ];
        let has = |key: &ConditionKey| self.supply != Some(SupplyKind::Dc) || !OF_AC.contains(&key.name);
        let all = KEYS.into_iter().zip(stated);
        all.filter(|(key, _)| has(key))
            .map(|(key, stated)| (key, stated.as_ref()))
            .collect()
    }

    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Refuses limits and measured values that say nothing.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        if self.supply == Some(SupplyKind::Dc) {
            let stated = [&self.supply_frequency_hz, &self.supply_thd_rel];
            if let Some((name, _)) = OF_AC.iter().zip(stated).find(|(_, stated)| stated.is_some()) {
                let message = "direct current has none; leave it out, or write supply = \"ac\"";
                return Err(Fault::new(format!("conditions.{name}"), message));
            }
        }
        for (key, stated) in self.all() {
            let Some(stated) = stated else { continue };
            let path = format!("conditions.{}", key.name);
            stated.limits(&path)?;
            if let Some(u) = stated.u.filter(|u| !(u.is_finite() && *u >= 0.0)) {
                return Err(Fault::new(
                    format!("{path}.u"),
                    format!("{u} is no standard uncertainty; write a number of at least 0"),
                ));
            }
            if let Some([least, most]) = stated.measured
                && !(least.is_finite() && most.is_finite() && least <= most)
            {
                return Err(Fault::new(
                    format!("{path}.measured"),
                    format!("[{least}, {most}] is no range; write the smallest and the largest value"),
                ));
            }
        }
        Ok(())
    }
}

impl Condition {
    /// The limits; none where none are stated. `path` is that of the table, for the fault.
    ///
    /// # Errors
    /// As [`Stated::bounds`].
    pub fn limits(&self, path: &str) -> Result<Option<Bounds>, Fault> {
        let stated = Stated {
            nominal: self.nominal,
            tolerance: self.tolerance,
            tolerance_rel: self.tolerance_rel,
            smallest: self.smallest,
            largest: self.largest,
        };
        let bounds = stated.bounds(path, "nominal")?;
        if bounds.is_none() && self.nominal.is_some() {
            return Err(Fault::new(
                format!("{path}.nominal"),
                "has no tolerance; state tolerance or tolerance_rel",
            ));
        }
        Ok(bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_table_is_known_by_its_name() {
        let text = KEYS.map(|key| format!("[{}]\nlargest = 1.0\n", key.name)).concat();
        let conditions: Conditions = toml::from_str(&text).unwrap();
        conditions.check().unwrap();
        assert!(conditions.all().iter().all(|(_, stated)| stated.is_some()));
        let again = toml::to_string(&conditions).unwrap();
        assert_eq!(toml::from_str::<Conditions>(&again).unwrap(), conditions);
    }

    #[test]
    fn what_says_nothing_is_refused_with_its_key() {
        for (text, path) in [
            ("[ambient_c]\nnominal = 25.0\n", "conditions.ambient_c.nominal"),
            ("[ambient_c]\nu = -0.1\n", "conditions.ambient_c.u"),
            (
                "[supply_thd_rel]\nmeasured = [2.0, 1.0]\n",
                "conditions.supply_thd_rel.measured",
            ),
            (
                "supply = \"dc\"\n[supply_thd_rel]\nlargest = 0.1\n",
                "conditions.supply_thd_rel",
            ),
            (
                "[distance_ratio]\nsmallest = inf\n",
                "conditions.distance_ratio.smallest",
            ),
        ] {
            let conditions: Conditions = toml::from_str(text).unwrap();
            assert_eq!(conditions.check().unwrap_err().path, path);
        }
    }
}
