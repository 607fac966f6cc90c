//! `diagnosis.json`: the public form of a diagnosis.

use std::borrow::Cow;
use std::collections::BTreeMap;

use isolux_units::json::nan_if_null;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::noise::Kind;

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing beyond noise.
    Consistent,
    /// The data single out these effects.
    Named,
    /// An effect is real, but the data cannot tell the listed ones apart.
    Ambiguous,
    /// Structure is left that no effect in the catalogue makes.
    Unexplained,
}

/// A diagnosis as written to `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Document {
    /// The answer.
    pub verdict: Verdict,
    /// The answer for a reader who never met a σ: what is wrong, how much, and what it does to the readings.
    pub plain: String,
    /// The answer in a sentence, with its statistics.
    pub sentence: String,
    /// Along which coordinates the baseline disagrees, strongest first.
    #[serde(rename = "where")]
    pub places: Vec<PlaceEntry>,
    /// Effects that were added to the model after, strongest first.
    pub effects: Vec<EffectEntry>,
    /// Everything that was ranked for each effect, for the table in the report.
    pub ranked: Vec<Vec<RankedEntry>>,
    /// What no effect makes.
    pub unexplained: Option<UnexplainedEntry>,
    /// The noise.
    pub noise: NoiseEntry,
    /// The gap between model and measurement.
    pub gap: GapEntry,
    /// What the model's file knows of itself, and where these data put it.
    pub known: Vec<KnownEntry>,
    /// Whether the model was made from other data than these.
    pub independence: Independence,
    /// What to measure next.
    pub next_measurement: Vec<NextEntry>,
    /// What these data could show of every effect.
    pub blind_spots: Vec<BlindSpot>,
    /// File of the baseline model.
    pub model_baseline: String,
    /// File of the model with the effects.
    pub model_after: String,
    /// What was left out of the fit, in words.
    pub notes: Vec<String>,
}

/// One coordinate along which the baseline disagrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlaceEntry {
    /// The coordinate.
    pub coordinate: Cow<'static, str>,
    /// Significance of the strongest generic pattern along it.
    pub significance_sigma: f64,
    /// The part of the coordinate that it touches.
    pub range: [f64; 2],
    /// In words.
    pub note: String,
}

/// One effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectEntry {
    /// Its id.
    pub name: Cow<'static, str>,
    /// The term of the standards.
    pub standard_name: Cow<'static, str>,
    /// Every other member of its 95 % set, most probable first.
    pub equivalents: Vec<String>,
    /// Values of its keys.
    pub parameters: BTreeMap<Cow<'static, str>, ParameterEntry>,
    /// How sure.
    pub evidence: EvidenceEntry,
}

/// A fitted parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterEntry {
    /// Value.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Standard uncertainty.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub u: f64,
    /// Unit.
    pub unit: Cow<'static, str>,
    /// What a bench plausibly shows.
    pub plausible: [f64; 2],
    /// The value in the model as given, where the effect is in it already.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<f64>,
    /// Outside that range by more than its standard uncertainty.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub implausible: bool,
}

/// How sure an effect is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EvidenceEntry {
    /// Against nothing.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub ln_bayes_factor: f64,
    /// Of the scan that found it, among simulated noise-only scans.
    pub p_value: f64,
    /// Of this name alone, normalised over named, unnamed and nothing.
    pub posterior: f64,
    /// Significance in σ.
    pub significance_sigma: f64,
}

/// One line of the ranked table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RankedEntry {
    /// A name, or `unnamed:coordinate`.
    pub name: String,
    /// Its probability.
    pub posterior: f64,
    /// Its significance in σ.
    pub significance_sigma: f64,
    /// ln(prior · Bayes factor) behind the probability.
    #[serde(skip)]
    pub ln_evidence: f64,
}

/// What no effect makes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UnexplainedEntry {
    /// Along what.
    pub coordinate: Cow<'static, str>,
    /// Where.
    pub range: [f64; 2],
    /// Its share of the squared gap.
    pub share_of_gap: f64,
    /// Its significance.
    pub significance_sigma: f64,
    /// In words.
    pub note: String,
}

/// The noise of the observations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseEntry {
    /// Common factor on the stated uncertainties.
    pub scale: f64,
    /// Of neighbours in time.
    pub autocorrelation: f64,
    /// Simulated scans.
    pub n_null: usize,
    /// Of the whole scan of the baseline; null where the model was made from these readings, whose agreement is no
    /// evidence.
    pub p_global: Option<f64>,
    /// Whether what is left is noise; null where too few readings are left to tell.
    pub test: Option<NoiseTestEntry>,
}

/// Whether what is left is noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseTestEntry {
    /// Of the strongest of all tests under noise alone.
    pub p_value: f64,
    /// Standard deviation of what is left, outliers held, in stated uncertainties.
    pub scatter: f64,
    /// The largest scatter that counts as noise: 1.25, or 1.25 times what repeats of a pose show.
    pub scatter_limit: f64,
    /// The same of repeats of one pose, where there are enough.
    pub repeats_scatter: Option<f64>,
    /// What is no noise, strongest first.
    pub findings: Vec<NoiseFindingEntry>,
    /// The strongest periods, significant or not.
    pub spectrum: Vec<PeakEntry>,
}

/// One way in which what is left is no noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NoiseFindingEntry {
    /// Which test found it.
    pub test: Kind,
    /// Along what; `noise` for the scatter itself.
    pub coordinate: Cow<'static, str>,
    /// Where; numbers of readings for `noise`.
    pub range: [f64; 2],
    /// In seconds (`time_s`) or readings (`index`).
    pub period: Option<f64>,
    /// Its significance.
    pub significance_sigma: f64,
    /// Of this test alone.
    pub p_value: f64,
    /// In words.
    pub note: String,
}

/// A peak of the periodogram of what is left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakEntry {
    /// `time_s` or `index`.
    pub coordinate: Cow<'static, str>,
    /// In seconds or readings.
    pub period: f64,
    /// Of this period alone.
    pub significance_sigma: f64,
}

/// The gap, rms((measured − predicted)/(s·u)).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GapEntry {
    /// What the numbers are.
    pub metric: Cow<'static, str>,
    /// The model as it came.
    pub as_given: f64,
    /// With what the model knows of itself where the data put it within its uncertainty, and what nothing is stated of
    /// refitted.
    pub before: f64,
    /// With the effects.
    pub after: f64,
    /// Expected under noise alone.
    pub floor: f64,
    /// (before² − after²)/(before² − floor²); null where no effect was added.
    pub removed: Option<f64>,
    /// On readings that the fit has not seen.
    pub held_out: Option<HeldOutEntry>,
    /// Which readings those are, or why there are none.
    pub held_out_note: String,
}

/// One thing that the model's file knows with a standard uncertainty, and where the data put it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct KnownEntry {
    /// What, in words.
    pub what: String,
    /// Its standard uncertainty.
    pub u: f64,
    /// The unit of that; empty for a ratio.
    pub unit: Cow<'static, str>,
    /// The file does not state it: it was taken as wide as usual.
    pub assumed: bool,
    /// Where the data put it, in that uncertainty, without named effects.
    pub before_sigma: f64,
    /// And with them.
    pub after_sigma: f64,
    /// Standard uncertainty that the data leave of it, in the same unit.
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub u_after_sigma: f64,
}

/// The gap on readings that the fit has not seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOutEntry {
    /// Baseline.
    pub before: f64,
    /// With the effects.
    pub after: f64,
    /// Expected under noise alone.
    pub floor: f64,
    /// As in [`GapEntry::removed`].
    #[serde(deserialize_with = "nan_if_null")]
    #[schemars(with = "Option<f64>")]
    pub removed: f64,
    /// How many.
    pub readings: usize,
}

/// Whether model and data are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Independence {
    /// The model was made from other data.
    Independent,
    /// The model was made from this very run, or has effects that were fitted to it: what is found is a consistency
    /// check of the record, no test of the model.
    SameRun,
    /// The model does not say what it was made from.
    NotShown,
}

/// One suggested measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextEntry {
    /// What, in one word.
    #[serde(rename = "do")]
    pub what: Cow<'static, str>,
    /// The two that it tells apart.
    pub splits: [String; 2],
    /// A plan file that does it.
    pub plan: Option<String>,
    /// How many σ apart their predictions would be.
    pub expected_sigma: f64,
    /// How long it takes.
    pub minutes: f64,
}

/// What these data could show of an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BlindSpot {
    /// The effect.
    pub effect: Cow<'static, str>,
    /// Its amplitude's key.
    pub parameter: Cow<'static, str>,
    /// The amplitude that these data would show at 5 σ; null: none, however large.
    pub amplitude_at_5_sigma: Option<f64>,
    /// What a bench plausibly shows at most.
    pub plausible_max: f64,
    /// The data cannot show a plausible amount.
    pub blind: bool,
}
