//! The whole diagnosis of a model against observations: search, gap, held-out check, next measurement, new model.

mod entries;
mod gap;
mod plain;
mod sentence;

use isolux_model::{Effect, Model, UncertaintyScale};
use isolux_record::observation::Observations;
use nalgebra::DVector;

use crate::assumed::AssumedModel;
use crate::document::{Document, EffectEntry, Independence, KnownEntry, NoiseEntry, UnexplainedEntry};
use crate::forward::Forward;
use crate::next::{self, Next};
use crate::observe::{Observed, observed};
use crate::search::{Outcome, Settings, Unexplained, search};
use crate::table::Row;

pub use isolux_model::digits;
pub use plain::along as along_words;

use entries::{blind_spots, effect_entries, noise_test, places, ranked};
use gap::gap;
use plain::plain;
use sentence::{sentence, verdict};

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiagnoseError {
    /// Nothing to fit.
    #[error("the observations have no reading with a value")]
    Nothing,
    /// Too little data.
    #[error(
        "{rows} readings cannot fix {parameters} parameters that must be refitted (shape, gain, trusted harmonics)"
    )]
    TooFew {
        /// Readings with a value.
        rows: usize,
        /// Nuisance parameters.
        parameters: usize,
    },
    /// The model predicts something that is no number.
    #[error("the model cannot predict these observations: a prediction is not finite, or a spectrum is missing")]
    NoPrediction,
    /// Something was measured where the model says nothing can be.
    #[error("the model expects no light at any of the lit readings: the distribution does not reach their directions")]
    Dark,
}

/// Everything that was found, with what the pictures need.
#[derive(Debug)]
pub struct Diagnosis {
    /// For `diagnosis.json`.
    pub document: Document,
    /// Nuisance refitted, no new effect.
    pub baseline: Model,
    /// With the effects.
    pub after: Model,
    /// Plans of the suggested measurements: file name and content.
    pub plans: Vec<(String, String)>,
    /// The rows that were fitted.
    pub rows: Vec<Row>,
    /// (measured − expected by the model as it was given)/(s·u) of each row.
    pub before: Vec<f64>,
    /// (measured − after)/(s·u) of each row.
    pub left: Vec<f64>,
    /// What was found changes of the expected, in s·u of each row: the fit through the residuals.
    pub explained: Vec<f64>,
    /// What the model after expects of each row, in the file's unit.
    pub level: Vec<f64>,
    /// Names of effects of the bench: `reduce --with` can take them out.
    pub of_bench: Vec<&'static str>,
}

/// Diagnoses `model` against observations; `held_out` are further observations that are predicted and never fitted.
///
/// `sha256` is the fingerprint of the data, which goes into the evidence of every added effect.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose(
    model: &Model,
    observations: &[Observations],
    held_out: Option<&Observations>,
    sha256: &str,
    settings: &Settings,
) -> Result<Diagnosis, DiagnoseError> {
    let Given {
        assumed,
        rows,
        mut notes,
        kept_back,
        as_given,
    } = Given::of(model, observations, held_out)?;
    let settings = Settings {
        fit_scale: model.u_scale() == UncertaintyScale::Fit,
        ..*settings
    };
    let outcome = search(&assumed, &rows, &settings).ok_or(DiagnoseError::NoPrediction)?;

    let effects = effect_entries(&assumed, &outcome);
    let verdict = verdict(&outcome, &effects);
    let measured = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.measured));
    let sigma = DVector::from_iterator(rows.len(), rows.iter().map(|row| outcome.noise.scale * row.u));
    let scaled = |prediction: &DVector<f64>| (&measured - prediction).component_div(&sigma);
    let expected_before = &outcome.baseline.prediction + &outcome.moved_before.change;
    let expected_after = &outcome.after.prediction + &outcome.moved_after.change;
    let before = scaled(&expected_before);
    let left = scaled(&expected_after);
    let given = scaled(&as_given);
    // The pictures begin with the model as it was given.
    let mut explained = &expected_after - &as_given;
    if let Some(unexplained) = &outcome.unexplained {
        explained += &unexplained.pattern;
    }
    explained.component_div_assign(&sigma);
    let gap = gap(&assumed, &outcome, &rows, &given, &before, &left, &kept_back);
    let excess = before.norm_squared() - rows.len() as f64;
    let unexplained = outcome.unexplained.as_ref().map(|found| unexplained(found, excess));
    let Next {
        entries: next_measurement,
        plans,
        note,
    } = next::suggest(&assumed, &outcome, &rows);
    notes.extend(note);
    let baseline = assumed
        .model(&outcome.baseline.nuisance, &[])
        .ok_or(DiagnoseError::NoPrediction)?;
    let after = model_after(&assumed, &outcome, &effects, sha256, &settings).ok_or(DiagnoseError::NoPrediction)?;
    let of_bench = outcome
        .after
        .hypotheses
        .iter()
        .filter(|member| assumed.belongs_to_bench(member.effect))
        .map(|member| assumed.spec(member.effect).name)
        .collect();
    let independence = independence(model, sha256);
    let known = known(&outcome);
    notes.extend(stated(model, &known));
    let sentence = sentence(verdict, &effects, unexplained.as_ref(), &outcome, independence);
    let plain = plain(verdict, &effects, unexplained.as_ref(), &gap, &known, independence);
    let document = Document {
        verdict,
        plain,
        sentence,
        places: places(&outcome),
        ranked: ranked(&assumed, &outcome),
        effects,
        unexplained,
        noise: noise(&outcome, independence),
        gap,
        known,
        independence,
        next_measurement,
        blind_spots: blind_spots(&assumed, &outcome),
        model_baseline: "model.baseline.toml".to_owned(),
        model_after: "model.after.toml".to_owned(),
        notes,
    };
    Ok(Diagnosis {
        document,
        baseline,
        after,
        plans,
        rows,
        before: given.iter().copied().collect(),
        left: left.iter().copied().collect(),
        explained: if outcome.unexplained.is_some() || !outcome.after.hypotheses.is_empty() {
            explained.iter().copied().collect()
        } else {
            vec![0.0; before.len()]
        },
        level: expected_after.iter().copied().collect(),
        of_bench,
    })
}

/// The readings and the model that they are compared with.
struct Given {
    assumed: AssumedModel,
    rows: Vec<Row>,
    notes: Vec<String>,
    /// Readings that no fit sees.
    kept_back: Vec<Observed>,
    /// What the model predicts before anything is fitted.
    as_given: DVector<f64>,
}

impl Given {
    /// # Errors
    /// [`DiagnoseError`] for readings that are none, too few or dark.
    fn of(
        model: &Model,
        observations: &[Observations],
        held_out: Option<&Observations>,
    ) -> Result<Self, DiagnoseError> {
        let (mut parts, mut rows, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        let mut kept_back: Vec<Observed> = Vec::new();
        for (file, set) in observations.iter().enumerate() {
            let (fitted, held) = observed(set, file);
            parts.push(fitted.part);
            rows.extend(fitted.rows);
            notes.extend(fitted.notes);
            kept_back.extend(held);
        }
        kept_back.extend(held_out.map(|set| observed(set, 0).0));
        if rows.is_empty() {
            return Err(DiagnoseError::Nothing);
        }
        let assumed = AssumedModel::new(model.clone(), parts);
        let parameters = assumed.nuisances();
        // Where nothing is refitted and the noise is as stated, one reading is enough.
        let alone = parameters == 0 && model.u_scale() == UncertaintyScale::Stated;
        if rows.len() <= parameters + 2 && !alone {
            return Err(DiagnoseError::TooFew {
                rows: rows.len(),
                parameters,
            });
        }
        let as_given = assumed
            .predict(&vec![0.0; parameters], &[])
            .ok_or(DiagnoseError::NoPrediction)?;
        if as_given.iter().all(|value| *value == 0.0) {
            return Err(DiagnoseError::Dark);
        }
        Ok(Self {
            assumed,
            rows,
            notes,
            kept_back,
            as_given,
        })
    }
}

/// What no effect explains, as a share of `excess`, the σ² beyond the noise.
fn unexplained(found: &Unexplained, excess: f64) -> UnexplainedEntry {
    let total = excess.max(found.sigma.powi(2));
    UnexplainedEntry {
        coordinate: found.alternative.coordinate.name().into(),
        range: found.alternative.range,
        share_of_gap: (found.sigma.powi(2) / total).clamp(0.0, 1.0),
        significance_sigma: found.sigma,
        note: found.alternative.note.clone(),
    }
}

/// Data that leave more than this share of an uncertainty say nothing of the term.
const UNSEEN: f64 = 0.98;

/// What the model knows of itself and these data see.
fn known(outcome: &Outcome) -> Vec<KnownEntry> {
    let terms = outcome.known.iter().enumerate();
    terms
        .map(|(k, one)| KnownEntry {
            what: one.what.clone(),
            u: one.u,
            unit: one.unit.into(),
            assumed: one.assumed,
            before_sigma: outcome.moved_before.sigma[k],
            after_sigma: outcome.moved_after.sigma[k],
            u_after_sigma: outcome.moved_after.u_sigma[k],
        })
        .filter(|entry| entry.u_after_sigma < UNSEEN)
        .collect()
}

/// What was assumed of a model whose file does not state it.
fn stated(model: &Model, known: &[KnownEntry]) -> Vec<String> {
    let mut notes = Vec::new();
    if model.states_nothing() {
        notes.push(
            "the model's file states no uncertainty ([luminaire.u]), as files of a catalogue do: its level, a smooth shape over γ and \
             an oval cross-section were refitted freely"
                .to_owned(),
        );
    }
    let mut assumed: Vec<String> = known
        .iter()
        .filter(|one| one.assumed)
        .map(|one| format!("{} ±{}{}", one.what, digits(one.u, 2), unit(&one.unit)))
        .collect();
    // Orders of one pattern have one name.
    assumed.dedup();
    if !assumed.is_empty() {
        notes.push(format!(
            "the model's file does not state how uncertain these are, and they were assumed (standard uncertainties): {}",
            assumed.join("; ")
        ));
    }
    notes
}

fn unit(unit: &str) -> String {
    match unit {
        "" | "°" => unit.to_owned(),
        unit => format!(" {unit}"),
    }
}

fn noise(outcome: &Outcome, independence: Independence) -> NoiseEntry {
    NoiseEntry {
        scale: outcome.noise.scale,
        autocorrelation: outcome.noise.rho,
        n_null: outcome.nulls,
        p_global: (independence != Independence::SameRun).then_some(outcome.p_global),
        test: outcome.noise_test.as_ref().map(noise_test),
    }
}

fn model_after(
    assumed: &AssumedModel,
    outcome: &Outcome,
    entries: &[EffectEntry],
    sha256: &str,
    settings: &Settings,
) -> Option<Model> {
    let model = assumed.model(&outcome.after.nuisance, &outcome.after.hypotheses)?;
    let mut effects: Vec<Effect> = model.effects().to_vec();
    let hypotheses = &outcome.after.hypotheses;
    for (number, entry) in entries.iter().enumerate() {
        let effect = &mut effects[assumed.place(hypotheses, number)];
        let number = |value: f64| toml::Value::Float(value);
        let u: toml::Table = entry
            .parameters
            .iter()
            .map(|(key, parameter)| (key.to_string(), number(parameter.u)))
            .collect();
        let mut evidence = toml::Table::new();
        evidence.insert("ln_bayes_factor".into(), number(entry.evidence.ln_bayes_factor));
        evidence.insert("p_value".into(), number(entry.evidence.p_value));
        evidence.insert("posterior".into(), number(entry.evidence.posterior));
        evidence.insert("significance_sigma".into(), number(entry.evidence.significance_sigma));
        let alternatives = entry
            .equivalents
            .iter()
            .map(|name| toml::Value::String(name.clone()))
            .collect();
        evidence.insert("alternatives".into(), toml::Value::Array(alternatives));
        let mut provenance = toml::Table::new();
        provenance.insert("by".into(), toml::Value::String("isolux diagnose".into()));
        provenance.insert("data_sha256".into(), toml::Value::String(sha256.to_owned()));
        provenance.insert("seed".into(), toml::Value::Integer(settings.seed as i64));
        effect.notes.u = Some(u);
        effect.notes.evidence = Some(evidence);
        effect.notes.provenance = Some(provenance);
    }
    Some(model.with_effects(effects))
}

/// Whether `model` was made from other data than those with the fingerprints `sha256`, joined by `+`.
pub fn independence(model: &Model, sha256: &str) -> Independence {
    let these = |text: &str| {
        let mut prints = text.split('+');
        prints.any(|print| !print.is_empty() && sha256.split('+').any(|of_these| of_these == print))
    };
    let texts = |table: &toml::Table| table.values().filter_map(|value| value.as_str()).any(these);
    let of_effects = model
        .effects()
        .iter()
        .filter_map(|effect| effect.notes.provenance.as_ref());
    if model.provenance().into_iter().chain(of_effects).any(texts) {
        return Independence::SameRun;
    }
    match model.provenance() {
        Some(provenance) if provenance.keys().any(|key| key.contains("sha256")) => Independence::Independent,
        _ => Independence::NotShown,
    }
}
