//! Everything that the report of a day shows.

use camino::Utf8PathBuf;
use isolux_conformity::Conformity;
use isolux_diagnose::on_axis::Comparison;
use isolux_model::Scene;
use isolux_modulation::Modulation;
use isolux_record::{Language, Run};
use isolux_reduce::Reduction;
use isolux_sim::simulation::Simulation;
use isolux_spectrum::Quantities;

use crate::clothes::Clothes;
use crate::sensor::mean;

/// Computed from the record.
pub struct DayResults {
    /// The record.
    pub run: Run,
    /// What it says.
    pub reduction: Reduction,
    /// The folder of results.
    pub folder: Utf8PathBuf,
    /// The sensor and the model that lights it.
    pub scene: Scene,
    /// The light on it.
    pub simulation: Simulation,
    /// Colour of the measured spectrum.
    pub colour: Option<Quantities>,
    /// The test on the axis.
    pub comparison: Option<Comparison>,
    /// Conditions and requirements as they were judged, and what the report has to state.
    pub conformity: Conformity,
    /// How the report looks.
    pub layout: DayLayout,
    /// What the diagnosis says.
    pub diagnosis: Option<Diagnosed>,
    /// Why there is none, where one was tried and failed.
    pub undiagnosed: Option<String>,
    /// Light over time, where the job names a waveform of it.
    pub light_modulation: Option<Modulation>,
    /// Files of `results/` that are of another reduction.
    pub stale: Vec<&'static str>,
}

/// How a report looks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DayLayout {
    /// Its language.
    pub language: Language,
    /// Whose it is.
    pub clothes: Clothes,
    /// Its sections by name, in order; none: all of them.
    pub sections: Option<Vec<String>>,
    /// Whether a data sheet is made too.
    pub data_sheet: bool,
}

/// What the diagnosis of the day says.
pub struct Diagnosed {
    /// What was found, in plain sentences.
    pub plain: String,
    /// Whether nothing disagrees.
    pub good: bool,
    /// The statistics behind it, one line each.
    pub details: Vec<String>,
    /// Whether the model was made from the readings that it was compared with: then it is a check of the record, not a
    /// test.
    pub same_record: bool,
}

impl DayResults {
    /// What the reading of the strongest direction is uncertain by on its own, by rounding and scatter, relative to it.
    pub fn u_direction_rel(&self) -> Option<f64> {
        let nodes = self.reduction.grid.nodes.iter();
        let strongest = nodes.max_by(|a, b| a.intensity_cd.total_cmp(&b.intensity_cd))?;
        let u_cd = strongest.u_own_cd();
        (u_cd > 0.0 && strongest.intensity_cd > 0.0).then(|| u_cd / strongest.intensity_cd)
    }

    /// The last lines of the day.
    pub fn sentences(&self) -> Vec<String> {
        let reduction = &self.reduction;
        let facts = &self.simulation.facts;
        let mut lines = vec![format!("luminous flux         {}", reduction.flux.stated())];
        lines.extend(
            reduction
                .electrical
                .as_ref()
                .map(|line| format!("luminous efficacy     {}", line.luminous_efficacy.stated())),
        );
        lines.extend(
            reduction
                .accepted
                .as_ref()
                .map(|accepted| format!("accepted              {}", isolux_reduce::note(accepted))),
        );
        if let Some(cct) = reduction
            .spectral
            .as_ref()
            .and_then(|spectral| spectral.colour.cct.as_ref())
        {
            lines.push(format!("CCT                   {}", cct.stated()));
        }
        lines.extend(reduction.over_angle.as_ref().map(|found| {
            let delta = &found.facts.delta_u_prime_v_prime;
            let (c_deg, gamma_deg) = (delta.c_deg, delta.gamma_deg);
            format!(
                "Δu′v′ over angle      {} at C {c_deg}° γ {gamma_deg}°",
                delta.value.stated()
            )
        }));
        if let Some(modulation) = &self.light_modulation {
            lines.push(format!(
                "modulation depth      {}",
                modulation.modulation_depth.stated()
            ));
            lines.push(format!("SVM                   {}", modulation.svm.stated()));
            lines.push(format!("PstLM                 {}", modulation.pst_lm.stated()));
        }
        lines.push(format!("mean on the sensor    {}", mean(facts)));
        let [met, not_met, not_known] = self.conformity.standings();
        lines.push(format!(
            "conditions            {met} met, {not_met} not met, {not_known} not known"
        ));
        lines.extend(
            self.conformity
                .sentence()
                .map(|sentence| format!("requirements          {sentence}")),
        );
        match &self.comparison {
            Some(comparison) => lines.extend(comparison.sentences()),
            None if self.diagnosis.as_ref().is_some_and(|found| found.same_record) => lines.push(
                "test                  none: no spectrum was taken at a short distance, and the diagnosis checks the record against itself"
                    .to_owned(),
            ),
            None if self.undiagnosed.is_some() => lines.push(
                "test                  none: no spectrum was taken at a short distance, and the diagnosis failed".to_owned(),
            ),
            None if self.diagnosis.is_none() => lines.push(
                "test                  none: no spectrum was taken at a short distance, and every reading made the distribution".to_owned(),
            ),
            None => {}
        }
        lines.extend(
            self.undiagnosed
                .iter()
                .map(|why| format!("note                  {why}")),
        );
        lines
    }
}
