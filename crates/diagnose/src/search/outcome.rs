//! What is asked of a search, and what it finds: members, their alternatives, the noise and what is left.

use nalgebra::DVector;

use crate::alternatives::EmpiricalAlternative;
use crate::calibration::{CLEARLY, MODEL_FORM, NULLS, SECOND_SHARE, SIGNIFICANCE};
use crate::fit::Fit;
use crate::forward::Hypothesis;
use crate::known::{Known, Moved};
use crate::noise::NoiseTest;
use crate::reference::Errors;
use crate::rounding::Rounding;
use crate::table::Coordinate;
use crate::whitening::{Noise, Sequence};

/// What may be chosen about a search; the defaults are those of the documentation.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Seed of the simulated scans.
    pub seed: u64,
    /// Number of simulated noise-only scans.
    pub nulls: usize,
    /// A whole scan less probable than this under noise alone is a disagreement.
    pub significance: f64,
    /// Relative error allowed to the formula of an effect.
    pub model_form: f64,
    /// A further effect must reach this share of the first one's significance.
    pub second_share: f64,
    /// Whether one factor on the stated uncertainties is fitted.
    pub fit_scale: bool,
}

impl Settings {
    /// What a further effect must explain at least, in σ², beside one that explains `strongest`.
    pub fn further(&self, strongest: f64) -> f64 {
        (self.second_share.powi(2) * strongest).min(self.model_form.powi(2) * strongest + CLEARLY)
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 1,
            nulls: NULLS,
            significance: SIGNIFICANCE,
            model_form: MODEL_FORM,
            second_share: SECOND_SHARE,
            fit_scale: true,
        }
    }
}

/// Named effects and a fit with them.
#[derive(Debug, Clone)]
pub(super) struct Names {
    /// The effects, refined or as they were proposed.
    pub members: Vec<Hypothesis>,
    /// The fit.
    pub fit: Fit,
}

impl Names {
    /// The effects of a fit.
    pub fn of(fit: Fit) -> Self {
        let members = fit.hypotheses.clone();
        Self { members, fit }
    }

    /// None beside what is refitted anyway.
    pub fn none(baseline: &Fit) -> Self {
        let members = Vec::new();
        let fit = baseline.clone();
        Self { members, fit }
    }
}

/// Who could make what one member of the set makes.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Names and patterns by falling probability; what is left to 1 belongs to "nothing".
    pub ranked: Vec<Ranked>,
    /// ln Bayes factor of the member against nothing.
    pub ln_bayes_factor: f64,
    /// Probability of the whole scan under noise alone, given the other members.
    pub p_value: f64,
}

/// One row of the ranked table.
#[derive(Debug, Clone)]
pub struct Ranked {
    /// Who.
    pub label: Label,
    /// Posterior probability.
    pub posterior: f64,
    /// ln(prior · Bayes factor) before the likelihood is blunted.
    pub ln_evidence: f64,
    /// Significance in σ.
    pub sigma: f64,
    /// The refined fit with it, where one was made.
    pub hypothesis: Option<Hypothesis>,
}

/// A name, or a place without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Label {
    /// Number of an effect.
    Named(usize),
    /// No name, along this coordinate.
    Unnamed(Coordinate),
}

/// Structure that no effect in the catalogue makes.
#[derive(Debug, Clone)]
pub struct Unexplained {
    /// The strongest pattern.
    pub alternative: EmpiricalAlternative,
    /// Its significance in σ.
    pub sigma: f64,
    /// Its fitted change of every row.
    pub pattern: DVector<f64>,
}

/// The strongest generic pattern along one coordinate.
#[derive(Debug, Clone)]
pub struct Place {
    /// Along what.
    pub coordinate: Coordinate,
    /// Where.
    pub range: [f64; 2],
    /// Significance in σ.
    pub sigma: f64,
    /// In words.
    pub note: String,
}

impl Outcome {
    /// What the noise of single directions of the model's distribution does to the rows.
    pub fn direction_errors(&self) -> &[Vec<(usize, f64)>] {
        &self.errors[..self.errors.len() - self.known.len()]
    }
}

/// Everything that the search found.
#[derive(Debug)]
pub struct Outcome {
    /// The baseline: nuisance alone.
    pub baseline: Fit,
    /// Nuisance and the named effects.
    pub after: Fit,
    /// The noise.
    pub noise: Noise,
    /// Rows that were rounded alike.
    pub rounding: Rounding,
    /// What the noise of the model's own distribution does to the rows, and what the model knows of itself.
    pub errors: Errors,
    /// What the model knows of itself.
    pub known: Vec<Known>,
    /// Where the readings put it without named effects.
    pub moved_before: Moved,
    /// And with them.
    pub moved_after: Moved,
    /// Order of the rows.
    pub sequence: Sequence,
    /// Probability of the first scan under noise alone.
    pub p_global: f64,
    /// One entry for each hypothesis of `after`.
    pub comparisons: Vec<Comparison>,
    /// What is left without a name.
    pub unexplained: Option<Unexplained>,
    /// Where the baseline disagrees, strongest first.
    pub places: Vec<Place>,
    /// Significance (σ) of every effect at its plausible maximum: what the data could show (effect, component, σ).
    pub visibility: Vec<(usize, usize, f64)>,
    /// Whether what is left is noise; none where there is too little of it.
    pub noise_test: Option<NoiseTest>,
    /// 1/σ² of every refitted term in the two fits.
    pub held: Vec<f64>,
    /// Number of simulated scans.
    pub nulls: usize,
}
