//! An effect with its values, as a model holds it.

use crate::effects::{Act, EffectSpec, MOST_KEYS, Role, Stage, Values, by_name, floor};

/// What is written beside an effect's values: kept as it was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Notes {
    /// `[effect.u]`: standard uncertainties by key.
    pub u: Option<toml::Table>,
    /// `[effect.evidence]`.
    pub evidence: Option<toml::Table>,
    /// `[effect.provenance]`.
    pub provenance: Option<toml::Table>,
}

/// One effect of the catalogue with its values.
#[derive(Debug, Clone)]
pub struct Effect {
    spec: &'static EffectSpec,
    values: Values,
    /// What stands beside the values.
    pub notes: Notes,
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.spec.name == other.spec.name && self.values == other.values && self.notes == other.notes
    }
}

/// Why an effect is impossible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// Not in the catalogue.
    #[error("effect `{0}` is not in the catalogue")]
    UnknownName(String),
    /// A key that the effect does not have.
    #[error("effect `{effect}` has no key `{key}`; its keys are {keys}")]
    UnknownKey {
        /// The effect.
        effect: &'static str,
        /// The key.
        key: String,
        /// Its keys.
        keys: String,
    },
    /// A key that must be there.
    #[error("effect `{effect}` needs `{key}`")]
    MissingKey {
        /// The effect.
        effect: &'static str,
        /// The key.
        key: &'static str,
    },
    /// A value that is not finite, or outside what it can be.
    #[error("effect `{effect}`: {key} = {value} is not possible: {expected}")]
    Value {
        /// The effect.
        effect: &'static str,
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// Another number of values than keys.
    #[error("effect `{effect}` has {expected} keys, not {found}")]
    Count {
        /// The effect.
        effect: &'static str,
        /// Its number of keys.
        expected: usize,
        /// The number of values.
        found: usize,
    },
}

impl Effect {
    /// An effect from its values in the order of its keys.
    ///
    /// # Errors
    /// [`EffectError`] when a value is not possible.
    pub fn new(spec: &'static EffectSpec, values: &[f64]) -> Result<Self, EffectError> {
        if values.len() != spec.parameters.len() {
            return Err(EffectError::Count {
                effect: spec.name,
                expected: spec.parameters.len(),
                found: values.len(),
            });
        }
        for (parameter, &value) in spec.parameters.iter().zip(values) {
            let refuse = |expected| {
                Err(EffectError::Value {
                    effect: spec.name,
                    key: parameter.key,
                    value,
                    expected,
                })
            };
            if !value.is_finite() {
                return refuse("it must be finite");
            }
            if parameter.above_zero && value <= 0.0 {
                return refuse("it must be above zero");
            }
            if parameter.role == Role::RangeId && value.fract() != 0.0 {
                return refuse("it must be a whole number");
            }
        }
        let mut kept = [0.0; MOST_KEYS];
        kept[..values.len()].copy_from_slice(values);
        Ok(Self {
            spec,
            values: kept,
            notes: Notes::default(),
        })
    }

    /// An effect from keys and values; keys that are not required and not given take their null.
    ///
    /// # Errors
    /// [`EffectError`] for an unknown name or key, a missing key, an impossible value.
    pub fn from_keys<'a>(name: &str, given: impl IntoIterator<Item = (&'a str, f64)>) -> Result<Self, EffectError> {
        let spec = by_name(name).ok_or_else(|| EffectError::UnknownName(name.to_owned()))?;
        let mut values: Vec<Option<f64>> = vec![None; spec.parameters.len()];
        for (key, value) in given {
            let Some(index) = spec.index_of(key) else {
                let keys = spec
                    .parameters
                    .iter()
                    .map(|parameter| parameter.key)
                    .collect::<Vec<_>>()
                    .join(", ");
                return Err(EffectError::UnknownKey {
                    effect: spec.name,
                    key: key.to_owned(),
                    keys,
                });
            };
            values[index] = Some(value);
        }
        for (parameter, value) in spec.parameters.iter().zip(&values) {
            if let Some(value) = value.filter(|value| parameter.share && !(0.0..=1.0).contains(value)) {
                return Err(EffectError::Value {
                    effect: spec.name,
                    key: parameter.key,
                    value,
                    expected: "it must be from 0 to 1",
                });
            }
        }
        let is_amplitude = |role| matches!(role, Role::Amplitude | Role::Alternative);
        let has_amplitude = spec
            .parameters
            .iter()
            .zip(&values)
            .any(|(p, v)| is_amplitude(p.role) && v.is_some());
        if !has_amplitude {
            return Err(EffectError::MissingKey {
                effect: spec.name,
                key: spec.parameters[0].key,
            });
        }
        for (parameter, value) in spec.parameters.iter().zip(&mut values) {
            if value.is_none() {
                if parameter.required {
                    return Err(EffectError::MissingKey {
                        effect: spec.name,
                        key: parameter.key,
                    });
                }
                *value = Some(parameter.null);
            }
        }
        Self::new(spec, &values.into_iter().flatten().collect::<Vec<_>>())
    }

    /// The light that a floor of this reflectance, so far below the axes, returns.
    ///
    /// # Errors
    /// [`EffectError`] for a height that is not above zero, or a number that is not finite.
    pub fn of_floor(albedo: f64, height_mm: f64) -> Result<Self, EffectError> {
        Self::new(floor(), &[albedo, height_mm])
    }

    /// What is known of it.
    pub fn spec(&self) -> &'static EffectSpec {
        self.spec
    }

    /// Its id.
    pub fn name(&self) -> &'static str {
        self.spec.name
    }

    /// Values in the order of its keys.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.spec.parameters.len()]
    }

    /// The value of a key.
    pub fn value(&self, key: &str) -> Option<f64> {
        self.spec.index_of(key).map(|index| self.values[index])
    }

    /// Whether every amplitude is null.
    pub fn is_null(&self) -> bool {
        self.spec.parameters.iter().zip(&self.values).all(|(parameter, value)| {
            !matches!(parameter.role, Role::Amplitude | Role::Alternative) || *value == parameter.null
        })
    }

    /// Whether it changes this kind of observation.
    pub fn acts_on(&self, stage: Stage) -> bool {
        self.spec.stages.contains(&stage)
    }

    /// What it does to a prediction, with its values.
    pub(crate) fn acts(&self) -> impl Iterator<Item = (&'static Act, &Values)> {
        self.spec.acts.iter().map(|act| (act, &self.values))
    }
}
