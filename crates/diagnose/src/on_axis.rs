//! The comparison on the axis: what the spectroradiometer read on the axis against what the model says there.
//!
//! The distribution was measured with the lux meter far away, the spectrum with another instrument close by. Their
//! agreement tests near field, distance and calibration at once, and no part of it was fitted. It is the diagnosis of
//! one reading: what the model knows of itself, the verdict and the causes are those of any other.

use isolux_model::Model;
use isolux_record::observation::{Observations, ReadingCoordinates, ReadingRow, Readings};
use isolux_record::{Quality, ReadingKind};
use isolux_reduce::{NEAR_FIELD_AT_SENSOR, Reduction, no_uncertainty};
use isolux_units::digits::{significant, stated};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::assumed::{AssumedModel, Part};
use crate::calibration::SIGNIFICANCE;
use crate::diagnosis::{DiagnoseError, diagnose};
use crate::document::{Document, KnownEntry, Verdict};
use crate::forward::Forward;
use crate::search::Settings;

/// Measured and simulated irradiance on the axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Distance of the spectroradiometer from the light centre.
    pub distance_mm: f64,
    /// Measured spectral irradiance, summed over 360–830 nm, in W/m².
    pub measured_w_m2: Stated,
    /// The same in lx.
    pub measured_lx: Stated,
    /// Irradiance with the model's emitter, in W/m²; its uncertainty is what the model knows of itself.
    pub simulated_w_m2: Stated,
    /// The same in lx.
    pub simulated_lx: Stated,
    /// (simulated − measured)/measured.
    pub gap_rel: f64,
    /// The gap in standard uncertainties of the measurement alone: of the model as it was given.
    pub as_given_sigma: Option<f64>,
    /// The gap in standard uncertainties of the difference; null where something is missing in them.
    pub gap_sigma: Option<f64>,
    /// What is missing in them, one phrase each.
    pub missing: Vec<String>,
    /// What the diagnosis says; null where something is missing in the uncertainties.
    pub finding: Option<AxisFinding>,
}

/// What the diagnosis of the one reading says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisFinding {
    /// The answer in one word.
    pub verdict: Verdict,
    /// Probability of so large a gap under noise and what the model knows of itself; null where the model was made from
    /// this reading.
    pub p_global: Option<f64>,
    /// The answer in plain words, with every effect that could make the gap.
    pub plain: String,
    /// What the model's file knows of itself, and where the reading puts it.
    pub known: Vec<KnownEntry>,
}

impl AxisFinding {
    fn of(document: Document) -> Self {
        Self {
            verdict: document.verdict,
            p_global: document.noise.p_global,
            plain: document.plain,
            known: document.known,
        }
    }

    fn disagrees(&self) -> bool {
        self.verdict != Verdict::Consistent || self.p_global.is_some_and(|p| p <= SIGNIFICANCE)
    }
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
        lines.extend(self.causes().map(|causes| format!("found                 {causes}")));
        lines
    }

    /// The gap with what it is worth.
    pub fn gap_text(&self) -> String {
        match self.gap_sigma {
            Some(_) => gap_words(self.gap_rel, self.gap_sigma),
            None => format!("{:+.2} %, {}", 100.0 * self.gap_rel, no_uncertainty(&self.missing)),
        }
    }

    /// What could make the gap, where it is a disagreement.
    pub fn causes(&self) -> Option<&str> {
        let finding = self
            .finding
            .as_ref()
            .filter(|finding| finding.verdict != Verdict::Consistent)?;
        Some(&finding.plain)
    }

    /// The verdict in one sentence, and whether all is well.
    pub fn verdict(&self) -> (String, bool) {
        let (at_mm, gap) = (self.distance_mm, gap_words(self.gap_rel, self.gap_sigma));
        match &self.finding {
            None => (
                format!(
                    "Simulation and measurement differ on the axis at {at_mm:.0} mm by {gap}; whether they agree \
                     cannot be said, {}.",
                    no_uncertainty(&self.missing)
                ),
                false,
            ),
            Some(finding) if finding.disagrees() => (
                format!("Simulation and measurement disagree on the axis at {at_mm:.0} mm by {gap}."),
                false,
            ),
            Some(_) => (
                format!("Simulation and measurement agree on the axis at {at_mm:.0} mm: {gap}."),
                true,
            ),
        }
    }
}

/// A gap in per cent, and in σ where that is known.
pub fn gap_words(gap_rel: f64, sigma: Option<f64>) -> String {
    let sigma = sigma.map_or_else(String::new, |sigma| format!(", {sigma:+.1} σ"));
    format!("{:+.2} %{sigma}", 100.0 * gap_rel)
}

/// Compares; none without a spectrum. `model` is that of the day.
///
/// # Errors
/// [`DiagnoseError`].
pub fn on_axis(model: &Model, reduction: &Reduction) -> Result<Option<Comparison>, DiagnoseError> {
    let Some(spectral) = &reduction.spectral else {
        return Ok(None);
    };
    // The lux meter and its reading chain are not what read this.
    let others = model.effects().iter().filter(|effect| !effect.spec().is_of_lux_meter());
    let model = model.with_effects(others.cloned().collect());
    let at = ReadingCoordinates {
        kind: ReadingKind::Lit,
        time_s: spectral.time_s,
        lamp_s: spectral.lamp_s,
        c_deg: spectral.c_deg,
        gamma_deg: 0.0,
        distance_mm: spectral.distance_mm,
        travel: 0,
        range: None,
        ambient_c: None,
        head: 0,
    };
    let assumed = AssumedModel::new(model.clone(), vec![Part::Readings(vec![at])]);
    let simulated_lx = model.predict_reading(&at);
    let (measured, measured_lx) = (&spectral.irradiance, &spectral.illuminance);
    let of_known: f64 = Forward::known(&assumed)
        .iter()
        .map(|one| one.column.norm_squared())
        .sum();
    let of_directions: f64 = assumed.common_errors().iter().flatten().map(|(_, lx)| lx * lx).sum();
    let far = reduction.sensor_illuminance.without_part(NEAR_FIELD_AT_SENSOR);
    let u_model_lx = far.u_rel().map(|_| (of_known + of_directions).sqrt());
    let u_lx = measured_lx.u_rel().map(|u_rel| u_rel * measured_lx.value);
    let missing = far.lacking(measured_lx.missing.iter().cloned()).missing;
    let finding = match u_model_lx.and(u_lx) {
        Some(u_lx) => {
            let row = ReadingRow {
                line: 1,
                index: None,
                block: String::new(),
                at,
                illuminance_lx: Some(measured_lx.value),
                u_lx: Some(u_lx),
                quality: Quality::Ok,
            };
            let observations = [Observations::Readings(Readings::of(vec![row]))];
            let diagnosis = diagnose(&model, &observations, None, "", &Settings::default())?;
            Some(AxisFinding::of(diagnosis.document))
        }
        None => None,
    };
    let ler = measured_lx.value / measured.value;
    let gap_lx = simulated_lx - measured_lx.value;
    Ok(Some(Comparison {
        distance_mm: spectral.distance_mm,
        measured_w_m2: Stated {
            value: measured.value,
            u: measured.u_rel().map(|u_rel| u_rel * measured.value),
        },
        measured_lx: Stated {
            value: measured_lx.value,
            u: u_lx,
        },
        // Both sides in W/m² rest on the same spectrum, whose efficacy cancels.
        simulated_w_m2: Stated {
            value: simulated_lx / ler,
            u: u_model_lx.map(|u| u / ler),
        },
        simulated_lx: Stated {
            value: simulated_lx,
            u: u_model_lx,
        },
        gap_rel: gap_lx / measured_lx.value,
        as_given_sigma: u_lx.map(|u_lx| gap_lx / u_lx),
        gap_sigma: u_lx
            .zip(u_model_lx)
            .map(|(u_lx, u_model_lx)| gap_lx / u_lx.hypot(u_model_lx)),
        missing,
        finding,
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
