//! `[limits]` of a plan: how far readings of a sound bench may differ before they are measured again or refused.

use serde::{Deserialize, Serialize};

use crate::document::Fault;
use crate::document::bounds::{above, within};

/// The table `[limits]` as written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LimitsDocument {
    /// See [`Limits::reference_rel`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_rel: Option<f64>,
    /// See [`Limits::drift_rel`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_rel: Option<f64>,
    /// See [`Limits::closing_rel`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closing_rel: Option<f64>,
    /// See [`Limits::power_spread_rel`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_spread_rel: Option<f64>,
    /// See [`Limits::repeats_sigma`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats_sigma: Option<f64>,
}

/// Valid limits. Whoever compares readings with them adds one digit of the display: what it rounds away is no
/// disagreement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    reference_rel: f64,
    drift_rel: f64,
    closing_rel: f64,
    power_spread_rel: f64,
    repeats_sigma: f64,
}

impl Limits {
    /// How far a visit to the reference point may lie from the one before in the same burning of the lamp, relative to
    /// that: a lamp that changes more from visit to visit has jumped, and no drift leads from one to the other.
    pub const fn reference_rel(&self) -> f64 {
        self.reference_rel
    }

    /// How far a visit to the reference point may lie from the median of its burning, relative to that: the largest
    /// drift that is corrected, and that a scan goes on with.
    pub const fn drift_rel(&self) -> f64 {
        self.drift_rel
    }

    /// The largest difference between the closing half-plane C 360° and C 0°, relative to the peak of that half-plane.
    pub const fn closing_rel(&self) -> f64 {
        self.closing_rel
    }

    /// The largest (max − min)/mean of the lamp's power over the window in which its light is watched, for a lamp to
    /// count as stable: LM-79 and EN 13032-4 ask for 0.5 % of light and of power. Where the station has no power meter,
    /// light decides.
    pub const fn power_spread_rel(&self) -> f64 {
        self.power_spread_rel
    }

    /// How far a repeat of a point may lie from the median of its repeats, in standard uncertainties of one reading.
    pub const fn repeats_sigma(&self) -> f64 {
        self.repeats_sigma
    }
}

impl Default for Limits {
    /// A lamp that has met the stabilisation of EN 13032-4 (0.5 % over 15 min, and falling) changes by less than 1 %
    /// between two visits; a correction of 2 % is twice that; six standard uncertainties are exceeded by chance once in
    /// 10⁹ readings.
    fn default() -> Self {
        Self {
            reference_rel: 0.01,
            drift_rel: 0.02,
            closing_rel: 0.02,
            power_spread_rel: 0.005,
            repeats_sigma: 6.0,
        }
    }
}

impl TryFrom<&LimitsDocument> for Limits {
    type Error = Fault;

    fn try_from(written: &LimitsDocument) -> Result<Self, Fault> {
        let default = Self::default();
        let fraction = |name: &str, value: Option<f64>, default: f64| {
            let unit = format!(" (a fraction, for instance {default})");
            above(&format!("limits.{name}"), value, 0.0..=1.0, &unit)?;
            Ok(value.unwrap_or(default))
        };
        let repeats_sigma = written.repeats_sigma.unwrap_or(default.repeats_sigma);
        let unit = " standard uncertainties, for instance 6";
        within("limits.repeats_sigma", repeats_sigma, 2.0..=100.0, unit)?;
        Ok(Self {
            reference_rel: fraction("reference_rel", written.reference_rel, default.reference_rel)?,
            drift_rel: fraction("drift_rel", written.drift_rel, default.drift_rel)?,
            closing_rel: fraction("closing_rel", written.closing_rel, default.closing_rel)?,
            power_spread_rel: fraction("power_spread_rel", written.power_spread_rel, default.power_spread_rel)?,
            repeats_sigma,
        })
    }
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;

    use super::*;
    use crate::Plan;
    use crate::plan::tests::PLAN;

    fn plan(limits: &str) -> Result<Plan, String> {
        let text = PLAN.replacen("[[block]]", &format!("[limits]\n{limits}\n[[block]]"), 1);
        Plan::parse(Utf8Path::new("p.toml"), &text).map_err(|error| error.to_string())
    }

    #[test]
    fn keys_that_are_left_out_have_their_default_and_the_table_is_kept() {
        let without = Plan::parse(Utf8Path::new("p.toml"), PLAN).unwrap();
        assert_eq!(without.limits(), &Limits::default());
        assert!(!toml::to_string(&without).unwrap().contains("limits"));
        let with = plan("drift_rel = 0.05").unwrap();
        assert_eq!((with.limits().drift_rel(), with.limits().reference_rel()), (0.05, 0.01));
        let again = Plan::parse(Utf8Path::new("again.toml"), &toml::to_string(&with).unwrap()).unwrap();
        assert_eq!(again, with);
    }

    #[test]
    fn what_cannot_be_meant_is_refused_with_its_line() {
        for (line, expected) in [
            ("reference_rel = 0.0", "limits.reference_rel: is 0"),
            ("drift_rel = nan", "limits.drift_rel: is NaN"),
            ("drift_rel = 1e308", "up to 1"),
            ("closing_rel = -0.02", "limits.closing_rel: is -0.02"),
            ("power_spread_rel = -0.5", "limits.power_spread_rel: is -0.5"),
            ("repeats_sigma = 0.5", "2 to 100"),
            ("repeats_sigma = inf", "limits.repeats_sigma: is inf"),
            ("repeat_sigma = 6.0", "unknown field `repeat_sigma`"),
        ] {
            let message = plan(line).unwrap_err();
            assert!(
                message.starts_with("p.toml:3:1: ") && message.contains(expected),
                "{line}: {message}"
            );
        }
    }
}
