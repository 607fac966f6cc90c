//! Which effects can be searched for on these data, with which shapes, sizes and limits.

use isolux_model::{Effect, EffectSpec, Emitter, ParameterSpec, Role, Sampling, ShapeTrust, Stage, catalogue};

use super::rows::{heads, row_ranges};
use super::{AssumedModel, Part, Recipe};
use crate::calibration::{MOST_FREQUENCIES, SMALL_STEP};
use crate::forward::{Searchable, Spread};

/// Frequencies times readings: 10⁵ readings are searched at 300 frequencies, so that their patterns fit in memory.
const MOST_VALUES: f64 = 3e7;
/// Sizes over the plausible range of an emitter that takes the place of a disc.
const REPLACED_SIZES: usize = 4;

/// What the model has of an effect already: its place in the list and its values there, and whether they are more than
/// nothing.
type Known = (Option<(usize, Vec<f64>)>, bool);

/// One shape parameter as it is searched and fitted.
struct Shape {
    grid: Vec<f64>,
    bounds: (f64, f64),
    step: f64,
    assumed: Spread,
}

impl AssumedModel {
    pub(super) fn list_effects(&mut self, stages: &[Stage]) {
        let peak_lx = self.peak_lx();
        for &spec in catalogue() {
            if let Some((searchable, recipe)) = self.searched(spec, stages, peak_lx) {
                self.searchable.push(searchable);
                self.recipes.push(recipe);
            }
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

    /// The largest signal that was measured, in full scales; 1 where there are no maps.
    fn largest_signal(&self) -> f64 {
        let of_part = |part: &Part| match part {
            Part::Maps(maps) => {
                let (signal, _) = maps.values()?;
                Some(signal.iter().copied().fold(0.0, f64::max) / maps.full_scale().unwrap_or(1.0))
            }
            _ => None,
        };
        let largest = self.parts.iter().filter_map(of_part).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// How an effect is searched for; none where it does not act on these data.
    fn searched(&self, spec: &'static EffectSpec, stages: &[Stage], peak_lx: f64) -> Option<(Searchable, Recipe)> {
        if !spec.stages.iter().any(|stage| stages.contains(stage)) {
            return None;
        }
        if spec.shape_over_gamma && self.model.trust().shape == ShapeTrust::Smooth {
            return None;
        }
        let (known, changed) = self.known_already(spec)?;
        let other_heads = !heads(&self.parts).is_empty();
        let active = |k: usize| {
            let acts = stages.iter().any(|stage| spec.key_acts_on(k, *stage));
            acts && (other_heads || !spec.parameters[k].of_other_heads)
        };
        let keys = 0..spec.parameters.len();
        let amplitudes: Vec<usize> = keys
            .clone()
            .filter(|&k| spec.parameters[k].role == Role::Amplitude && active(k))
            .collect();
        if amplitudes.is_empty() {
            return None;
        }
        let phase = keys.clone().find_map(|k| match spec.parameters[k].role {
            Role::Phase { period } if active(k) => Some((k, period)),
            _ => None,
        });
        let of_shape = |k: usize| {
            matches!(
                spec.parameters[k].role,
                Role::Shape { .. } | Role::Azimuth { .. } | Role::Period(_) | Role::RangeId
            )
        };
        let with_leds = matches!(self.model.luminaire().emitter(), Emitter::Leds { .. });
        let has_meaning = |k: usize| !(with_leds && spec.parameters[k].without_leds);
        // What has changed keeps its shape, but counts from a time of its own.
        let free = |k: usize| match spec.parameters[k].role {
            Role::Origin { .. } => known.is_some(),
            _ => !changed && of_shape(k) && has_meaning(k),
        };
        let keys: Vec<usize> = keys.filter(|&k| active(k) && free(k)).collect();
        let shapes: Vec<Shape> = keys.iter().map(|&k| self.shape(&spec.parameters[k])).collect();
        if shapes.iter().any(|shape| shape.grid.is_empty()) {
            return None;
        }
        let power = f64::from(spec.amplitude_power);
        let of = |value: f64| value.abs().powf(power);
        let mut step: Vec<f64> = amplitudes.iter().map(|&k| of(spec.parameters[k].step)).collect();
        let mut plausible: Vec<f64> = amplitudes
            .iter()
            .map(|&k| of(largest(&spec.parameters[k], peak_lx)))
            .collect();
        if phase.is_some() {
            step = vec![step[0]; 2];
            plausible = vec![plausible[0]; 2];
        }
        let first = &spec.parameters[amplitudes[0]];
        let positive = first.plausible.0 >= first.null;
        let natural = positive && step.len() == 1;
        let before = |place: usize| {
            let null = spec.parameters[place].null;
            known.as_ref().map_or(0.0, |(_, values)| of(values[place] - null))
        };
        let limits = (0..step.len())
            .map(|k| {
                let place = amplitudes[k.min(amplitudes.len() - 1)];
                limits(&spec.parameters[place], natural, before(place))
            })
            .collect();
        let mut tried = product(&shapes);
        let (mut step_share, mut least) = (Vec::new(), 0.0);
        // What takes the place of a disc changes nothing at the disc's size and not where it has none: every size has a
        // pattern of its own.
        let extent_mm = self.model.luminaire().emitter().extent_mm();
        let replaced = spec.replaces_emitter() && !changed && extent_mm > first.plausible.0;
        if replaced {
            let (low, high) = first.plausible;
            let sizes: Vec<f64> = (0..REPLACED_SIZES)
                .map(|k| of(low + (high - low) * k as f64 / (REPLACED_SIZES - 1) as f64))
                .collect();
            least = sizes[0];
            step_share = tried
                .iter()
                .flat_map(|_| sizes.iter().map(|size| size / step[0]))
                .collect();
            tried = tried
                .into_iter()
                .flat_map(|shape| vec![shape; REPLACED_SIZES])
                .collect();
        }
        // A square grows with the second order, unless a shape (LEDs that lean) gives it a first one: then small sizes
        // have a pattern of their own.
        let leaning: Vec<Vec<f64>> = if power != 1.0 && !changed && !replaced {
            let leans = |shape: &&Vec<f64>| shape.iter().any(|value| *value != 0.0);
            tried.iter().filter(leans).cloned().collect()
        } else {
            Vec::new()
        };
        if !leaning.is_empty() {
            least = of(first.plausible.0.max(0.0));
            step_share = vec![1.0; tried.len()];
            step_share.extend(vec![SMALL_STEP; leaning.len()]);
            tried.extend(leaning);
        }
        if let Some(values) = spec.tried.filter(|_| !changed) {
            let values = values(self.largest_signal());
            tried = vec![Vec::new(); values.len()];
            step_share = values.iter().map(|value| value / step[0]).collect();
        }
        let is = |of: fn(Role) -> bool| keys.iter().map(|&k| of(spec.parameters[k].role)).collect();
        let searchable = Searchable {
            name: spec.name,
            step_share,
            least,
            one_sided: natural && !changed,
            one_by_one: (spec.tried.is_some() || spec.period_of_signal) && !changed,
            period_of_signal: spec.period_of_signal && !changed,
            chosen_from: 0,
            limits,
            turns: phase.is_some(),
            never_negative: power != 1.0 && !changed,
            step,
            plausible,
            shapes: tried,
            bounds: shapes.iter().map(|shape| shape.bounds).collect(),
            assumed: shapes.iter().map(|shape| shape.assumed).collect(),
            shape_step: shapes.iter().map(|shape| shape.step).collect(),
            oscillates: if changed { None } else { self.beats(spec) },
            fixed: is(|role| role == Role::RangeId),
        };
        let recipe = Recipe {
            spec,
            amplitudes,
            phase,
            inverse: is(|role| matches!(role, Role::Period(_))),
            shapes: keys,
            power,
            known,
        };
        Some((searchable, recipe))
    }

    /// What the model has of an effect; none where it has it twice: neither is the one that changed.
    fn known_already(&self, spec: &EffectSpec) -> Option<Known> {
        let same = |effect: &Effect| effect.name() == spec.name;
        let mine: Vec<usize> = (0..self.model.effects().len())
            .filter(|&i| same(&self.model.effects()[i]))
            .collect();
        match mine.as_slice() {
            [] => Some((None, false)),
            [place] => {
                let effect = &self.model.effects()[*place];
                // At its null it is as good as not there, and any shape is open.
                let values = if effect.is_null() {
                    spec.parameters.iter().map(|parameter| parameter.null).collect()
                } else {
                    effect.values().to_vec()
                };
                Some((Some((*place, values)), !effect.is_null()))
            }
            _ => None,
        }
    }

    /// The grid of a shape parameter, its bounds, and what is assumed of it.
    fn shape(&self, parameter: &ParameterSpec) -> Shape {
        let (low, high) = parameter.plausible;
        match parameter.role {
            Role::Period(sampling) => {
                let grid = self.frequencies(sampling);
                let spacing = if grid.len() > 1 { grid[1] - grid[0] } else { 1e-3 };
                let top = grid.last().copied();
                Shape {
                    bounds: (0.5 * spacing, top.map_or(1.0, |f| f + spacing)),
                    step: 0.02 * spacing,
                    assumed: Spread {
                        middle: None,
                        width: top.unwrap_or(1.0).max(spacing),
                    },
                    grid,
                }
            }
            Role::Azimuth { grid } => Shape {
                grid: grid.to_vec(),
                bounds: (low - 360.0, high + 360.0),
                step: 0.5,
                assumed: Spread {
                    middle: None,
                    width: 360.0,
                },
            },
            Role::Shape { grid } => Shape {
                grid: grid.to_vec(),
                bounds: if low > 0.0 {
                    (0.5 * low, 2.0 * high)
                } else {
                    (low, high)
                },
                // Tables are bent at every degree: a shorter step sees the bend, not the slope.
                step: if parameter.unit == "°" {
                    1.0
                } else {
                    1e-3 * (high - low)
                },
                assumed: Spread::over(low, high),
            },
            Role::Origin { within: (low, high) } => Shape {
                grid: vec![low, high],
                bounds: (low, high),
                step: 1e-2 * (high - low),
                assumed: Spread::over(low, high),
            },
            // The number of a range: the others are no shapes.
            _ => Shape {
                grid: self.ranges(),
                bounds: (f64::NEG_INFINITY, f64::INFINITY),
                step: 0.0,
                assumed: Spread {
                    middle: None,
                    width: 1.0,
                },
            },
        }
    }

    /// Frequencies worth trying for a period in time or along the sensor: from one over the span to half the sampling.
    fn frequencies(&self, sampling: Sampling) -> Vec<f64> {
        let (span, step) = if sampling == Sampling::Rows {
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
        spec.beats().then_some(())?;
        let mut times = Vec::new();
        for part in &self.parts {
            let Part::Readings(readings) = part else { return None };
            times.extend(readings.iter().map(|at| at.lamp_age_s().unwrap_or(f64::NAN)));
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
}

/// Smallest and largest amplitude that may be added to what the model has, `before`. `natural`: it has one sign.
fn limits(parameter: &ParameterSpec, natural: bool, before: f64) -> (f64, f64) {
    let low = if natural { -before } else { f64::NEG_INFINITY };
    // No part gives less than nothing, no floor more than it gets.
    let high = if parameter.share { 1.0 - before } else { f64::INFINITY };
    (low, high)
}

/// The largest plausible size of an amplitude. What is plausible in lx follows the light of the bench: 1.5 % of the
/// peak reading, 0.5 % over the range.
fn largest(parameter: &ParameterSpec, peak_lx: f64) -> f64 {
    let stated = (parameter.plausible.0 - parameter.null)
        .abs()
        .max((parameter.plausible.1 - parameter.null).abs());
    match parameter.unit {
        "lx" => stated.max(0.015 * peak_lx),
        "1/lx" if peak_lx > 0.0 => stated.max(0.005 / peak_lx),
        _ => stated,
    }
}

/// Every combination of one value from each grid; one empty combination for no grids.
fn product(shapes: &[Shape]) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for Shape { grid, .. } in shapes {
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
