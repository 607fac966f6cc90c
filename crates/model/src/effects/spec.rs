//! What is known of an effect before any data: names, keys, ranges, look-alikes.

use super::act::Act;

/// What an effect is a property of; decides where it is applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BelongsTo {
    /// Axes, mount, room, detector, reading chain: applied when that bench's readings are predicted, never in a
    /// simulation.
    Bench,
    /// The luminaire: applied in predictions and in simulations.
    Luminaire,
    /// The sensor: applied to maps and scenes.
    Sensor,
    /// The air between: applied to both, over their own path length.
    Path,
}

impl BelongsTo {
    /// The word in the documentation.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Bench => "bench",
            Self::Luminaire => "luminaire",
            Self::Sensor => "sensor",
            Self::Path => "path",
        }
    }
}

/// A kind of observation that an effect changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Goniometer readings.
    Readings,
    /// Sensor maps.
    Maps,
    /// Spectra.
    Spectra,
}

/// The part that a parameter plays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// The effect vanishes where this is null.
    Amplitude,
    /// Another way of writing the amplitude, in another unit: read and applied, not fitted.
    Alternative,
    /// A direction or phase: the effect is two components, at 0 and a quarter of the period.
    Phase {
        /// After which it repeats, in the parameter's unit.
        period: f64,
    },
    /// Changes the shape; values worth trying.
    Shape {
        /// Values over the plausible range.
        grid: &'static [f64],
    },
    /// A period in time or space: what is worth trying depends on the sampling.
    Period,
    /// The meter's range in which the effect acts: one candidate for each range in the data.
    RangeId,
    /// Stays at its default unless the file says otherwise.
    Constant,
}

/// One key of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSpec {
    /// The key in a model file, its unit in its name.
    pub key: &'static str,
    /// The unit.
    pub unit: &'static str,
    /// Value at which an amplitude has no effect; for other roles the value that is assumed where none is better.
    pub null: f64,
    /// What a bench plausibly shows; a fit outside is flagged.
    pub plausible: (f64, f64),
    /// A change that is large enough to see in a difference of predictions and small enough to be nearly linear.
    pub step: f64,
    /// Its part.
    pub role: Role,
    /// Where it acts.
    pub stages: &'static [Stage],
    /// Whether a model file must give it.
    pub required: bool,
}

/// How to tell an effect from one that looks like it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// The look-alike.
    pub from: &'static str,
    /// The measurement block that separates them, in the words of `next_measurement`.
    pub by: &'static str,
}

/// One effect of the catalogue.
#[derive(Debug)]
pub struct EffectSpec {
    /// The id in model files.
    pub name: &'static str,
    /// The term of the standards.
    pub standard_name: &'static str,
    /// What it does, in one sentence for somebody who has never read of it: placeholders as in [`super::sentence`].
    pub sentence: &'static str,
    /// What it is a property of.
    pub belongs_to: &'static [BelongsTo],
    /// What it changes.
    pub stages: &'static [Stage],
    /// The formula, E being the reading, γ, C, d, t its coordinates.
    pub formula: &'static str,
    /// Where the formula is from.
    pub source: &'static str,
    /// Its keys; the first is the amplitude.
    pub parameters: &'static [ParameterSpec],
    /// The response grows like the amplitude to this power.
    pub amplitude_power: u8,
    /// The coordinate along which it shows, in the words of `where`.
    pub shows_in: &'static str,
    /// What looks like it, and what separates the two.
    pub splits: &'static [Split],
    /// What it does to a prediction.
    pub acts: &'static [Act],
}

impl EffectSpec {
    /// Names of the effects that look like this one.
    pub fn look_alikes(&self) -> impl Iterator<Item = &'static str> {
        self.splits.iter().map(|split| split.from)
    }

    /// Index of a key.
    pub fn index_of(&self, key: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.key == key)
    }

    /// Whether it is one of these things' properties.
    pub fn belongs_to(&self, owner: BelongsTo) -> bool {
        self.belongs_to.contains(&owner)
    }
}

pub(super) const READINGS: &[Stage] = &[Stage::Readings];
pub(super) const MAPS: &[Stage] = &[Stage::Maps];
pub(super) const SPECTRA: &[Stage] = &[Stage::Spectra];
pub(super) const READINGS_AND_MAPS: &[Stage] = &[Stage::Readings, Stage::Maps];

/// An amplitude with null 0.
pub(super) const fn amplitude(
    key: &'static str,
    unit: &'static str,
    plausible: (f64, f64),
    step: f64,
    stages: &'static [Stage],
) -> ParameterSpec {
    ParameterSpec {
        key,
        unit,
        null: 0.0,
        plausible,
        step,
        role: Role::Amplitude,
        stages,
        required: false,
    }
}

/// An azimuth in degrees that repeats after `period`.
pub(super) const fn azimuth(period: f64, stages: &'static [Stage]) -> ParameterSpec {
    ParameterSpec {
        key: "azimuth_deg",
        unit: "°",
        null: 0.0,
        plausible: (0.0, 360.0),
        step: 5.0,
        role: Role::Phase { period },
        stages,
        required: false,
    }
}

/// A parameter of shape that a model file must give.
pub(super) const fn shape(
    key: &'static str,
    unit: &'static str,
    typical: f64,
    plausible: (f64, f64),
    grid: &'static [f64],
    stages: &'static [Stage],
) -> ParameterSpec {
    let step = (plausible.1 - plausible.0) * 0.02;
    ParameterSpec {
        key,
        unit,
        null: typical,
        plausible,
        step,
        role: Role::Shape { grid },
        stages,
        required: true,
    }
}
