//! The comparison of the day: what the spectroradiometer read on the axis against what the simulation says there.
//!
//! The distribution was measured with the lux meter far away, the spectrum with another instrument close by. Their
//! agreement tests near field, distance and calibration at once, and no part of it was fitted.

use camino::Utf8Path;
use isolux_sim::simulation::Method;
use serde::Serialize;

use super::Stated;
use crate::reduce::Reduced;
use crate::scene::{self, Changes};
use crate::{Failure, simulate};

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
    /// The gap in standard uncertainties of the difference.
    pub gap_sigma: f64,
    /// The same gap when the light leaves from the whole luminous area; none where the station does not state its size.
    pub near_field: Option<NearField>,
}

/// The luminous area in place of the model's 1 mm disc.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NearField {
    /// Luminous diameter that the station states.
    pub luminous_diameter_mm: f64,
    /// Radius of the ring with the same mean square radius as an evenly lit disc of that diameter, D/√8: the one number of
    /// an extended source that the axis sees to first order, −½(n + 3)(R/d)².
    pub radius_mm: f64,
    /// Simulated irradiance with the effect, in W/m².
    pub simulated_w_m2: f64,
    /// The gap that is left, relative.
    pub gap_rel: f64,
    /// The gap that is left, in σ.
    pub gap_sigma: f64,
    /// Whether it turns a disagreement into an agreement. Nothing was fitted for that.
    pub explains: bool,
}

impl Comparison {
    /// The comparison in words.
    pub fn sentences(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "on the axis, {:.0} mm   measured {:.4} ± {:.4} W/m² ({:.1} ± {:.1} lx), simulated {:.4} ± {:.4} W/m² ({:.1} ± {:.1} lx)",
            self.distance_mm,
            self.measured_w_m2.value,
            self.measured_w_m2.u,
            self.measured_lx.value,
            self.measured_lx.u,
            self.simulated_w_m2.value,
            self.simulated_w_m2.u,
            self.simulated_lx.value,
            self.simulated_lx.u,
        )];
        lines.push(format!(
            "gap                   {:+.2} %, {:+.1} σ",
            100.0 * self.gap_rel,
            self.gap_sigma
        ));
        if let Some(near) = &self.near_field {
            let verdict = if near.explains {
                "near_field explains the gap: the light leaves from rings, not from a disc of 1 mm"
            } else if self.gap_sigma.abs() <= DISAGREES_SIGMA {
                "no disagreement to explain; with the whole luminous area"
            } else {
                "near_field alone does not explain the gap; with the whole luminous area"
            };
            lines.push(format!(
                "near_field            {verdict}: {:+.2} %, {:+.1} σ left (ring of {:.1} mm radius from the stated luminous diameter of {} mm)",
                100.0 * near.gap_rel,
                near.gap_sigma,
                near.radius_mm,
                near.luminous_diameter_mm
            ));
        }
        lines
    }

    /// The finding in one sentence, and whether all is well.
    pub fn verdict(&self) -> (String, bool) {
        let gap = format!("{:+.2} % ({:+.1} σ)", 100.0 * self.gap_rel, self.gap_sigma);
        match &self.near_field {
            _ if self.gap_sigma.abs() <= DISAGREES_SIGMA => (
                format!(
                    "Simulation and measurement agree on the axis at {:.0} mm: {gap}.",
                    self.distance_mm
                ),
                true,
            ),
            Some(near) if near.explains => (
                format!(
                    "The 1 mm disc is off by {gap} on the axis at {:.0} mm; near_field (limited photometric distance) explains it: \
                     {:+.2} % ({:+.1} σ) are left with the luminous area, and nothing was fitted.",
                    self.distance_mm,
                    100.0 * near.gap_rel,
                    near.gap_sigma
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

/// Compares; none without a spectrum.
///
/// # Errors
/// What the simulation refuses.
pub(super) fn on_axis(folder: &Utf8Path, reduced: &Reduced) -> Result<Option<Comparison>, Failure> {
    let Some(spectral) = &reduced.reduction.spectral else {
        return Ok(None);
    };
    let distance_mm = spectral.distance_mm;
    // One pixel, small against everything, where the instrument's reference plane meets the axis.
    let here = |set: Vec<String>| -> Result<f64, Failure> {
        let changes = Changes {
            distance_mm: Some(distance_mm),
            sensor_mm: Some([0.1, 0.1]),
            pixels: Some([1, 1]),
            set,
            ..Changes::default()
        };
        Ok(simulate::solve(&scene::load(folder, &changes)?, Method::Inverse)?
            .facts
            .mean)
    };
    let simulated = here(Vec::new())?;
    let (measured, measured_lx) = (&spectral.irradiance, &spectral.illuminance);
    // Both sides in W/m² rest on the same spectrum, whose efficacy cancels: what is compared is lx against lx.
    let u_simulated_rel = reduced.reduction.sensor_illuminance.u_rel();
    let u_rel = u_simulated_rel.hypot(measured_lx.u_rel());
    let gap = |simulated: f64| simulated / measured.value - 1.0;
    let gap_rel = gap(simulated);
    let near_field = reduced
        .run
        .header
        .station
        .lamp()
        .and_then(|lamp| lamp.diameter_mm)
        .map(|luminous_diameter_mm| {
            let radius_mm = luminous_diameter_mm / 8f64.sqrt();
            let effect = format!("effect = [{{ name = \"near_field\", radius_mm = {radius_mm:?}, aim_deg = 0.0 }}]");
            let with = here(vec![effect])?;
            let left = gap(with) / u_rel;
            Ok::<_, Failure>(NearField {
                luminous_diameter_mm,
                radius_mm,
                simulated_w_m2: with,
                gap_rel: gap(with),
                gap_sigma: left,
                explains: (gap_rel / u_rel).abs() > DISAGREES_SIGMA && left.abs() <= DISAGREES_SIGMA,
            })
        })
        .transpose()?;
    let ler = measured_lx.value / measured.value;
    let stated = |value: f64, u_rel: f64| Stated {
        value,
        u: value * u_rel,
    };
    Ok(Some(Comparison {
        distance_mm,
        measured_w_m2: stated(measured.value, measured.u_rel()),
        measured_lx: stated(measured_lx.value, measured_lx.u_rel()),
        simulated_w_m2: stated(simulated, u_simulated_rel),
        simulated_lx: stated(simulated * ler, u_simulated_rel),
        gap_rel,
        gap_sigma: gap_rel / u_rel,
        near_field,
    }))
}
