//! The whole diagnosis of a model against observations: search, gap, held-out check, next measurement, new model.

use std::collections::BTreeMap;

use isolux_model::{Effect, Model, Role, UncertaintyScale};
use isolux_record::observation::Observations;
use nalgebra::{DMatrix, DVector};

use crate::believed::{Believed, Part, direction_errors};
use crate::document::{
    BlindSpot, Document, EffectEntry, EvidenceEntry, GapEntry, HeldOutEntry, Independence, NoiseEntry, ParameterEntry,
    PlaceEntry, RankedEntry, UnexplainedEntry, Verdict,
};
use crate::fit::{Fit, Whitener, derivatives, fit, nuisance_tangents};
use crate::forward::{Forward, Hypothesis};
use crate::held_out;
use crate::next::{self, Next};
use crate::observe::{Observed, observed};
use crate::reference::{self, Errors};
use crate::rounding::Rounding;
use crate::search::{Label, Outcome, Settings, search};
use crate::table::Row;

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
    /// (measured − baseline)/(s·u) of each row.
    pub before: Vec<f64>,
    /// (measured − after)/(s·u) of each row.
    pub left: Vec<f64>,
    /// What the added effects change, in s·u of each row: the fit through the residuals.
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
    let believed = Believed::new(model.clone(), parts);
    if rows.len() <= believed.nuisances() + 2 {
        return Err(DiagnoseError::TooFew {
            rows: rows.len(),
            parameters: believed.nuisances(),
        });
    }
    let zero = vec![0.0; believed.nuisances()];
    let as_given = believed.predict(&zero, &[]).ok_or(DiagnoseError::NoPrediction)?;
    if as_given.iter().all(|value| *value == 0.0) {
        return Err(DiagnoseError::Dark);
    }
    let settings = Settings {
        fit_scale: model.u_scale() == UncertaintyScale::Fit,
        ..*settings
    };
    let outcome = search(&believed, &rows, &settings).ok_or(DiagnoseError::NoPrediction)?;

    let effects = effect_entries(&believed, &outcome);
    let verdict = verdict(&outcome, &effects);
    let measured = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.measured));
    let sigma = DVector::from_iterator(rows.len(), rows.iter().map(|row| outcome.noise.scale * row.u));
    let scaled = |prediction: &DVector<f64>| (&measured - prediction).component_div(&sigma);
    let before = scaled(&outcome.baseline.prediction);
    let left = scaled(&outcome.after.prediction);
    let mut explained = &outcome.after.prediction - &outcome.baseline.prediction;
    if let Some(unexplained) = &outcome.unexplained {
        explained += &unexplained.pattern;
    }
    explained.component_div_assign(&sigma);
    let gap = gap(
        &believed,
        &outcome,
        &rows,
        &scaled(&as_given),
        &before,
        &left,
        &kept_back,
    );
    let unexplained = outcome.unexplained.as_ref().map(|unexplained| {
        let total = (before.norm_squared() - rows.len() as f64).max(unexplained.sigma.powi(2));
        UnexplainedEntry {
            coordinate: unexplained.rival.coordinate.name(),
            range: unexplained.rival.range,
            share_of_gap: (unexplained.sigma.powi(2) / total).clamp(0.0, 1.0),
            significance_sigma: unexplained.sigma,
            note: unexplained.rival.note.clone(),
        }
    });
    let Next {
        entries: next_measurement,
        plans,
    } = next::suggest(&believed, &outcome, &rows);
    let baseline = believed
        .model(&outcome.baseline.nuisance, &[])
        .ok_or(DiagnoseError::NoPrediction)?;
    let after = model_after(&believed, &outcome, &effects, sha256, &settings).ok_or(DiagnoseError::NoPrediction)?;
    let of_bench = outcome
        .after
        .hypotheses
        .iter()
        .filter(|member| believed.belongs_to_bench(member.effect))
        .map(|member| believed.spec(member.effect).name)
        .collect();
    let sentence = sentence(verdict, &effects, unexplained.as_ref(), &outcome);
    let document = Document {
        verdict,
        sentence,
        places: places(&outcome),
        ranked: ranked(&believed, &outcome),
        effects,
        unexplained,
        noise: NoiseEntry {
            scale: outcome.noise.scale,
            autocorrelation: outcome.noise.rho,
            n_null: outcome.nulls,
            p_global: outcome.p_global,
        },
        gap,
        independence: independence(model, sha256),
        next_measurement,
        blind_spots: blind_spots(&believed, &outcome),
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
        before: before.iter().copied().collect(),
        left: left.iter().copied().collect(),
        explained: if outcome.unexplained.is_some() || !outcome.after.hypotheses.is_empty() {
            explained.iter().copied().collect()
        } else {
            vec![0.0; before.len()]
        },
        level: outcome.after.prediction.iter().copied().collect(),
        of_bench,
    })
}

/// Members of the 95 % set of each effect: its own name left out.
fn effect_entries(believed: &Believed, outcome: &Outcome) -> Vec<EffectEntry> {
    let covariance = outcome.after.covariance(outcome.noise.scale);
    let mut place = outcome.after.nuisance.len();
    let mut entries = Vec::new();
    for (member, rivalry) in outcome.after.hypotheses.iter().zip(&outcome.rivalries) {
        let spec = believed.spec(member.effect);
        let free = member.linear.len()
            + believed.effects()[member.effect]
                .fixed
                .iter()
                .filter(|fixed| !**fixed)
                .count();
        let own = covariance.view((place, place), (free, free)).into_owned();
        place += free;
        let mut equivalents = Vec::new();
        // The set is among those that could make it: what belongs to "nothing" asks for no further names.
        let limit = 0.95 * rivalry.ranked.iter().map(|ranked| ranked.posterior).sum::<f64>();
        let mut sum = 0.0;
        let mut posterior = 0.0;
        let mut sigma = 0.0;
        for ranked in &rivalry.ranked {
            let is_own = ranked.label == Label::Named(member.effect);
            if is_own {
                posterior = ranked.posterior;
                sigma = ranked.sigma;
            }
            if sum < limit && !is_own {
                equivalents.push(label(believed, ranked.label));
            }
            sum += ranked.posterior;
        }
        entries.push(EffectEntry {
            name: spec.name,
            standard_name: spec.standard_name,
            equivalents,
            parameters: parameters(believed, member, &own),
            evidence: EvidenceEntry {
                ln_bayes_factor: rivalry.ln_bayes_factor,
                p_value: rivalry.p_value,
                posterior,
                significance_sigma: sigma,
            },
        });
    }
    entries
}

fn label(believed: &Believed, label: Label) -> String {
    match label {
        Label::Named(effect) => believed.spec(effect).name.to_owned(),
        Label::Unnamed(coordinate) => format!("unnamed:{}", coordinate.name()),
    }
}

/// Values of the keys that a fit moves, with the uncertainty that the fit's covariance leaves them.
fn parameters(
    believed: &Believed,
    member: &Hypothesis,
    covariance: &DMatrix<f64>,
) -> BTreeMap<&'static str, ParameterEntry> {
    let searchable = &believed.effects()[member.effect];
    let values = believed.values(member);
    let free_shapes: Vec<usize> = (0..member.shape.len()).filter(|&j| !searchable.fixed[j]).collect();
    let columns: Vec<Vec<f64>> = (0..covariance.nrows())
        .map(|k| {
            let mut moved = member.clone();
            let step = covariance[(k, k)].max(0.0).sqrt().max(1e-12) * 1e-2;
            match k.checked_sub(member.linear.len()) {
                None => moved.linear[k] += step,
                Some(j) => moved.shape[free_shapes[j]] += step,
            }
            believed
                .values(&moved)
                .iter()
                .zip(&values)
                .map(|(a, b)| wrapped(a - b) / step)
                .collect()
        })
        .collect();
    let spec = believed.spec(member.effect);
    believed
        .moved_keys(member.effect)
        .into_iter()
        .map(|key| {
            let parameter = &spec.parameters[key];
            let slope = DVector::from_iterator(columns.len(), columns.iter().map(|column| column[key]));
            let variance = slope.dot(&(covariance * &slope));
            let (low, high) = parameter.plausible;
            let entry = ParameterEntry {
                value: values[key],
                u: variance.max(0.0).sqrt(),
                unit: parameter.unit,
                plausible: [low, high],
                before: believed.known(member.effect).map(|before| before[key]),
                implausible: parameter.role == Role::Amplitude && !(low..=high).contains(&values[key]),
            };
            (parameter.key, entry)
        })
        .collect()
}

/// A difference of angles that jumped by a turn is a small one.
fn wrapped(difference: f64) -> f64 {
    if difference > 180.0 {
        difference - 360.0
    } else if difference < -180.0 {
        difference + 360.0
    } else {
        difference
    }
}

fn verdict(outcome: &Outcome, effects: &[EffectEntry]) -> Verdict {
    if outcome.unexplained.is_some() {
        Verdict::Unexplained
    } else if effects.iter().any(|effect| !effect.equivalents.is_empty()) {
        Verdict::Ambiguous
    } else if effects.is_empty() {
        Verdict::Consistent
    } else {
        Verdict::Named
    }
}

fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

fn removed(before: f64, after: f64, floor: f64) -> f64 {
    (before * before - after * after) / (before * before - floor * floor)
}

fn gap(
    believed: &Believed,
    outcome: &Outcome,
    rows: &[Row],
    as_given: &DVector<f64>,
    before: &DVector<f64>,
    left: &DVector<f64>,
    kept_back: &[Observed],
) -> GapEntry {
    let n = rows.len() as f64;
    let parameters = outcome.after.jacobian.ncols() as f64;
    let all = |values: &DVector<f64>| rms(values.iter().copied());
    let variance = reference::variance(&outcome.errors, rows.len());
    let sigma = rows.iter().map(|row| outcome.noise.scale * row.u);
    let floor = floor(variance.iter().copied().zip(sigma)) * ((n - parameters).max(1.0) / n).sqrt();
    let (first, after) = (all(before), all(left));
    let named = !outcome.after.hypotheses.is_empty();
    let (held_out, held_out_note) = match (named, kept_back.is_empty()) {
        (false, _) => (
            None,
            "no effect was added, so there is nothing to check on readings kept back".to_owned(),
        ),
        (true, false) => given_back(believed, outcome, kept_back),
        (true, true) => by_rule(believed, outcome, rows),
    };
    GapEntry {
        metric: "rms((measured − predicted)/(s·u))",
        as_given: all(as_given),
        before: first,
        after,
        floor,
        removed: (named && first > floor).then(|| removed(first, after, floor)),
        held_out,
        held_out_note,
    }
}

/// The rms that noise alone leaves, in σ of the readings: theirs, and what the noise of the model's own distribution adds (variance, σ of each).
fn floor(rows: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (variance, sigma) in rows {
        sum += 1.0 + variance / (sigma * sigma);
        count += 1.0;
    }
    if count > 0.0 { f64::sqrt(sum / count) } else { 1.0 }
}

/// The held-out gap is only worth saying where the added effects should show there: their change, in σ, as a whole.
const VISIBLE_SIGMA: f64 = 3.0;

fn held_out_entry(
    before: f64,
    after: f64,
    floor: f64,
    readings: usize,
    visible: f64,
    note: String,
) -> (Option<HeldOutEntry>, String) {
    if visible < VISIBLE_SIGMA || before <= floor {
        let why = format!("{note}; the effect changes them by {visible:.1} σ in all: they cannot show it");
        return (None, why);
    }
    (
        Some(HeldOutEntry {
            before,
            after,
            floor,
            removed: removed(before, after, floor),
            readings,
        }),
        note,
    )
}

/// Readings that were given to be held out: predicted by the two models of the whole fit.
fn given_back(believed: &Believed, outcome: &Outcome, kept_back: &[Observed]) -> (Option<HeldOutEntry>, String) {
    let (Some(baseline), Some(after)) = (
        believed.model(&outcome.baseline.nuisance, &[]),
        believed.model(&outcome.after.nuisance, &outcome.after.hypotheses),
    ) else {
        return (None, "the held-out readings could not be predicted".to_owned());
    };
    let mut sums = (0.0, 0.0, 0.0, 0_usize);
    let mut squares = 0.0;
    for held in kept_back {
        for error in direction_errors(&after, &held.part) {
            let sigma = |row: usize| outcome.noise.scale * held.rows[row].u;
            squares += error
                .errors
                .iter()
                .map(|&(row, value)| (value / sigma(row)).powi(2))
                .sum::<f64>();
        }
        let (Some(first), Some(second)) = (predicted(&baseline, &held.part), predicted(&after, &held.part)) else {
            return (None, "the held-out readings could not be predicted".to_owned());
        };
        for ((row, a), b) in held.rows.iter().zip(first).zip(second) {
            let sigma = outcome.noise.scale * row.u;
            sums.0 += ((row.measured - a) / sigma).powi(2);
            sums.1 += ((row.measured - b) / sigma).powi(2);
            sums.2 += ((b - a) / sigma).powi(2);
            sums.3 += 1;
        }
    }
    let n = sums.3.max(1) as f64;
    let note = format!("{} readings that were given to be held out", sums.3);
    held_out_entry(
        (sums.0 / n).sqrt(),
        (sums.1 / n).sqrt(),
        (1.0 + squares / n).sqrt(),
        sums.3,
        sums.2.sqrt(),
        note,
    )
}

fn predicted(model: &Model, part: &Part) -> Option<Vec<f64>> {
    match part {
        Part::Readings(readings) => Some(model.predict_readings(readings)),
        Part::Maps(maps) => Some(model.predict_maps(maps)),
        Part::Spectra(spectra, rows) => {
            let all = model.predict_spectra(spectra).ok()?;
            Some(rows.iter().map(|&row| all[row]).collect())
        }
    }
}

/// A second fit of the same effects without whole planes, maps and dark blocks, which it then predicts. Of the rules the first
/// whose rows the remaining ones can predict.
fn by_rule(believed: &Believed, outcome: &Outcome, rows: &[Row]) -> (Option<HeldOutEntry>, String) {
    let mut why = "too few half-planes or maps to keep any back".to_owned();
    for first in held_out::RULES {
        let Some(held) = held_out::by_rule(rows, first) else {
            continue;
        };
        match without(believed, outcome, rows, held) {
            Ok(entry) => return entry,
            Err(note) => why = note,
        }
    }
    (None, why)
}

/// A fit that cannot predict what it has not seen better than this (rms, in σ) says nothing of the effect.
const PREDICTABLE_SIGMA: f64 = 0.5;

/// As [`by_rule`], for one choice of rows; an error says why they are no test.
fn without(
    believed: &Believed,
    outcome: &Outcome,
    rows: &[Row],
    held: held_out::HeldOut,
) -> Result<(Option<HeldOutEntry>, String), String> {
    let scale = DVector::from_iterator(
        rows.len(),
        rows.iter().zip(&held.rows).zip(&outcome.noise.weights).map(
            |((row, &held), weight)| {
                if held { 0.0 } else { weight.sqrt() / row.u }
            },
        ),
    );
    let (sequence, rounding) = (&outcome.sequence, &outcome.rounding);
    let whitener = Whitener::new(sequence, rounding, scale, outcome.noise.rho, &outcome.errors);
    let measured = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.measured));
    let start = &outcome.baseline.nuisance;
    let fits = nuisance_tangents(believed, start).and_then(|tangents| {
        let refit = |members: &[Hypothesis]| fit(believed, &measured, &whitener, start, &tangents, members);
        Some((refit(&[])?, refit(&outcome.after.hypotheses)?))
    });
    let Some((baseline, after)) = fits else {
        return Err("the second fit did not succeed".to_owned());
    };
    let pick: Vec<usize> = (0..rows.len()).filter(|&i| held.rows[i]).collect();
    let sigma = |i: usize| outcome.noise.scale * rows[i].u;
    let alone = Rounding::default();
    let each = DVector::from_fn(rows.len(), |i, _| 1.0 / sigma(i));
    let plain = Whitener::new(sequence, &alone, each, 0.0, &Errors::new());
    let u_predicted = derivatives(believed, &plain, &after).map_or(0.0, |slopes| {
        let slopes = slopes.select_rows(&pick);
        let covariance = after.covariance(outcome.noise.scale);
        ((&slopes * covariance).component_mul(&slopes).sum() / pick.len() as f64).sqrt()
    });
    if u_predicted > PREDICTABLE_SIGMA {
        return Err(format!(
            "{}: the others cannot predict them better than {u_predicted:.1} σ, so they are no test",
            held.note
        ));
    }
    let of = |fitted: &Fit| {
        rms(pick
            .iter()
            .map(|&i| (rows[i].measured - fitted.prediction[i]) / sigma(i)))
    };
    let visible = pick
        .iter()
        .map(|&i| ((after.prediction[i] - baseline.prediction[i]) / sigma(i)).powi(2))
        .sum::<f64>()
        .sqrt();
    let variance = reference::variance(&outcome.errors, rows.len());
    let floor = floor(pick.iter().map(|&i| (variance[i], sigma(i))));
    Ok(held_out_entry(
        of(&baseline),
        of(&after),
        floor,
        pick.len(),
        visible,
        held.note,
    ))
}

fn places(outcome: &Outcome) -> Vec<PlaceEntry> {
    let mut entries: Vec<PlaceEntry> = outcome
        .places
        .iter()
        .filter(|place| place.sigma >= 3.0)
        .map(|place| PlaceEntry {
            coordinate: place.coordinate.name(),
            significance_sigma: place.sigma,
            range: place.range,
            note: place.note.clone(),
        })
        .collect();
    if outcome.p_global > 0.01 && outcome.after.hypotheses.is_empty() && outcome.unexplained.is_none() {
        entries.clear();
    }
    entries
}

fn ranked(believed: &Believed, outcome: &Outcome) -> Vec<Vec<RankedEntry>> {
    outcome
        .rivalries
        .iter()
        .map(|rivalry| {
            let mut rows: Vec<RankedEntry> = rivalry
                .ranked
                .iter()
                .enumerate()
                .filter(|(rank, ranked)| *rank < 8 || ranked.posterior >= 0.01)
                .map(|(_, ranked)| RankedEntry {
                    name: label(believed, ranked.label),
                    posterior: ranked.posterior,
                    significance_sigma: ranked.sigma,
                    ln_evidence: ranked.ln_evidence,
                })
                .collect();
            // The row without a name is always there.
            if !rows.iter().any(|row| row.name.starts_with("unnamed"))
                && let Some(unnamed) = rivalry
                    .ranked
                    .iter()
                    .find(|ranked| matches!(ranked.label, Label::Unnamed(_)))
            {
                rows.push(RankedEntry {
                    name: label(believed, unnamed.label),
                    posterior: unnamed.posterior,
                    significance_sigma: unnamed.sigma,
                    ln_evidence: unnamed.ln_evidence,
                });
            }
            rows
        })
        .collect()
}

fn blind_spots(believed: &Believed, outcome: &Outcome) -> Vec<BlindSpot> {
    let mut spots: Vec<BlindSpot> = Vec::new();
    for &(effect, component, sigma) in &outcome.visibility {
        if component > 0 {
            continue;
        }
        let spec = believed.spec(effect);
        let Some(key) = believed.moved_keys(effect).first().copied() else {
            continue;
        };
        let parameter = &spec.parameters[key];
        let plausible_max = (parameter.plausible.1 - parameter.null)
            .abs()
            .max((parameter.plausible.0 - parameter.null).abs());
        let amplitude = (sigma > 1e-9)
            .then(|| plausible_max * (5.0 / sigma).powf(1.0 / f64::from(spec.amplitude_power)))
            .filter(|amplitude| *amplitude < 1e4 * plausible_max);
        spots.push(BlindSpot {
            effect: spec.name,
            parameter: parameter.key,
            amplitude_at_5_sigma: amplitude,
            plausible_max,
            blind: amplitude.is_none_or(|amplitude| amplitude > plausible_max),
        });
    }
    spots
}

fn model_after(
    believed: &Believed,
    outcome: &Outcome,
    entries: &[EffectEntry],
    sha256: &str,
    settings: &Settings,
) -> Option<Model> {
    let model = believed.model(&outcome.after.nuisance, &outcome.after.hypotheses)?;
    let mut effects: Vec<Effect> = model.effects().to_vec();
    let hypotheses = &outcome.after.hypotheses;
    for (number, entry) in entries.iter().enumerate() {
        let effect = &mut effects[believed.place(hypotheses, number)];
        let number = |value: f64| toml::Value::Float(value);
        let u: toml::Table = entry
            .parameters
            .iter()
            .map(|(key, parameter)| ((*key).to_owned(), number(parameter.u)))
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

fn independence(model: &Model, sha256: &str) -> Independence {
    let Some(provenance) = model.provenance() else {
        return Independence::NotShown;
    };
    let texts: Vec<&str> = provenance.iter().filter_map(|(_, value)| value.as_str()).collect();
    if texts.iter().any(|text| !text.is_empty() && sha256.contains(*text)) {
        Independence::SameRun
    } else if provenance.keys().any(|key| key.contains("sha256")) {
        Independence::Independent
    } else {
        Independence::NotShown
    }
}

/// What the amplitudes of an effect that the model has already have changed to; nothing for a new one.
fn changes(effect: &EffectEntry) -> String {
    let changed: Vec<String> = effect
        .parameters
        .iter()
        .filter_map(|(key, parameter)| {
            let before = parameter.before.filter(|before| *before != parameter.value)?;
            let (from, to) = (digits(before, 3), digits(parameter.value, 3));
            Some(format!("{key} changed from {from} to {to}"))
        })
        .collect();
    if changed.is_empty() {
        String::new()
    } else {
        format!(" ({})", changed.join(", "))
    }
}

/// A number with so many significant digits: 0.00123, 12.3, 1230.
pub fn digits(value: f64, significant: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    let places = (significant as i32 - 1 - magnitude).max(0) as usize;
    if places > 9 {
        return format!("{value:.*e}", significant - 1);
    }
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

fn sentence(
    verdict: Verdict,
    effects: &[EffectEntry],
    unexplained: Option<&UnexplainedEntry>,
    outcome: &Outcome,
) -> String {
    let sets: Vec<String> = effects
        .iter()
        .map(|effect| {
            let mut set = vec![format!("{}{}", effect.name, changes(effect))];
            set.extend(effect.equivalents.iter().cloned());
            set.join(" or ")
        })
        .collect();
    let named = sets.join(", and ");
    match verdict {
        Verdict::Consistent => format!(
            "model and measurement agree within noise (p = {:.3}, noise {:.2} × stated)",
            outcome.p_global, outcome.noise.scale
        ),
        Verdict::Named => format!("the data single out {named}"),
        Verdict::Ambiguous => format!("something is missing, and these data cannot tell which: {named}"),
        Verdict::Unexplained => {
            let place = unexplained.map_or_else(String::new, |u| {
                format!(
                    "{}, along {} between {} and {} ({:.1} σ)",
                    u.note,
                    u.coordinate,
                    digits(u.range[0], 4),
                    digits(u.range[1], 4),
                    u.significance_sigma
                )
            });
            let besides = if named.is_empty() {
                String::new()
            } else {
                format!("; besides: {named}")
            };
            format!("unexplained: {place}; no effect in the catalogue makes it{besides}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_keep_their_digits_and_lose_their_noughts() {
        assert_eq!(digits(0.0, 3), "0");
        assert_eq!(digits(0.000_123_456, 2), "0.00012");
        assert_eq!(digits(-12.34, 3), "-12.3");
        assert_eq!(digits(1234.56, 3), "1235");
        assert_eq!(digits(0.5, 3), "0.5");
        assert_eq!(digits(3e-12, 2), "3.0e-12");
    }
}
