//! A model file and the coordinates of observations, as the statistics see them.

mod rows;
mod searched;

use std::collections::BTreeMap;

use isolux_model::{BelongsTo, Effect, EffectSpec, Model, Refined, Role, ShapeTrust, Stage};
use isolux_record::observation::MapUnit;
use nalgebra::DVector;

use crate::calibration::{HEADS_SIGMA, LN_SHAPE_TERMS, SHAPE_SIGMA};
use crate::forward::{Forward, Hypothesis, Searchable};
use crate::known::Known;
use crate::reference::Errors;

pub use rows::{Part, direction_errors, known, row_ranges};
use rows::{distinct_gammas, heads, level_is_known, reach};

/// A model with everything that may be refitted or added.
#[derive(Debug)]
pub struct AssumedModel {
    model: Model,
    parts: Vec<Part>,
    nuisance: Vec<Nuisance>,
    recipes: Vec<Recipe>,
    searchable: Vec<Searchable>,
    refined: Refined,
}

/// What one nuisance parameter changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Nuisance {
    LnShape(usize),
    Harmonic(usize),
    MapGain,
    HeadGain(usize),
    Tan2,
    Tan4,
    SpectralGain,
}

/// How the linear amplitudes and shapes of a hypothesis become the values of an effect.
#[derive(Debug, Clone)]
struct Recipe {
    spec: &'static EffectSpec,
    /// Amplitude keys that act on these data.
    amplitudes: Vec<usize>,
    /// The key of direction or phase with its period, if the effect has one.
    phase: Option<(usize, f64)>,
    /// Keys of shape.
    shapes: Vec<usize>,
    /// Shapes that are searched as 1/value.
    inverse: Vec<bool>,
    power: f64,
    /// Its place in the model's list and its values there, where the model has it already: a hypothesis adds to them.
    known: Option<(usize, Vec<f64>)>,
}

impl AssumedModel {
    /// Joins a model with coordinates. `gamma_max_deg` is the largest |γ| that any of the readings to be fitted has.
    pub fn new(model: Model, parts: Vec<Part>) -> Self {
        let stages: Vec<Stage> = parts
            .iter()
            .map(|part| match part {
                Part::Readings(_) => Stage::Readings,
                Part::Maps(_) => Stage::Maps,
                Part::Spectra(..) => Stage::Spectra,
            })
            .collect();
        let mut refined = model.refined().clone();
        let mut nuisance = Vec::new();
        let has = |stage: Stage| stages.contains(&stage);
        let smooth = model.trust().shape == ShapeTrust::Smooth;
        let relative = parts
            .iter()
            .any(|part| matches!(part, Part::Maps(maps) if maps.unit() == MapUnit::Relative));
        let absolute = parts
            .iter()
            .any(|part| matches!(part, Part::Maps(maps) if maps.unit() != MapUnit::Relative));
        if smooth && has(Stage::Readings) {
            if refined.ln_shape.is_empty() {
                refined.gamma_max_deg = reach(&parts);
            }
            let terms = LN_SHAPE_TERMS.min(distinct_gammas(&parts)).max(1);
            refined.ln_shape.resize(refined.ln_shape.len().max(terms), 0.0);
            nuisance.extend((0..terms).map(Nuisance::LnShape));
        } else if smooth && absolute {
            refined.ln_shape.resize(refined.ln_shape.len().max(1), 0.0);
            nuisance.push(Nuisance::LnShape(0));
        }
        for &m in &model.trust().c_harmonics {
            if has(Stage::Readings) || has(Stage::Maps) && !smooth {
                let place = refined
                    .c_harmonics
                    .iter()
                    .position(|harmonic| harmonic.m == m)
                    .unwrap_or_else(|| {
                        refined
                            .c_harmonics
                            .push(isolux_model::Harmonic { m, amplitude_rel: 0.0 });
                        refined.c_harmonics.len() - 1
                    });
                if has(Stage::Readings) {
                    nuisance.push(Nuisance::Harmonic(place));
                }
            }
        }
        if relative {
            nuisance.push(Nuisance::MapGain);
        }
        let heads = heads(&parts);
        let known = refined.head_gains.len();
        refined
            .head_gains
            .resize(known.max(heads.last().map_or(0, |last| *last as usize)), 1.0);
        nuisance.extend(heads.iter().map(|head| Nuisance::HeadGain(*head as usize - 1)));
        if smooth && has(Stage::Maps) && !has(Stage::Readings) {
            nuisance.extend([Nuisance::Tan2, Nuisance::Tan4]);
        }
        let free_gain = |part: &Part| matches!(part, Part::Spectra(spectra, _) if !level_is_known(spectra));
        if parts.iter().any(free_gain) && !nuisance.contains(&Nuisance::LnShape(0)) {
            refined.ln_shape.resize(refined.ln_shape.len().max(1), 0.0);
            nuisance.push(Nuisance::SpectralGain);
        }
        let mut assumed = Self {
            model,
            parts,
            nuisance,
            recipes: Vec::new(),
            searchable: Vec::new(),
            refined,
        };
        assumed.start_gain();
        assumed.list_effects(&stages);
        assumed
    }

    /// The catalogue entry of effect `number`.
    pub fn spec(&self, number: usize) -> &'static EffectSpec {
        self.recipes[number].spec
    }

    /// The model as it was given, its gain of relative maps brought near.
    pub fn given(&self) -> &Model {
        &self.model
    }

    /// The same model with one more part behind these.
    #[must_use]
    pub fn with_part(&self, part: Part) -> Self {
        let parts = self.parts.iter().cloned().chain([part]).collect();
        Self::new(self.model.clone(), parts)
    }

    /// The parts, in row order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The model with nuisance and effects written into it.
    pub fn model(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<Model> {
        let mut effects = self.model.effects().to_vec();
        for hypothesis in hypotheses {
            let effect = self.effect(hypothesis)?;
            match &self.recipes[hypothesis.effect].known {
                Some((place, _)) => effects[*place] = effect,
                None => effects.push(effect),
            }
        }
        Some(self.model.with_refined(self.refined(nuisance)).with_effects(effects))
    }

    /// The effect that a hypothesis stands for.
    pub fn effect(&self, hypothesis: &Hypothesis) -> Option<Effect> {
        Effect::new(self.recipes[hypothesis.effect].spec, &self.values(hypothesis)).ok()
    }

    /// The values that the model has of an effect before the hypothesis, where it has it.
    pub fn known(&self, effect: usize) -> Option<&[f64]> {
        self.recipes[effect].known.as_ref().map(|(_, values)| values.as_slice())
    }

    /// The effect's place among the effects of [`model`](Self::model) with these hypotheses.
    pub fn place(&self, hypotheses: &[Hypothesis], number: usize) -> usize {
        let new = |hypothesis: &Hypothesis| self.recipes[hypothesis.effect].known.is_none();
        match &self.recipes[hypotheses[number].effect].known {
            Some((place, _)) => *place,
            None => self.model.effects().len() + hypotheses[..number].iter().filter(|h| new(h)).count(),
        }
    }

    /// The effect's values, in the order of its keys.
    pub fn values(&self, hypothesis: &Hypothesis) -> Vec<f64> {
        let recipe = &self.recipes[hypothesis.effect];
        let nulls = || recipe.spec.parameters.iter().map(|parameter| parameter.null).collect();
        let mut values: Vec<f64> = recipe.known.as_ref().map_or_else(nulls, |(_, values)| values.clone());
        let before = values.clone();
        if let Some((key, period)) = recipe.phase {
            // What is known already is a vector of its own; the change adds to it.
            let amplitude = recipe.amplitudes[0];
            let null = recipe.spec.parameters[amplitude].null;
            let (sin, cos) = (values[key] / period * std::f64::consts::TAU).sin_cos();
            let before = (values[amplitude] - null).abs().powf(recipe.power);
            let (p, q) = (before * cos + hypothesis.linear[0], before * sin + hypothesis.linear[1]);
            values[amplitude] = null + p.hypot(q).powf(1.0 / recipe.power);
            values[key] = (q.atan2(p) / std::f64::consts::TAU * period).rem_euclid(period);
        } else {
            for (&key, amount) in recipe.amplitudes.iter().zip(&hypothesis.linear) {
                let null = recipe.spec.parameters[key].null;
                if recipe.power == 1.0 {
                    values[key] += *amount;
                } else {
                    let before = (values[key] - null).max(0.0).powf(recipe.power);
                    values[key] = null + (before + amount).max(0.0).powf(1.0 / recipe.power);
                }
            }
        }
        for ((&key, &inverse), &shape) in recipe.shapes.iter().zip(&recipe.inverse).zip(&hypothesis.shape) {
            let value = if inverse { 1.0 / shape } else { shape };
            values[key] = match recipe.spec.parameters[key].role {
                Role::Azimuth { .. } => value.rem_euclid(360.0),
                Role::Origin { .. } => {
                    // Two straight lines are one: a·(t − t₁) + b·(t − t₂).
                    let amplitude = recipe.amplitudes[0];
                    let null = recipe.spec.parameters[amplitude].null;
                    let (first, both) = (before[amplitude] - null, values[amplitude] - null);
                    let moved = (first * before[key] + (both - first) * value) / both;
                    if moved.is_finite() { moved } else { before[key] }
                }
                _ => value,
            };
        }
        values
    }

    /// Keys (their number in the effect) that a fit moves, in the order linear, then free shapes; for the propagation
    /// of uncertainty.
    pub fn moved_keys(&self, effect: usize) -> Vec<usize> {
        let recipe = &self.recipes[effect];
        let mut keys = recipe.amplitudes.clone();
        keys.extend(recipe.phase.map(|(key, _)| key));
        keys.extend(&recipe.shapes);
        keys
    }

    fn refined(&self, nuisance: &[f64]) -> Refined {
        let mut refined = self.refined.clone();
        for (kind, &value) in self.nuisance.iter().zip(nuisance) {
            match *kind {
                Nuisance::LnShape(k) => refined.ln_shape[k] += value,
                Nuisance::Harmonic(k) => refined.c_harmonics[k].amplitude_rel += value,
                Nuisance::MapGain => refined.map_gain *= value.exp(),
                Nuisance::HeadGain(k) => refined.head_gains[k] *= value.exp(),
                Nuisance::Tan2 => refined.tan2 += value,
                Nuisance::Tan4 => refined.tan4 += value,
                Nuisance::SpectralGain => refined.ln_shape[0] += value,
            }
        }
        refined
    }

    /// Brings the gain of relative maps near its value, so that the fit starts where it is linear.
    fn start_gain(&mut self) {
        let model = self.model.with_refined(self.refined.clone());
        let (mut predicted, mut measured) = (0.0, 0.0);
        for part in &self.parts {
            if let Part::Maps(maps) = part
                && maps.unit() == MapUnit::Relative
                && let Some((signal, _)) = maps.values()
            {
                predicted += model.predict_maps(maps).iter().sum::<f64>();
                measured += signal.iter().sum::<f64>();
            }
        }
        if predicted > 0.0 && measured > 0.0 {
            self.refined.map_gain *= measured / predicted;
        }
    }

    /// Whether an effect belongs to the bench that measured: then the run can be reduced again without it.
    pub fn belongs_to_bench(&self, effect: usize) -> bool {
        self.recipes[effect].spec.belongs_to(BelongsTo::Bench)
    }
}

impl Forward for AssumedModel {
    fn nuisances(&self) -> usize {
        self.nuisance.len()
    }

    /// The level is free; a term of the shape beyond it is a few tenths of ln I at most, less the finer it is, so that
    /// terms that no reading holds do not run away between and beyond the readings. The heads of two meters agree
    /// within their calibrations.
    fn nuisance_weights(&self) -> Vec<f64> {
        let weight = |kind: &Nuisance| match kind {
            Nuisance::LnShape(k) if *k > 0 => (*k as f64 / SHAPE_SIGMA).powi(2),
            Nuisance::HeadGain(_) => HEADS_SIGMA.powi(-2),
            _ => 0.0,
        };
        self.nuisance.iter().map(weight).collect()
    }

    fn shape_terms(&self) -> Vec<Option<usize>> {
        let order = |kind: &Nuisance| match kind {
            Nuisance::LnShape(k) => Some(*k),
            _ => None,
        };
        self.nuisance.iter().map(order).collect()
    }

    fn common_errors(&self) -> Errors {
        let model = self.model.with_refined(self.refined.clone());
        let mut all = BTreeMap::new();
        let mut start = 0;
        for (part, rows) in self.parts.iter().zip(row_ranges(&self.parts)) {
            for error in direction_errors(&model, part) {
                let rows = error.errors.into_iter().map(|(row, value)| (start + row, value));
                all.entry(error.number).or_insert_with(Vec::new).extend(rows);
            }
            start = rows.end;
        }
        all.into_values().collect()
    }

    fn known(&self) -> Vec<Known> {
        known(&self.model.with_refined(self.refined.clone()), &self.parts)
    }

    fn effects(&self) -> &[Searchable] {
        &self.searchable
    }

    fn read_out(&self, effect: usize, amplitude: f64, prediction: &DVector<f64>) -> Option<DVector<f64>> {
        let spec = self.recipes[effect].spec;
        // Only what acts on nothing but the signals of maps.
        spec.readout(&[amplitude], 0.0)?;
        let full_scale = self.full_scale()?;
        let mut changed = prediction.clone();
        for (row, &full_scale) in full_scale
            .iter()
            .enumerate()
            .filter(|(_, full_scale)| !full_scale.is_nan())
        {
            changed[row] = full_scale * spec.readout(&[amplitude], changed[row] / full_scale)?;
        }
        Some(changed)
    }

    fn full_scale(&self) -> Option<DVector<f64>> {
        let ranges = row_ranges(&self.parts);
        let mut full_scale = vec![f64::NAN; ranges.last().map_or(0, |last| last.end)];
        for (part, rows) in self.parts.iter().zip(ranges) {
            let Part::Maps(maps) = part else { continue };
            let relative = (maps.unit() == MapUnit::Relative).then_some(1.0);
            full_scale[rows].fill(maps.full_scale().or(relative)?);
        }
        full_scale
            .iter()
            .any(|value| !value.is_nan())
            .then(|| DVector::from_vec(full_scale))
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        let model = self.model(nuisance, hypotheses)?;
        let mut values = Vec::new();
        for part in &self.parts {
            values.extend(part.predict(&model)?);
        }
        values
            .iter()
            .all(|value| value.is_finite())
            .then(|| DVector::from_vec(values))
    }
}
