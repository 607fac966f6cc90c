//! What is known of an effect before any data: names, keys, ranges, look-alikes.

use std::f64::consts::TAU;

use isolux_record::ReadingKind;

use super::act::{Act, MOST_KEYS};

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
    /// An azimuth that changes the shape, whose values are tried one by one; it repeats after 360°.
    Azimuth {
        /// Values over the circle.
        grid: &'static [f64],
    },
    /// A period in time or space: what is worth trying depends on the sampling.
    Period(Sampling),
    /// The meter's range in which the effect acts: one candidate for each range in the data.
    RangeId,
    /// Stays at its default unless the file says otherwise.
    Constant,
    /// Where the amplitude counts from, as a time in s: what the file says. A change of an amplitude that the file has
    /// counts from a time of its own.
    Origin {
        /// Ends of the range in which that time is sought.
        within: (f64, f64),
    },
}

/// What samples a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// The times of the readings: a beat of the lamp.
    Time,
    /// The rows of the sensor.
    Rows,
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
    /// The one kind of observation on which it acts; none: every kind on which its effect acts.
    pub only_on: Option<Stage>,
    /// Whether it acts on readings of other heads than that of the model alone.
    pub of_other_heads: bool,
    /// Whether a model file must give it.
    pub required: bool,
    /// Whether zero and less is impossible: the formula divides by it, or it is a factor.
    pub above_zero: bool,
    /// Whether it is a share of something: a fit stops at 1.
    pub share: bool,
    /// Whether it stands for what an emitter of single LEDs says itself: without meaning for such a one.
    pub without_leds: bool,
}

impl ParameterSpec {
    /// With another value at which it has no effect.
    pub(super) const fn null(self, null: f64) -> Self {
        Self { null, ..self }
    }

    pub(super) const fn without_leds(self) -> Self {
        let without_leds = true;
        Self { without_leds, ..self }
    }

    pub(super) const fn only_on(self, stage: Stage) -> Self {
        let only_on = Some(stage);
        Self { only_on, ..self }
    }

    pub(super) const fn of_other_heads(self) -> Self {
        let of_other_heads = true;
        Self {
            of_other_heads,
            ..self.only_on(Stage::Readings)
        }
    }

    pub(super) const fn alternative(self) -> Self {
        let role = Role::Alternative;
        Self { role, ..self }
    }

    /// Need not stand in a model file.
    pub(super) const fn optional(self, step: f64) -> Self {
        Self {
            required: false,
            step,
            ..self
        }
    }

    pub(super) const fn above_zero(self) -> Self {
        Self {
            above_zero: true,
            ..self
        }
    }

    pub(super) const fn share(self) -> Self {
        Self { share: true, ..self }
    }
}

/// One effect of the catalogue.
#[derive(Debug)]
pub struct EffectSpec {
    /// The id in model files.
    pub name: &'static str,
    /// The term of the standards.
    pub standard_name: &'static str,
    /// What it does, in one sentence for somebody who has never read of it: placeholders as in `sentence.rs`.
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
    /// Where the response does not grow with the amplitude (a level, a step): the values that are tried one by one, for
    /// a largest signal in full scales.
    pub tried: Option<fn(f64) -> Vec<f64>>,
    /// Its amplitude is a period along the signal, in full scales (a quantization step): candidates are found in the
    /// data.
    pub period_of_signal: bool,
    /// It changes the shape of the light over γ and nothing else: where that is refitted, there is nothing left of it.
    pub shape_over_gamma: bool,
    /// The coordinate along which it shows, in the words of `where`.
    pub shows_in: &'static str,
    /// What looks like it, each with the measurement block that separates the two, in the words of
    /// `next_measurement`.
    pub look_alikes: &'static [(&'static str, &'static str)],
    /// What it does to a prediction.
    pub acts: &'static [Act],
}

impl EffectSpec {
    /// What most effects have; the rest is for each to say.
    pub(super) const NEUTRAL: Self = Self {
        name: "",
        standard_name: "",
        sentence: "",
        belongs_to: &[],
        stages: &[],
        formula: "",
        source: "",
        parameters: &[],
        amplitude_power: 1,
        tried: None,
        period_of_signal: false,
        shape_over_gamma: false,
        shows_in: "",
        look_alikes: &[],
        acts: &[],
    };

    /// Index of a key.
    pub fn index_of(&self, key: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.key == key)
    }

    /// Whether it is one of these things' properties.
    pub fn belongs_to(&self, owner: BelongsTo) -> bool {
        self.belongs_to.contains(&owner)
    }

    /// Whether the key at `index` acts on this kind of observation.
    pub fn key_acts_on(&self, index: usize, stage: Stage) -> bool {
        self.stages.contains(&stage) && self.parameters[index].only_on.is_none_or(|only| only == stage)
    }

    /// The readings whose level it predicts: a reduction that takes the effect out of a run subtracts none.
    pub fn takes_over(&self) -> Option<ReadingKind> {
        self.acts.iter().find_map(|act| match act {
            Act::Zero(_) => Some(ReadingKind::Capped),
            Act::Ambient(_) => Some(ReadingKind::LampOff),
            Act::Floor(_) => Some(ReadingKind::Baffled),
            _ => None,
        })
    }

    /// What it makes of a signal in full scales, where it is nothing but the last step of a camera's reading.
    pub fn readout(&self, values: &[f64], signal: f64) -> Option<f64> {
        let [Act::Readout(law)] = self.acts else { return None };
        let mut all = [0.0; MOST_KEYS];
        all[..values.len()].copy_from_slice(values);
        Some(law(&all, signal))
    }

    /// Whether it stands for the emitter of a point or disc.
    pub fn replaces_emitter(&self) -> bool {
        self.acts.iter().any(|act| matches!(act, Act::Emitter(_)))
    }

    /// Whether it is the lux meter's own: no other instrument shows it.
    pub fn is_of_lux_meter(&self) -> bool {
        let own = |act: &Act| {
            matches!(
                act,
                Act::Detector(_) | Act::Aperture(_) | Act::Response { .. } | Act::Zero(_)
            )
        };
        self.acts.iter().any(own)
    }

    /// Whether it is a beat of the lamp over time.
    pub fn beats(&self) -> bool {
        let is_beat = |parameter: &ParameterSpec| parameter.role == Role::Period(Sampling::Time);
        self.parameters.iter().any(is_beat)
    }
}

pub(super) const READINGS: &[Stage] = &[Stage::Readings];
pub(super) const MAPS: &[Stage] = &[Stage::Maps];
pub(super) const SPECTRA: &[Stage] = &[Stage::Spectra];
pub(super) const READINGS_AND_MAPS: &[Stage] = &[Stage::Readings, Stage::Maps];
pub(super) const EVERYTHING: &[Stage] = &[Stage::Readings, Stage::Maps, Stage::Spectra];

/// An amplitude with null 0.
pub(super) const fn amplitude(
    key: &'static str,
    unit: &'static str,
    plausible: (f64, f64),
    step: f64,
) -> ParameterSpec {
    ParameterSpec {
        key,
        unit,
        null: 0.0,
        plausible,
        step,
        role: Role::Amplitude,
        only_on: None,
        of_other_heads: false,
        required: false,
        above_zero: false,
        share: false,
        without_leds: false,
    }
}

/// What stays at `null` unless the file says otherwise.
pub(super) const fn constant(key: &'static str, unit: &'static str, null: f64, plausible: (f64, f64)) -> ParameterSpec {
    let step = (plausible.1 - plausible.0) * 0.02;
    let role = Role::Constant;
    ParameterSpec {
        null,
        role,
        ..amplitude(key, unit, plausible, step)
    }
}

/// The time from which an amplitude counts.
pub(super) const fn origin(
    key: &'static str,
    unit: &'static str,
    plausible: (f64, f64),
    within: (f64, f64),
) -> ParameterSpec {
    let role = Role::Origin { within };
    ParameterSpec {
        role,
        ..constant(key, unit, 0.0, plausible)
    }
}

/// A direction in degrees that repeats after `period`.
pub(super) const fn azimuth(period: f64) -> ParameterSpec {
    let role = Role::Phase { period };
    ParameterSpec {
        role,
        ..amplitude("azimuth_deg", "°", (0.0, 360.0), 5.0)
    }
}

/// The phase of an oscillation.
pub(super) const fn phase() -> ParameterSpec {
    let role = Role::Phase { period: TAU };
    ParameterSpec {
        role,
        ..amplitude("phase_rad", "rad", (0.0, TAU), 0.1)
    }
}

/// A parameter of shape that a model file must give.
pub(super) const fn shape(
    key: &'static str,
    unit: &'static str,
    typical: f64,
    plausible: (f64, f64),
    grid: &'static [f64],
) -> ParameterSpec {
    let role = Role::Shape { grid };
    let required = true;
    ParameterSpec {
        role,
        required,
        ..constant(key, unit, typical, plausible)
    }
}

/// An azimuth of shape: no sum of two patterns at right angles makes those between.
pub(super) const fn azimuth_of(grid: &'static [f64]) -> ParameterSpec {
    let role = Role::Azimuth { grid };
    ParameterSpec {
        role,
        ..shape("azimuth_deg", "°", 0.0, (0.0, 360.0), grid)
    }
}

/// The period of an oscillation.
pub(super) const fn period(
    key: &'static str,
    unit: &'static str,
    typical: f64,
    plausible: (f64, f64),
    sampling: Sampling,
) -> ParameterSpec {
    let role = Role::Period(sampling);
    ParameterSpec {
        role,
        ..shape(key, unit, typical, plausible, &[])
    }
    .above_zero()
}

/// The number of the meter's range.
pub(super) const fn range() -> ParameterSpec {
    let role = Role::RangeId;
    ParameterSpec {
        role,
        ..shape("range", "", 0.0, (0.0, 10.0), &[])
    }
}
