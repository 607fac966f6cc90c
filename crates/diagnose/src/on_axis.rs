//! The comparison on the axis: what the spectroradiometer read on the axis against what the simulation says there.
//!
//! The distribution was measured with the lux meter far away, the spectrum with another instrument close by. Their
//! agreement tests near field, distance and calibration at once, and no part of it was fitted.

use isolux_reduce::{NEAR_FIELD_AT_SENSOR, Reduction, no_uncertainty};
use isolux_units::digits::{significant, stated};
use serde::Serialize;

/// A gap beyond this many standard uncertainties is a disagreement.
const DISAGREES_SIGMA: f64 = 2.0;

/// Measured and simulated irradiance on the axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// The same gap when the light leaves from the whole luminous area; none where the station does not state its size.
    pub near_field: Option<NearField>,
}

/// The luminous area in place of the model's 1 mm disc.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NearField {
    /// Luminous diameter that the station states.
    pub luminous_diameter_mm: f64,
    /// Radius of the ring with the same mean square radius as an evenly lit disc of that diameter, D/√8: the one number
    /// of an extended source that the axis sees to first order, −½(n + 3)(R/d)².
    pub radius_mm: f64,
    /// Simulated irradiance with the effect, in W/m².
    pub simulated_w_m2: f64,
    /// The gap that is left, relative.
    pub gap_rel: f64,
    /// The gap that is left, in σ.
    pub gap_sigma: Option<f64>,
    /// Whether it turns a disagreement into an agreement. Nothing was fitted for that.
    pub explains: bool,
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
        if let Some(near) = &self.near_field {
            let verdict = if near.explains {
                "near_field explains the gap: the light leaves from rings, not from a disc of 1 mm"
            } else if self.gap_sigma.is_none() {
                "whether it explains the gap cannot be said; with the whole luminous area"
            } else if !self.disagrees() {
                "no disagreement to explain; with the whole luminous area"
            } else {
                "near_field alone does not explain the gap; with the whole luminous area"
            };
            lines.push(format!(
                "near_field            {verdict}: {} left (ring of {:.1} mm radius from the stated luminous diameter of {} mm)",
                gap_words(near.gap_rel, near.gap_sigma),
                near.radius_mm,
                near.luminous_diameter_mm
            ));
        }
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
        match &self.near_field {
            _ if self.gap_sigma.is_none() => (
                format!(
                    "Simulation and measurement differ on the axis at {:.0} mm by {gap}; whether they agree cannot be said, {}.",
                    self.distance_mm,
                    no_uncertainty(&self.missing)
                ),
                false,
            ),
            _ if !self.disagrees() => (
                format!(
                    "Simulation and measurement agree on the axis at {:.0} mm: {gap}.",
                    self.distance_mm
                ),
                true,
            ),
            Some(near) if near.explains => (
                format!(
                    "The 1 mm disc is off by {gap} on the axis at {:.0} mm; near_field (limited photometric distance) explains it: \
                     {} are left with the luminous area, and nothing was fitted.",
                    self.distance_mm,
                    gap_words(near.gap_rel, near.gap_sigma)
                ),
                true,
            ),
            _ => (
                format!(
                    "Simulation and measurement disagree on the axis at {:.0} mm by {gap}, and the size of the luminous area does not \
                     explain it.",
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

/// Compares; none without a spectrum. `simulated_w_m2` is the irradiance at a distance in mm on the axis, with the
/// light leaving from a ring of so many mm radius or, without one, from the model's own emitter.
///
/// # Errors
/// What `simulated_w_m2` refuses.
pub fn on_axis<E>(
    reduction: &Reduction,
    luminous_diameter_mm: Option<f64>,
    simulated_w_m2: impl Fn(f64, Option<f64>) -> Result<f64, E>,
) -> Result<Option<Comparison>, E> {
    let Some(spectral) = &reduction.spectral else {
        return Ok(None);
    };
    let distance_mm = spectral.distance_mm;
    let simulated = simulated_w_m2(distance_mm, None)?;
    let (measured, measured_lx) = (&spectral.irradiance, &spectral.illuminance);
    // Both sides in W/m² rest on the same spectrum, whose efficacy cancels: what is compared is lx against lx. The near
    // field at the short distance is what is tested, and no uncertainty of the test.
    let far = reduction.sensor_illuminance.without_part(NEAR_FIELD_AT_SENSOR);
    let u_rel = far
        .u_rel()
        .zip(measured_lx.u_rel())
        .map(|(far, measured)| far.hypot(measured));
    let missing = far.clone().lacking(measured_lx.missing.iter().cloned()).missing;
    let gap = |simulated: f64| simulated / measured.value - 1.0;
    let gap_rel = gap(simulated);
    let near_field = luminous_diameter_mm
        .map(|luminous_diameter_mm| {
            let radius_mm = luminous_diameter_mm / 8f64.sqrt();
            let with = simulated_w_m2(distance_mm, Some(radius_mm))?;
            let left = u_rel.map(|u_rel| gap(with) / u_rel);
            let beyond = |sigma: Option<f64>| sigma.is_some_and(|sigma| sigma.abs() > DISAGREES_SIGMA);
            Ok(NearField {
                luminous_diameter_mm,
                radius_mm,
                simulated_w_m2: with,
                gap_rel: gap(with),
                gap_sigma: left,
                explains: beyond(u_rel.map(|u_rel| gap_rel / u_rel)) && !beyond(left),
            })
        })
        .transpose()?;
    let ler = measured_lx.value / measured.value;
    let stated = |value: f64, u_rel: Option<f64>| Stated {
        value,
        u: u_rel.map(|u_rel| value * u_rel),
    };
    Ok(Some(Comparison {
        distance_mm,
        measured_w_m2: stated(measured.value, measured.u_rel()),
        measured_lx: stated(measured_lx.value, measured_lx.u_rel()),
        simulated_w_m2: stated(simulated, far.u_rel()),
        simulated_lx: stated(simulated * ler, far.u_rel()),
        gap_rel,
        gap_sigma: u_rel.map(|u_rel| gap_rel / u_rel),
        missing,
        near_field,
    }))
}

/// A number with its unit and standard uncertainty, for tables.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
