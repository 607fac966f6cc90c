//! What differs from one lux meter to the next: its language, as what to ask and what an answer says.
//!
//! A driver is one implementation of [`Language`], without input or output of its own. [`Meter`](crate::meter::Meter)
//! sends, waits, asks again and confirms. A meter that is asked for a reading in the order of other bytes, or that is
//! put into service by more than settings, replaces [`Language::put_in_service`] or [`Language::put_in_step`].

use std::time::Duration;

use async_trait::async_trait;
use isolux_conversation::Conversation;
use isolux_device::{Caution, DeviceError, Identity, LuxRange, LuxReading, OpenError, Target};
use isolux_transport::{Bus, BusError, Exchanged, ExclusiveAccess, Place, TRIES};
use tokio::time::Instant;

/// Until the line is free: another device on it may be drained first.
const LINE_FREE: Duration = Duration::from_secs(5);

/// A request of a language.
pub(crate) type Request<L> = <<L as Language>::Conversation as Conversation>::Request;

/// An answer in a language.
pub(crate) type Answer<L> = <<L as Language>::Conversation as Conversation>::Answer;

/// A request, and what it is called in messages.
pub(crate) type Step<L> = (Request<L>, String);

/// A language of lux meters; `self` is one meter as its address and profile describe it.
#[async_trait]
pub(crate) trait Language: Send + Sync + Sized + 'static {
    /// Its bytes.
    type Conversation: Conversation<Request: Clone + PartialEq + Sync, Answer: Sync>;

    /// Name of the driver in `open = "name:…"`.
    const NAME: &'static str;

    /// The meter that `target` describes.
    ///
    /// # Errors
    /// [`OpenError`] names the option or the line of the profile.
    fn of(target: &Target) -> Result<Self, OpenError>;

    /// What it uses behind its link, and how the line is set.
    fn place(&self) -> Place;

    /// The conversation that the first meter on a port begins.
    fn conversation(&self, target: &Target) -> Self::Conversation;

    /// The model, as far as it is known before the meter says it.
    fn model(&self) -> String {
        String::new()
    }

    /// Full scale of each range and the last digit there, where it is known, in lx, rising; empty where no document
    /// says them.
    fn ranges_lx(&self) -> Vec<(f64, Option<f64>)> {
        Vec::new()
    }

    /// How it converts and answers.
    fn timing(&self) -> Timing;

    /// The least time from the moment at which a request is sent to the end of its answer, where it is known: what
    /// comes sooner answers an earlier request. A meter without one is not read in motion.
    fn soonest(&self) -> Option<Duration> {
        let timing = self.timing();
        (timing.converts == Converts::OnRequest).then_some(timing.integration)
    }

    /// What is asked when it is opened; no answer to it may look like a reading, but that to a first reading itself.
    fn opening(&self) -> Vec<Step<Self>> {
        Vec::new()
    }

    /// What chooses a range; nothing where the range is part of [`reading`](Self::reading).
    ///
    /// # Errors
    /// Which ranges it has, where it has not this one.
    fn choosing(&self, range: LuxRange) -> Result<Vec<Step<Self>>, String> {
        match range {
            LuxRange::Auto => Ok(Vec::new()),
            LuxRange::Fixed(_) => Err("a profile knows one range".to_owned()),
        }
    }

    /// What the answer to a step of [`opening`](Self::opening) or [`choosing`](Self::choosing) says of the meter.
    ///
    /// # Errors
    /// [`Failure`] where it was not taken.
    fn taken(&self, _: &Request<Self>, _: &Answer<Self>, _: &mut Identity) -> Result<(), Failure> {
        Ok(())
    }

    /// What is asked for one reading; the first request is the measurement.
    fn reading(&self, range: LuxRange) -> Vec<Step<Self>>;

    /// What the answers to [`reading`](Self::reading) say, as many as it has requests.
    ///
    /// # Errors
    /// [`Failure`] where they are no reading.
    fn stated(&self, range: LuxRange, answers: &[Answer<Self>]) -> Result<Said, Failure>;

    /// An answer as it came.
    fn bytes(answer: &Answer<Self>) -> &[u8];

    /// A request whose answer looks like no other: it proves that no reading is still on its way. Without one the
    /// silence after a failure is all there is.
    fn proof(&self) -> Option<Step<Self>> {
        None
    }

    /// Readings that differ by no more than this are the same to the meter, by its specification; digits aside.
    fn indistinct_lx(&self, _: &LuxReading) -> f64 {
        0.0
    }

    /// Puts the meter into service.
    async fn put_in_service(
        &mut self,
        link: &Link<Self::Conversation>,
        identity: &mut Identity,
    ) -> Result<(), DeviceError> {
        for step in self.opening() {
            link.settle(self, step, identity).await?;
        }
        Ok(())
    }

    /// Proves that no reading is still on its way; tried once.
    async fn put_in_step(&self, link: &Link<Self::Conversation>, deadline: Instant) -> Result<(), DeviceError> {
        let Some((request, action)) = self.proof() else {
            return Ok(());
        };
        let requested = link.bus.ask_within(request, self.timing().answer, deadline).await;
        requested.map(|_| ()).map_err(|error| error.during(&link.name, &action))
    }
}

/// How a meter converts and answers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Timing {
    /// A new value appears this often.
    pub update_interval: Duration,
    /// Each integrates the light of so long.
    pub integration: Duration,
    /// Which value a request gets.
    pub converts: Converts,
    /// The longest that an answer takes.
    pub answer: Duration,
}

/// When a meter converts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Converts {
    /// A request begins a measurement of its own.
    OnRequest,
    /// All the time; a request gets the latest value.
    Always,
    /// The same, and while the automatic range changes the old value may be repeated for one interval more.
    AlwaysAndRepeats,
}

impl Timing {
    /// The least time between two requests that get different values, the meter's clock aside.
    pub fn interval(&self) -> Duration {
        if self.converts == Converts::OnRequest {
            Duration::ZERO
        } else {
            self.update_interval
        }
    }

    /// Light of so long before a request may be in its answer.
    pub fn reach(&self, range: LuxRange) -> Duration {
        let latest = self.update_interval + self.integration;
        match self.converts {
            Converts::OnRequest => Duration::ZERO,
            Converts::AlwaysAndRepeats if range == LuxRange::Auto => latest + self.update_interval,
            Converts::Always | Converts::AlwaysAndRepeats => latest,
        }
    }
}

/// What the answers to one reading say.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Said {
    pub meaning: Meaning,
    /// One digit, lx.
    pub digit_lx: f64,
    /// The range in use, 1 is the most sensitive; 0 where the meter does not say.
    pub range: u8,
    pub caution: Option<Caution>,
}

/// What a number or a code stands for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Meaning {
    /// Illuminance in lx.
    Lux(f64),
    /// More light than the meter takes.
    OverRange,
    /// Less light than it resolves.
    UnderRange,
    /// The meter reports an error, in its own words or those of the profile.
    Error(String),
}

impl Meaning {
    /// The meaning of a number of lx, by the lowest and the highest that the meter gives.
    pub fn of(lux: f64, (low, high): (f64, f64)) -> Self {
        if lux > high {
            Self::OverRange
        } else if lux < low {
            Self::UnderRange
        } else {
            Self::Lux(lux)
        }
    }
}

/// Why an answer is not what was asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Failure {
    /// The answer is damaged, or one to something else: worth another try.
    Malformed(String),
    /// The meter does not take the setting.
    Refused(String),
    /// The meter says that it is at fault.
    Fault(String),
    /// As it is set up, the meter does not measure illuminance.
    NoLuxMeter(String),
}

impl Failure {
    /// An answer that no request of this kind gets.
    pub fn malformed(reason: impl ToString) -> Self {
        Self::Malformed(reason.to_string())
    }
}

/// A meter's port, and its name for messages.
pub(crate) struct Link<C: Conversation> {
    pub bus: Bus<C>,
    /// Driver and target.
    pub name: String,
}

impl<C: Conversation<Request: Clone + PartialEq + Sync, Answer: Sync>> Link<C> {
    /// A request whose answer cannot be taken for a reading; again, after the proof, where its answer is lost.
    ///
    /// # Errors
    /// [`DeviceError`] of the action.
    pub async fn settle<L: Language<Conversation = C>>(
        &self,
        language: &L,
        (request, action): Step<L>,
        identity: &mut Identity,
    ) -> Result<(), DeviceError> {
        let proof = language.proof().map(|(proof, _)| proof);
        let proof = proof.filter(|proof| *proof != request);
        let answer = language.timing().answer;
        let deadline = Instant::now() + LINE_FREE + TRIES * answer;
        let requested = self.bus.ask_again(request.clone(), proof, answer, deadline).await;
        let answer = requested.map_err(|error| error.during(&self.name, &action))?;
        let taken = language.taken(&request, &answer, identity);
        taken.map_err(|failure| self.failure(&action, failure, L::bytes(&answer).to_vec()))
    }

    /// A request on the line that is kept.
    ///
    /// # Errors
    /// [`DeviceError`] of the action.
    pub async fn ask(
        &self,
        line: &ExclusiveAccess<'_, C>,
        (request, action): (C::Request, &str),
        patience: Duration,
        deadline: Instant,
    ) -> Result<Exchanged<C::Answer>, DeviceError> {
        let exchanged = line.exchange(request, patience, deadline).await;
        exchanged.map_err(|error| error.during(&self.name, action))
    }

    /// A [`Failure`] as the error of an action.
    pub fn failure(&self, action: &str, failure: Failure, frame: Vec<u8>) -> DeviceError {
        let device = &self.name;
        match failure {
            Failure::Malformed(reason) => BusError::Malformed { reason, frame }.during(device, action),
            Failure::Refused(reason) => DeviceError::refused(device, action, reason, frame),
            Failure::Fault(reason) => DeviceError::fault(device, action, reason, frame),
            Failure::NoLuxMeter(reason) => DeviceError::unsupported(device, "measure illuminance", reason),
        }
    }
}
