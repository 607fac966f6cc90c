//! `[requirements]` of a job: what the measured luminaire has to keep, and by which rule that is decided.

use serde::{Deserialize, Serialize};

use crate::bounds::{Bounds, Stated};
use crate::document::Fault;

/// What a quantity is measured with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuredWith {
    /// The lux meter over the distribution.
    LuxMeter,
    /// A power meter.
    PowerMeter,
    /// A spectrum on the axis.
    Spectrum,
    /// Spectra over angle.
    SpectraOverAngle,
    /// A record of the light over time.
    Waveform,
}

/// A quantity that can be required.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuantityKey {
    /// Its name, with its unit.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// What it is measured with.
    pub with: MeasuredWith,
}

/// Every quantity that can be required.
pub const QUANTITIES: &[QuantityKey] = &[
    quantity("flux_lm", "luminous flux", MeasuredWith::LuxMeter),
    quantity("i_max_cd", "largest luminous intensity", MeasuredWith::LuxMeter),
    quantity("beam_deg", "beam angle (50 %)", MeasuredWith::LuxMeter),
    quantity("field_deg", "field angle (10 %)", MeasuredWith::LuxMeter),
    quantity(
        "sensor_illuminance_lx",
        "mean illuminance of the sensor",
        MeasuredWith::LuxMeter,
    ),
    quantity(
        "sensor_irradiance_w_m2",
        "mean irradiance of the sensor",
        MeasuredWith::Spectrum,
    ),
    quantity("power_w", "active power", MeasuredWith::PowerMeter),
    quantity("efficacy_lm_w", "luminous efficacy", MeasuredWith::PowerMeter),
    quantity("cct_k", "correlated colour temperature", MeasuredWith::Spectrum),
    quantity("duv", "Duv", MeasuredWith::Spectrum),
    quantity("x", "chromaticity x", MeasuredWith::Spectrum),
    quantity("y", "chromaticity y", MeasuredWith::Spectrum),
    quantity("u_prime", "chromaticity u′", MeasuredWith::Spectrum),
    quantity("v_prime", "chromaticity v′", MeasuredWith::Spectrum),
    quantity("ra", "colour rendering index Ra", MeasuredWith::Spectrum),
    quantity("r9", "colour rendering index R9", MeasuredWith::Spectrum),
    quantity("rf", "colour fidelity index Rf", MeasuredWith::Spectrum),
    quantity("rg", "colour gamut index Rg", MeasuredWith::Spectrum),
    quantity(COLOUR_STEPS, "colour steps from the centre", MeasuredWith::Spectrum),
    quantity(
        "total_cct_k",
        "correlated colour temperature of all light",
        MeasuredWith::SpectraOverAngle,
    ),
    quantity(
        "total_ra",
        "colour rendering index Ra of all light",
        MeasuredWith::SpectraOverAngle,
    ),
    quantity("svm", "stroboscopic visibility measure SVM", MeasuredWith::Waveform),
    quantity("pst_lm", "short-term flicker severity PstLM", MeasuredWith::Waveform),
    quantity("modulation_depth_percent", "modulation depth", MeasuredWith::Waveform),
    quantity("flicker_index", "flicker index", MeasuredWith::Waveform),
    quantity(
        "delta_u_prime_v_prime",
        "Δu′v′ over angle",
        MeasuredWith::SpectraOverAngle,
    ),
];

/// Distance from a centre in u′v′ ÷ 0.0011, the radius of one step of a colour circle (CIE TN 001).
pub const COLOUR_STEPS: &str = "colour_steps";

const fn quantity(name: &'static str, what: &'static str, with: MeasuredWith) -> QuantityKey {
    QuantityKey { name, what, with }
}

/// How the uncertainty of a result enters the decision (ISO/IEC 17025, 3.7 and 7.8.6; ILAC-G8:09/2019, 4.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DecisionRule {
    /// The value itself is compared with the limit; the probability of a false decision is stated.
    Simple,
    /// Passes where the value keeps the limit by U (k = 2), fails where it misses it by U, and is not decided between.
    Guarded,
    /// As simple, where U is not above what was agreed as `largest_u`; not decided where it is.
    SharedRisk,
}

impl DecisionRule {
    /// The rule as a report names it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Simple => "simple acceptance",
            Self::Guarded => "guarded by U",
            Self::SharedRisk => "shared risk",
        }
    }
}

/// One requirement as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    /// Which quantity, by the name that the report's `conformity.json` has for it.
    pub quantity: String,
    /// Rated value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rated: Option<f64>,
    /// Allowed difference from it, to either side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// The same relative to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_rel: Option<f64>,
    /// Smallest value that is allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Largest value that is allowed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
    /// Centre u′, v′ of the circle of `colour_steps`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<[f64; 2]>,
    /// Another rule than that of the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<DecisionRule>,
    /// Largest expanded uncertainty (k = 2) that was agreed for `shared_risk`, in the unit of the quantity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest_u: Option<f64>,
    /// Where the limit comes from: contract, regulation and clause.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// `[requirements]` as written.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Requirements {
    /// The rule of every limit that states none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rule: Option<DecisionRule>,
    /// The limits.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub limit: Vec<Requirement>,
}

impl Requirement {
    /// The quantity; none for a name that is not known.
    pub fn key(&self) -> Option<&'static QuantityKey> {
        QUANTITIES.iter().find(|key| key.name == self.quantity)
    }

    /// The limits. `path` is that of the table, for the fault.
    ///
    /// # Errors
    /// As [`Stated::bounds`]; where there is none.
    pub fn limits(&self, path: &str) -> Result<Bounds, Fault> {
        let stated = Stated {
            nominal: self.rated,
            tolerance: self.tolerance,
            tolerance_rel: self.tolerance_rel,
            smallest: self.smallest,
            largest: self.largest,
        };
        stated.bounds(path, "rated")?.ok_or_else(|| {
            Fault::new(
                format!("{path}.quantity"),
                format!(
                    "{} has no limit; state smallest, largest, or rated with tolerance or tolerance_rel",
                    self.quantity
                ),
            )
        })
    }
}

impl Requirements {
    /// Whether nothing is required.
    pub fn is_empty(&self) -> bool {
        self.limit.is_empty()
    }

    /// The rule of a limit; none where neither it nor the table states one.
    pub fn rule_of(&self, limit: &Requirement) -> Option<DecisionRule> {
        limit.rule.or(self.rule)
    }

    /// Refuses limits that cannot be decided whatever is measured.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        for (place, limit) in self.limit.iter().enumerate() {
            let path = format!("requirements.limit.{place}");
            limit.limits(&path)?;
            let fault = |key: &str, message: &str| Err(Fault::new(format!("{path}.{key}"), message));
            if limit.key().is_none() {
                let known: Vec<&str> = QUANTITIES.iter().map(|key| key.name).collect();
                let message = format!(
                    "{} is no quantity that can be required; there are {}",
                    limit.quantity,
                    known.join(", ")
                );
                return fault("quantity", &message);
            }
            match (limit.quantity == COLOUR_STEPS, limit.centre) {
                (true, None) => return fault("quantity", "colour_steps needs centre = [u′, v′]"),
                (false, Some(_)) => return fault("centre", "belongs to colour_steps"),
                (true, Some(centre)) if !centre.iter().all(|value| (0.0..=1.0).contains(value)) => {
                    return fault("centre", "is no chromaticity; write u′ and v′, each from 0 to 1");
                }
                _ => {}
            }
            let Some(rule) = self.rule_of(limit) else {
                return fault(
                    "quantity",
                    "has no decision rule; state rule = \"simple\", \"guarded\" or \"shared_risk\" in [requirements], as agreed \
                     with the customer (ISO/IEC 17025, 7.1.3)",
                );
            };
            match (rule, limit.largest_u) {
                (DecisionRule::SharedRisk, None) => {
                    return fault(
                        "quantity",
                        "shared_risk needs largest_u, the expanded uncertainty that was agreed",
                    );
                }
                (DecisionRule::SharedRisk, Some(u)) if !(u.is_finite() && u > 0.0) => {
                    return fault("largest_u", "is no expanded uncertainty; write a number above 0");
                }
                (DecisionRule::Simple | DecisionRule::Guarded, Some(_)) => {
                    return fault("largest_u", "belongs to the rule shared_risk");
                }
                _ => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_needs_bounds_and_a_rule() {
        let check = |text: &str| toml::from_str::<Requirements>(text).unwrap().check();
        let limit = "[[limit]]\nquantity = \"flux_lm\"\n";
        assert!(check(&format!("rule = \"simple\"\n{limit}smallest = 300.0\n")).is_ok());
        assert!(
            check(&format!(
                "{limit}rule = \"guarded\"\nrated = 337.0\ntolerance_rel = 0.1\n"
            ))
            .is_ok()
        );
        for (text, key) in [
            (format!("rule = \"simple\"\n{limit}"), "quantity"),
            (format!("{limit}smallest = 300.0\n"), "quantity"),
            (
                format!(
                    "rule = \"simple\"\n{}smallest = 300.0\n",
                    limit.replace("flux", "fluxes")
                ),
                "quantity",
            ),
            (
                format!("rule = \"simple\"\n{limit}smallest = 300.0\ncentre = [0.2, 0.5]\n"),
                "centre",
            ),
            (format!("rule = \"shared_risk\"\n{limit}smallest = 300.0\n"), "quantity"),
            (
                format!("rule = \"shared_risk\"\n{limit}smallest = 300.0\nlargest_u = 0.0\n"),
                "largest_u",
            ),
            (
                format!("rule = \"simple\"\n{limit}smallest = 300.0\nlargest_u = 5.0\n"),
                "largest_u",
            ),
            (
                format!("rule = \"simple\"\n{limit}rated = 300.0\nsmallest = 5.0\ntolerance = 1.0\n"),
                "smallest",
            ),
        ] {
            let fault = check(&text).unwrap_err();
            assert_eq!(fault.path, format!("requirements.limit.0.{key}"), "{text}");
        }
    }
}
