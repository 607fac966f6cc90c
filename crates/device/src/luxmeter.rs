//! A photometer head that gives illuminance.

use std::time::Duration;

use async_trait::async_trait;
use isolux_units::Lux;
use tokio::time::Instant;

use crate::{DeviceError, Identity};

/// A lux meter.
#[async_trait]
pub trait LuxMeter: Send + Sync {
    /// What the meter said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// Ranges and timing.
    fn properties(&self) -> &LuxMeterProperties;

    /// A *new* reading, of light that fell on the head after `not_before` alone: pass the moment at which the axes came
    /// to rest. Waits as long as that takes, and never returns the same conversion twice.
    ///
    /// # Errors
    /// [`Timeout`](DeviceError::Timeout) at `deadline`; [`Fault`](DeviceError::Fault) for a broken or unpowered head. A
    /// signal outside the range, or one that does not stay the same, is no error but another [`LuxOutcome`].
    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError>;

    /// The next conversion, at once and confirmed by nothing, for light that changes while it is read: what it belongs
    /// to is judged later from the instants of many.
    ///
    /// # Errors
    /// As [`read`](Self::read). After an error, and after bytes that nothing had asked for, the sample before it is in
    /// doubt too, and the next call first proves that the line is in step.
    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError>;

    /// Chooses a measuring range for the readings that follow.
    ///
    /// # Errors
    /// [`Unsupported`](DeviceError::Unsupported) for a range that the meter does not have.
    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError>;

    /// Takes what it reads now for its dark, in every range, and says in a sentence what it found; none where the meter
    /// needs no dark ([`LuxMeterProperties::needs_dark`]). No light may fall on it.
    ///
    /// # Errors
    /// As [`read`](Self::read); [`Fault`](DeviceError::Fault) where light falls on it.
    async fn take_dark(&self, deadline: Instant) -> Result<Option<String>, DeviceError>;
}

/// A measuring range as asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LuxRange {
    /// The meter chooses.
    Auto,
    /// Held at this range, in the meter's own numbering (1 is the most sensitive).
    Fixed(u8),
}

/// What is fixed about a meter.
#[derive(Debug, Clone, PartialEq)]
pub struct LuxMeterProperties {
    /// Upper end of each range, rising; index 0 is range 1.
    pub range_full_scale: Vec<Lux>,
    /// A new conversion appears this often.
    pub update_interval: Duration,
    /// Each conversion integrates the light of at most this long.
    pub integration: Duration,
    /// Of so long in each range, in the order of `range_full_scale`; empty where it is the same in all.
    pub range_integration: Vec<Duration>,
    /// What is known of the instants of its conversions.
    pub converts: Conversions,
    /// It gives no number before [`LuxMeter::take_dark`].
    pub needs_dark: bool,
}

impl LuxMeterProperties {
    /// How long a conversion in `range` integrates, in the meter's own numbering.
    pub fn integration_in(&self, range: u8) -> Duration {
        let place = usize::from(range).checked_sub(1);
        let own = place.and_then(|place| self.range_integration.get(place));
        own.copied().unwrap_or(self.integration)
    }
}

/// When a meter converts, and which conversion [`LuxMeter::sample`] gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conversions {
    /// A request begins a conversion of its own, so that the instant of its light is known.
    OnRequest,
    /// All the time, by a clock of its own; a request gets the last conversion at once, and the same one again until
    /// the next is complete. Its instants follow from many answers.
    ByOwnClock,
    /// All the time; which of them an answer gives is not known.
    Unknown,
}

/// What a reading says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LuxOutcome {
    /// A number; may be negative (noise around a dark offset).
    Measured(Lux),
    /// More light than the range takes. There is no number.
    OverRange,
    /// Less light than the range resolves, said by the meter. There is no number.
    UnderRange,
    /// No two exchanges in a row agreed: the light changes, or the link damages or delays answers. There is no number.
    Unsteady,
}

/// Something that does not spoil a reading but should be known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Caution {
    /// The meter reports a low battery.
    LowBattery,
}

/// One reading of a lux meter.
#[derive(Debug, Clone, PartialEq)]
pub struct LuxReading {
    /// The number, or why there is none.
    pub outcome: LuxOutcome,
    /// Range in which it was taken, in the meter's own numbering; 0 when the meter does not say.
    pub range: u8,
    /// The outcome of the exchange before it, of light after `not_before` too, with which it agrees. Given by a driver
    /// whose language cannot tie an answer to its request, so that one exchange alone proves nothing.
    pub confirmed_by: Option<LuxOutcome>,
    /// One digit of the answer: the full width of the rectangular distribution that rounding makes.
    pub digit: Lux,
    /// No light before this moment contributed.
    pub began: Instant,
    /// No light after this moment contributed.
    pub ended: Instant,
    /// Something to know about it.
    pub caution: Option<Caution>,
    /// Answers that were lost or damaged before this one, and asked for again.
    pub retries: u32,
    /// The answer as it came over the wire.
    pub evidence: Vec<u8>,
}

/// One conversion of a lux meter among many in a row.
#[derive(Debug, Clone, PartialEq)]
pub struct LuxSample {
    /// The number, or why there is none.
    pub outcome: LuxOutcome,
    /// Range in which it was taken, in the meter's own numbering; 0 when the meter does not say.
    pub range: u8,
    /// One digit of the answer.
    pub digit: Lux,
    /// When its request was on the line.
    pub requested: Instant,
    /// When its answer was complete.
    pub answered: Instant,
    /// The answer as it came over the wire.
    pub evidence: Vec<u8>,
}

impl LuxReading {
    /// The number, when there is one.
    pub const fn illuminance(&self) -> Option<Lux> {
        match self.outcome {
            LuxOutcome::Measured(lux) => Some(lux),
            LuxOutcome::OverRange | LuxOutcome::UnderRange | LuxOutcome::Unsteady => None,
        }
    }

    /// Middle of the interval whose light contributed.
    pub fn middle(&self) -> Instant {
        self.began + self.ended.saturating_duration_since(self.began) / 2
    }
}
