//! A lux meter of any [`Language`], and how the catalogue opens one.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome, LuxRange,
    LuxReading, LuxSample, OpenError, Target,
};
use isolux_transport::{ExclusiveAccess, Place, Ports};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::State;
use crate::language::{Converts, Failure, Language, Link, Meaning};

/// For [`Driver::place`](isolux_transport::Driver).
pub(crate) fn place<L: Language>(target: &Target, _: Kind) -> Result<Place, OpenError> {
    Ok(L::of(target)?.place())
}

/// For [`Driver::display_lx`](isolux_transport::Driver).
pub(crate) fn display_lx<L: Language>(target: &Target) -> Vec<(f64, f64)> {
    let ranges = L::of(target).map(|meter| meter.ranges_lx()).unwrap_or_default();
    let known = |(top_lx, digit_lx): (f64, Option<f64>)| Some((top_lx, digit_lx?));
    ranges.into_iter().filter_map(known).collect()
}

/// For [`Driver::factories`](isolux_transport::Driver).
pub(crate) fn factories<L: Language>(ports: Arc<Ports>) -> Factories {
    Factories {
        lux_meter: Some(Arc::new(Opener { ports, open: L::of })),
        ..Factories::default()
    }
}

struct Opener<L> {
    ports: Arc<Ports>,
    open: fn(&Target) -> Result<L, OpenError>,
}

#[async_trait]
impl<L: Language> LuxMeterFactory for Opener<L> {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let mut language = (self.open)(target)?;
        let begin = || language.conversation(target);
        let link = Link {
            bus: self.ports.bus(target, language.place().line, begin).await?,
            name: target.to_string(),
        };
        let mut identity = Identity {
            driver: L::NAME,
            target: target.to_string(),
            model: language.model(),
            serial: None,
            firmware: None,
        };
        language.put_in_service(&link, &mut identity).await?;
        let tops = language.ranges_lx().into_iter();
        let properties = LuxMeterProperties {
            range_full_scale: tops.filter_map(|(top_lx, _)| Lux::new(top_lx).ok()).collect(),
            update_interval: language.timing().update_interval,
            integration: language.timing().integration,
            on_request: language.timing().converts == Converts::OnRequest,
        };
        // What has arrived by now was part of putting the meter into service.
        let state = State::in_step(link.bus.unsolicited());
        Ok(Box::new(Meter {
            link,
            language,
            identity,
            properties,
            range: Mutex::new(LuxRange::Auto),
            state: tokio::sync::Mutex::new(state),
        }))
    }
}

/// Over and above the conversion itself: both ways on the line, and a USB chip that waits for more bytes.
const ANSWERS_WITHIN: Duration = Duration::from_millis(200);

/// A meter that has been put into service.
pub(crate) struct Meter<L: Language> {
    pub link: Link<L::Conversation>,
    pub language: L,
    identity: Identity,
    properties: LuxMeterProperties,
    /// As it was chosen.
    range: Mutex<LuxRange>,
    /// Kept by whoever reads or sets something.
    pub state: tokio::sync::Mutex<State>,
}

impl<L: Language> Meter<L> {
    fn range(&self) -> LuxRange {
        *self.range.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Light of so long before a request may be in its answer now.
    pub fn reach(&self) -> Duration {
        self.language.timing().reach(self.range())
    }

    /// The longest that the answer to a sample takes: in a fixed range, one conversion.
    pub fn patience(&self) -> Duration {
        let timing = self.language.timing();
        match (self.range(), timing.converts) {
            (LuxRange::Fixed(_), Converts::OnRequest) => (timing.integration + ANSWERS_WITHIN).min(timing.answer),
            _ => timing.answer,
        }
    }

    /// One reading asked for and answered within `patience`, confirmed by nothing.
    pub async fn exchange(
        &self,
        line: &ExclusiveAccess<'_, L::Conversation>,
        patience: Duration,
        deadline: Instant,
    ) -> Result<LuxReading, DeviceError> {
        let (range, timing) = (self.range(), self.language.timing());
        let (mut sent, mut ended) = (None, Instant::now());
        let (mut action, mut answers) = (String::new(), Vec::new());
        for (request, name) in self.language.reading(range) {
            let exchanged = self.link.ask(line, (request, &name), patience, deadline).await?;
            if sent.is_none() {
                (sent, ended, action) = (Some(exchanged.sent), Instant::now(), name);
            }
            answers.push(exchanged.answer);
        }
        let evidence: Vec<u8> = answers.iter().flat_map(L::bytes).copied().collect();
        let failed = |failure| self.link.failure(&action, failure, evidence.clone());
        let stated = self.language.stated(range, &answers).map_err(failed)?;
        let lux = |value| Lux::new(value).map_err(|error| failed(Failure::malformed(error)));
        let outcome = match stated.meaning {
            Meaning::Lux(value) => LuxOutcome::Measured(lux(value)?),
            Meaning::OverRange => LuxOutcome::OverRange,
            Meaning::UnderRange => LuxOutcome::UnderRange,
            Meaning::Error(reason) => return Err(failed(Failure::Fault(reason))),
        };
        Ok(LuxReading {
            outcome,
            range: stated.range,
            confirmed_by: None,
            digit: lux(stated.digit_lx)?,
            began: sent.unwrap_or(ended) - timing.reach(range),
            ended,
            caution: stated.caution,
            retries: 0,
            evidence,
        })
    }
}

#[async_trait]
impl<L: Language> LuxMeter for Meter<L> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        self.confirmed(not_before, deadline).await
    }

    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError> {
        self.state.lock().await.sample(self, deadline).await
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        // A reading under way ends in the range in which it began.
        let mut state = self.state.lock().await;
        let steps = self.language.choosing(range);
        let steps = steps.map_err(|reason| DeviceError::Unsupported {
            device: self.link.name.clone(),
            action: match range {
                LuxRange::Auto => "use the automatic range".to_owned(),
                LuxRange::Fixed(number) => format!("use range {number}"),
            },
            reason,
        })?;
        for step in steps {
            let mut same = self.identity.clone();
            self.link.settle(&self.language, step, &mut same).await?;
            state.forget();
        }
        *self.range.lock().unwrap_or_else(PoisonError::into_inner) = range;
        Ok(())
    }
}
