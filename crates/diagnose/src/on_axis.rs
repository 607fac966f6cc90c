//! The comparison on the axis: what the spectroradiometer read on the axis against what the simulation says there.
//!
//! The distribution was measured with the lux meter far away, the spectrum with another instrument close by. Their
//! agreement tests near field, distance and calibration at once, and no part of it was fitted.

use isolux_model::luminous_area_rel;
use isolux_reduce::{NEAR_FIELD_AT_SENSOR, Reduction, no_uncertainty};
use isolux_units::digits::{significant, stated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A gap beyond this many standard uncertainties is a disagreement.
const DISAGREES_SIGMA: f64 = 2.0;

/// Measured and simulated irradiance on the axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Distance of the spectroradiometer from the light centre.
    pub distance_mm: f64,
    /// Measured spectral irradiance, summed over 360–830 nm, in W/m².
    pub measured_w_m2: Stated,
    /// The same in lx.
    pub measured_lx: Stated,
    /// Simulated irradiance with the model's emitter, in W/m².
    pub simulated_w_m2: Stated,
    /// The same in lx.
    pub simulated_lx: Stated,
    /// (simulated − measured)/measured.
    pub gap_rel: f64,
    /// The gap in standard uncertainties of the difference; null where something is missing in them.
    pub gap_sigma: Option<f64>,
    /// What is missing in them, one phrase each.
    pub missing: Vec<String>,
    /// Relative standard uncertainty by where in the luminous area the light leaves; in the σ above.
    pub luminous_area_rel: f64,
}

impl Comparison {
    /// The comparison in words.
    pub fn sentences(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "test, axis at {:.0} mm  measured {} or {}, simulated {} or {}",
            self.distance_mm,
            self.measured_w_m2.text("W/m²"),
            self.measured_lx.text("lx"),
            self.simulated_w_m2.text("W/m²"),
            self.simulated_lx.text("lx"),
        )];
        lines.push(format!("gap                   {}", self.gap_text()));
        lines
    }

    /// The gap with what it is worth.
    pub fn gap_text(&self) -> String {
        match self.gap_sigma {
            Some(_) => gap_words(self.gap_rel, self.gap_sigma),
            None => format!("{:+.2} %, {}", 100.0 * self.gap_rel, no_uncertainty(&self.missing)),
        }
    }

    fn disagrees(&self) -> bool {
        self.gap_sigma.is_some_and(|sigma| sigma.abs() > DISAGREES_SIGMA)
    }

    /// The finding in one sentence, and whether all is well.
    pub fn verdict(&self) -> (String, bool) {
        let gap = gap_words(self.gap_rel, self.gap_sigma);
        match self.disagrees() {
            _ if self.gap_sigma.is_none() => (
                format!(
                    "Simulation and measurement differ on the axis at {:.0} mm by {gap}; whether they agree cannot be said, {}.",
                    self.distance_mm,
                    no_uncertainty(&self.missing)
                ),
                false,
            ),
            false => (
                format!(
                    "Simulation and measurement agree on the axis at {:.0} mm: {gap}.",
                    self.distance_mm
                ),
                true,
            ),
            true => (
                format!(
                    "Simulation and measurement disagree on the axis at {:.0} mm by {gap}.",
                    self.distance_mm
                ),
                false,
            ),
        }
    }
}

/// A gap in per cent, and in σ where that is known.
pub fn gap_words(gap_rel: f64, sigma: Option<f64>) -> String {
    let sigma = sigma.map_or_else(String::new, |sigma| format!(", {sigma:+.1} σ"));
    format!("{:+.2} %{sigma}", 100.0 * gap_rel)
}

/// Compares; none without a spectrum. `simulated_w_m2` is the irradiance at a distance in mm on the axis by the model of
/// the day, whose luminous area has this diameter.
///
/// # Errors
/// What `simulated_w_m2` refuses.
pub fn on_axis<E>(
    reduction: &Reduction,
    luminous_diameter_mm: Option<f64>,
    simulated_w_m2: impl Fn(f64) -> Result<f64, E>,
) -> Result<Option<Comparison>, E> {
    let Some(spectral) = &reduction.spectral else {
        return Ok(None);
    };
    let distance_mm = spectral.distance_mm;
    let simulated = simulated_w_m2(distance_mm)?;
    let (measured, measured_lx) = (&spectral.irradiance, &spectral.illuminance);
    // Both sides in W/m² rest on the same spectrum, whose efficacy cancels: what is compared is lx against lx. What the
    // model leaves open of the luminous area counts at the short distance.
    let far = reduction.sensor_illuminance.without_part(NEAR_FIELD_AT_SENSOR);
    let area_rel = luminous_diameter_mm.map_or(0.0, |diameter_mm| {
        luminous_area_rel(diameter_mm, reduction.grid.distribution.lobe_exponent(), distance_mm)
    });
    let simulated_rel = far.u_rel().map(|far| far.hypot(area_rel));
    let u_rel = simulated_rel
        .zip(measured_lx.u_rel())
        .map(|(simulated, measured)| simulated.hypot(measured));
    let missing = far.lacking(measured_lx.missing.iter().cloned()).missing;
    let gap_rel = simulated / measured.value - 1.0;
    let ler = measured_lx.value / measured.value;
    let stated = |value: f64, u_rel: Option<f64>| Stated {
        value,
        u: u_rel.map(|u_rel| value * u_rel),
    };
    Ok(Some(Comparison {
        distance_mm,
        measured_w_m2: stated(measured.value, measured.u_rel()),
        measured_lx: stated(measured_lx.value, measured_lx.u_rel()),
        simulated_w_m2: stated(simulated, simulated_rel),
        simulated_lx: stated(simulated * ler, simulated_rel),
        gap_rel,
        gap_sigma: u_rel.map(|u_rel| gap_rel / u_rel),
        missing,
        luminous_area_rel: area_rel,
    }))
}

/// A number with its unit and standard uncertainty, for tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stated {
    /// The number.
    pub value: f64,
    /// Its standard uncertainty (k = 1); null where something is missing in it.
    pub u: Option<f64>,
}

impl Stated {
    /// The value with its expanded uncertainty; the value alone to five digits where there is none.
    pub fn text(&self, unit: &str) -> String {
        match self.u {
            Some(u) => stated(self.value, u, unit),
            None => format!("{} {unit}", significant(self.value, 5)),
        }
    }
}
