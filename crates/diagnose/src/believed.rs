//! A model file and the coordinates of observations, as the statistics see them.

use std::collections::BTreeMap;
use std::ops::Range;

use isolux_model::{BelongsTo, DirectionError, Effect, EffectSpec, Model, Refined, Role, ShapeTrust, Stage, catalogue};
use isolux_record::ReadingKind;
use isolux_record::observation::{MapSet, MapUnit, ReadingCoordinates, SpectraSet};
use nalgebra::DVector;

use crate::forward::{Forward, Hypothesis, Searchable, Spread};
use crate::reference::Errors;

/// Where the rows of one observation file come from.
#[derive(Debug, Clone)]
pub enum Part {
    /// Goniometer readings.
    Readings(Vec<ReadingCoordinates>),
    /// Bins of sensor maps.
    Maps(MapSet),
    /// Samples of spectra, and which rows of the file they are.
    Spectra(SpectraSet, Vec<usize>),
}

/// A model with everything that may be refitted or added.
#[derive(Debug)]
pub struct Believed {
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

/// What is believed of the first of these terms after the level; of the k-th a k-th of it.
const SHAPE_SIGMA: f64 = 0.3;
/// Even Chebyshev terms of ln I that an analyst refits, where the readings have as many |γ|.
const LN_SHAPE_TERMS: usize = 9;
/// Frequencies of modulated light that are searched at most, from the lowest.
const MOST_FREQUENCIES: f64 = 2000.0;
/// Frequencies times readings: 10⁵ readings are searched at 300 frequencies, so that their patterns fit in memory.
const MOST_VALUES: f64 = 3e7;
/// Share of a squared amplitude's step at which it counts as small.
const SMALL_STEP: f64 = 0.01;
/// Angles closer than this count as one: what a term does between two of them no reading sees but through the emitter's extent.
const APART_DEG: f64 = 0.5;

impl Believed {
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
        if smooth && has(Stage::Maps) && !has(Stage::Readings) {
            nuisance.extend([Nuisance::Tan2, Nuisance::Tan4]);
        }
        if has(Stage::Spectra) && !nuisance.contains(&Nuisance::LnShape(0)) {
            refined.ln_shape.resize(refined.ln_shape.len().max(1), 0.0);
            nuisance.push(Nuisance::SpectralGain);
        }
        let mut believed = Self {
            model,
            parts,
            nuisance,
            recipes: Vec::new(),
            searchable: Vec::new(),
            refined,
        };
        believed.start_gain();
        believed.list_effects(&stages);
        believed
    }

    /// The catalogue entry of effect `number`.
    pub fn spec(&self, number: usize) -> &'static EffectSpec {
        self.recipes[number].spec
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
            values[key] = if recipe.spec.parameters[key].key == "azimuth_deg" {
                value.rem_euclid(360.0)
            } else {
                value
            };
        }
        values
    }

    /// Keys (their number in the effect) that a fit moves, in the order linear, then free shapes; for the propagation of
    /// uncertainty.
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

    /// The largest reading that the model expects, in lx; 0 where there are no readings.
    fn peak_lx(&self) -> f64 {
        let model = self.model.with_refined(self.refined.clone());
        let of_part = |part: &Part| match part {
            Part::Readings(readings) => model.predict_readings(readings).into_iter().fold(0.0, f64::max),
            _ => 0.0,
        };
        self.parts.iter().map(of_part).fold(0.0, f64::max)
    }

    fn list_effects(&mut self, stages: &[Stage]) {
        let peak_lx = self.peak_lx();
        for &spec in catalogue() {
            if !spec.stages.iter().any(|stage| stages.contains(stage)) {
                continue;
            }
            let same = |effect: &Effect| effect.name() == spec.name;
            let mine: Vec<usize> = (0..self.model.effects().len())
                .filter(|&i| same(&self.model.effects()[i]))
                .collect();
            let (known, changed) = match mine.as_slice() {
                [] => (None, false),
                [place] => {
                    let effect = &self.model.effects()[*place];
                    // At its null it is as good as not there, and any shape is open.
                    let values = if effect.is_null() {
                        spec.parameters.iter().map(|parameter| parameter.null).collect()
                    } else {
                        effect.values().to_vec()
                    };
                    (Some((*place, values)), !effect.is_null())
                }
                // Twice the same effect: neither is the one that changed.
                _ => continue,
            };
            let active = |k: usize| spec.parameters[k].stages.iter().any(|stage| stages.contains(stage));
            let keys = 0..spec.parameters.len();
            let amplitudes: Vec<usize> = keys
                .clone()
                .filter(|&k| spec.parameters[k].role == Role::Amplitude && active(k))
                .collect();
            if amplitudes.is_empty() {
                continue;
            }
            let phase = keys.clone().find_map(|k| match spec.parameters[k].role {
                Role::Phase { period } if active(k) => Some((k, period)),
                _ => None,
            });
            // What has changed keeps its shape.
            let shapes: Vec<usize> = keys
                .filter(|&k| {
                    active(k)
                        && !changed
                        && matches!(
                            spec.parameters[k].role,
                            Role::Shape { .. } | Role::Period | Role::RangeId
                        )
                })
                .collect();
            let mut grids: Vec<Vec<f64>> = Vec::new();
            let mut bounds = Vec::new();
            let mut steps = Vec::new();
            let mut believed = Vec::new();
            for &k in &shapes {
                let parameter = &spec.parameters[k];
                let (low, high) = parameter.plausible;
                match parameter.role {
                    Role::Period => {
                        let frequencies = self.frequencies(parameter.key);
                        let spacing = if frequencies.len() > 1 {
                            frequencies[1] - frequencies[0]
                        } else {
                            1e-3
                        };
                        bounds.push((0.5 * spacing, frequencies.last().map_or(1.0, |f| f + spacing)));
                        steps.push(0.02 * spacing);
                        let top = frequencies.last().copied().unwrap_or(1.0);
                        believed.push(Spread {
                            middle: None,
                            width: top.max(spacing),
                        });
                        grids.push(frequencies);
                    }
                    Role::RangeId => {
                        grids.push(self.ranges());
                        bounds.push((f64::NEG_INFINITY, f64::INFINITY));
                        steps.push(0.0);
                        believed.push(Spread {
                            middle: None,
                            width: 1.0,
                        });
                    }
                    Role::Shape { grid } if parameter.key == "azimuth_deg" => {
                        believed.push(Spread {
                            middle: None,
                            width: 360.0,
                        });
                        grids.push(grid.to_vec());
                        bounds.push((low - 360.0, high + 360.0));
                        steps.push(0.5);
                    }
                    Role::Shape { grid } => {
                        believed.push(Spread::over(low, high));
                        grids.push(grid.to_vec());
                        bounds.push(if low > 0.0 {
                            (0.5 * low, 2.0 * high)
                        } else {
                            (low, high)
                        });
                        // Tables are bent at every degree: a shorter step sees the bend, not the slope.
                        let tilts = parameter.unit == "°";
                        steps.push(if tilts { 1.0 } else { 1e-3 * (high - low) });
                    }
                    _ => {}
                }
            }
            if grids.iter().any(Vec::is_empty) {
                continue;
            }
            let power = f64::from(spec.amplitude_power);
            let of = |value: f64| value.abs().powf(power);
            let mut step: Vec<f64> = amplitudes.iter().map(|&k| of(spec.parameters[k].step)).collect();
            let largest = |k: usize| {
                let parameter = &spec.parameters[k];
                let stated = (parameter.plausible.0 - parameter.null)
                    .abs()
                    .max((parameter.plausible.1 - parameter.null).abs());
                // What is plausible in lx follows the light of the bench: 1.5 % of the peak reading, 0.5 % over the range.
                match parameter.unit {
                    "lx" => stated.max(0.015 * peak_lx),
                    "1/lx" if peak_lx > 0.0 => stated.max(0.005 / peak_lx),
                    _ => stated,
                }
            };
            let mut plausible: Vec<f64> = amplitudes.iter().map(|&k| of(largest(k))).collect();
            if phase.is_some() {
                step = vec![step[0]; 2];
                plausible = vec![plausible[0]; 2];
            }
            let first = &spec.parameters[amplitudes[0]];
            let positive = first.plausible.0 >= first.null;
            let natural = positive && step.len() == 1;
            let before = |k: usize| {
                let null = spec.parameters[k].null;
                known.as_ref().map_or(0.0, |(_, values)| of(values[k] - null))
            };
            let limits = (0..step.len())
                .map(|k| {
                    let place = amplitudes[k.min(amplitudes.len() - 1)];
                    let key = spec.parameters[place].key;
                    let low = if natural { -before(place) } else { f64::NEG_INFINITY };
                    // No part gives less than nothing, no floor more than it gets.
                    let high = if matches!(key, "albedo" | "depth_rel") {
                        1.0 - before(place)
                    } else {
                        f64::INFINITY
                    };
                    (low, high)
                })
                .collect();
            let mut shapes_tried = product(&grids);
            let mut step_share = Vec::new();
            let mut least = 0.0;
            if power != 1.0 && !changed {
                // A square grows with the second order, unless a shape (LEDs that lean) gives it a first one: then small sizes have a pattern of their own.
                let leaning: Vec<Vec<f64>> = shapes_tried
                    .iter()
                    .filter(|shape| shape.iter().any(|value| *value != 0.0))
                    .cloned()
                    .collect();
                if !leaning.is_empty() {
                    least = of(first.plausible.0.max(0.0));
                    step_share = vec![1.0; shapes_tried.len()];
                    step_share.extend(vec![SMALL_STEP; leaning.len()]);
                    shapes_tried.extend(leaning);
                }
            }
            self.searchable.push(Searchable {
                name: spec.name,
                step_share,
                least,
                one_sided: natural && !changed,
                limits,
                turns: phase.is_some(),
                never_negative: power != 1.0 && !changed,
                step,
                plausible,
                shapes: shapes_tried,
                bounds,
                believed,
                shape_step: steps,
                oscillates: if changed { None } else { self.beats(spec) },
                fixed: shapes
                    .iter()
                    .map(|&k| spec.parameters[k].role == Role::RangeId)
                    .collect(),
            });
            let inverse = shapes
                .iter()
                .map(|&k| spec.parameters[k].role == Role::Period)
                .collect();
            self.recipes.push(Recipe {
                spec,
                amplitudes,
                phase,
                shapes,
                inverse,
                power,
                known,
            });
        }
    }

    /// Frequencies worth trying for a period in time or along the sensor: from one over the span to half the sampling.
    fn frequencies(&self, key: &str) -> Vec<f64> {
        let (span, step) = if key == "period_mm" {
            let Some((height, bins)) = self.parts.iter().find_map(|part| match part {
                Part::Maps(maps) => Some((maps.sensor_mm()[1], maps.bins()[1])),
                _ => None,
            }) else {
                return Vec::new();
            };
            (height, height / bins as f64)
        } else {
            let mut times: Vec<f64> = self
                .parts
                .iter()
                .flat_map(|part| match part {
                    Part::Readings(readings) => readings.iter().filter_map(|at| at.time_s).collect(),
                    _ => Vec::new(),
                })
                .collect();
            times.sort_by(f64::total_cmp);
            let mut gaps: Vec<f64> = times
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .filter(|gap| *gap > 0.0)
                .collect();
            gaps.sort_by(f64::total_cmp);
            let (Some(&step), Some(&first), Some(&last)) = (gaps.get(gaps.len() / 2), times.first(), times.last())
            else {
                return Vec::new();
            };
            (last - first, step)
        };
        let spacing = 1.0 / (1.6 * span);
        let rows: usize = row_ranges(&self.parts).iter().map(ExactSizeIterator::len).sum();
        let most = MOST_FREQUENCIES.min(MOST_VALUES / rows.max(1) as f64);
        let count = (0.5 / step / spacing).floor().min(most) as usize;
        (2..=count).map(|k| k as f64 * spacing).collect()
    }

    /// The time of every row, for the beat of modulated light on readings.
    fn beats(&self, spec: &EffectSpec) -> Option<Vec<f64>> {
        (spec.name == "flicker_alias").then_some(())?;
        let mut times = Vec::new();
        for part in &self.parts {
            let Part::Readings(readings) = part else { return None };
            times.extend(readings.iter().map(|at| at.time_s.unwrap_or(f64::NAN)));
        }
        Some(times)
    }

    fn ranges(&self) -> Vec<f64> {
        let mut ranges: Vec<f64> = self
            .parts
            .iter()
            .flat_map(|part| match part {
                Part::Readings(readings) => readings.iter().filter_map(|at| at.range.map(f64::from)).collect(),
                _ => Vec::new(),
            })
            .collect();
        ranges.sort_by(f64::total_cmp);
        ranges.dedup();
        ranges
    }

    /// Whether an effect belongs to the bench that measured: then the run can be reduced again without it.
    pub fn belongs_to_bench(&self, effect: usize) -> bool {
        self.recipes[effect].spec.belongs_to(BelongsTo::Bench)
    }
}

impl Forward for Believed {
    fn nuisances(&self) -> usize {
        self.nuisance.len()
    }

    /// The level is free; a term of the shape beyond it is a few tenths of ln I at most, less the finer it is, so that terms that no reading holds do
    /// not run away between and beyond the readings.
    fn nuisance_weights(&self) -> Vec<f64> {
        let weight = |kind: &Nuisance| match kind {
            Nuisance::LnShape(k) if *k > 0 => (*k as f64 / SHAPE_SIGMA).powi(2),
            _ => 0.0,
        };
        self.nuisance.iter().map(weight).collect()
    }

    fn common_errors(&self) -> Errors {
        let model = self.model.with_refined(self.refined.clone());
        let mut all = BTreeMap::new();
        let mut start = 0;
        for (part, rows) in self.parts.iter().zip(row_ranges(&self.parts)) {
            for error in direction_errors(&model, part) {
                let rows = error.errors.into_iter().map(|(row, value)| (start + row, value));
                all.entry(error.direction).or_insert_with(Vec::new).extend(rows);
            }
            start = rows.end;
        }
        all.into_values().collect()
    }

    fn effects(&self) -> &[Searchable] {
        &self.searchable
    }

    fn predict(&self, nuisance: &[f64], hypotheses: &[Hypothesis]) -> Option<DVector<f64>> {
        let model = self.model(nuisance, hypotheses)?;
        let mut values = Vec::new();
        for part in &self.parts {
            match part {
                Part::Readings(readings) => values.extend(model.predict_readings(readings)),
                Part::Maps(maps) => values.extend(model.predict_maps(maps)),
                Part::Spectra(spectra, rows) => {
                    let all = model.predict_spectra(spectra).ok()?;
                    values.extend(rows.iter().map(|&row| all[row]));
                }
            }
        }
        values
            .iter()
            .all(|value| value.is_finite())
            .then(|| DVector::from_vec(values))
    }
}

/// The largest |γ| of the readings, at least 1°.
fn reach(parts: &[Part]) -> f64 {
    let mut largest: f64 = 1.0;
    for part in parts {
        if let Part::Readings(readings) = part {
            largest = readings.iter().fold(largest, |most, at| most.max(at.gamma_deg.abs()));
        }
    }
    largest.min(180.0)
}

/// How many |γ| of lit readings are apart from each other: a shape of more terms than that would wiggle between them as it likes, and through the
/// parallax of an extended emitter such a wiggle looks like a distance.
fn distinct_gammas(parts: &[Part]) -> usize {
    let mut gammas: Vec<f64> = parts
        .iter()
        .flat_map(|part| match part {
            Part::Readings(readings) => readings.as_slice(),
            _ => &[],
        })
        .filter(|at| at.kind == ReadingKind::Lit)
        .map(|at| at.gamma_deg.abs())
        .collect();
    gammas.sort_by(f64::total_cmp);
    let (mut count, mut last) = (0, f64::NEG_INFINITY);
    for gamma in gammas {
        if gamma > last + APART_DEG {
            (count, last) = (count + 1, gamma);
        }
    }
    count
}

/// Every combination of one value from each grid; one empty combination for no grids.
fn product(grids: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for grid in grids {
        all = all
            .iter()
            .flat_map(|head| {
                grid.iter().map(move |&value| {
                    let mut one = head.clone();
                    one.push(value);
                    one
                })
            })
            .collect();
    }
    all
}

/// What the noise of each direction of the model's distribution does to the rows of a part.
pub fn direction_errors(model: &Model, part: &Part) -> Vec<DirectionError> {
    match part {
        Part::Readings(readings) => model.direction_errors_of_readings(readings),
        Part::Maps(maps) => model.direction_errors_of_maps(maps),
        Part::Spectra(..) => Vec::new(),
    }
}

/// The range of rows of each part.
pub fn row_ranges(parts: &[Part]) -> Vec<Range<usize>> {
    let mut start = 0;
    parts
        .iter()
        .map(|part| {
            let length = match part {
                Part::Readings(readings) => readings.len(),
                Part::Maps(maps) => maps.cells().len(),
                Part::Spectra(_, rows) => rows.len(),
            };
            start += length;
            start - length..start
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_has_no_more_terms_than_angles_that_hold_it() {
        let at = |gamma_deg: f64, kind: ReadingKind| ReadingCoordinates {
            kind,
            time_s: None,
            c_deg: 0.0,
            gamma_deg,
            distance_mm: 2000.0,
            travel: 0,
            range: None,
            ambient_c: None,
        };
        // Four angles, both signs, read back with an encoder's dust; darks hold no shape.
        let mut readings: Vec<ReadingCoordinates> = (-3..=3)
            .map(|k| at(8.0 * f64::from(k) + 0.01 * f64::from(k % 2), ReadingKind::Lit))
            .collect();
        readings.extend((0..9).map(|k| at(10.0 * f64::from(k), ReadingKind::Baffled)));
        assert_eq!(distinct_gammas(&[Part::Readings(readings)]), 4);
        let fine = (0..400).map(|k| at(0.2 * f64::from(k), ReadingKind::Lit)).collect();
        assert!(distinct_gammas(&[Part::Readings(fine)]) > 100);
    }
}
