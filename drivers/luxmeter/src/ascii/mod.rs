//! Lux meters with a simple ASCII language, by a profile: `ascii-lux:LINK?profile=FILE.toml`.
//!
//! `profile` is the path of a TOML file, from the folder of the station file; `template` is one that shows every key
//! and is no real meter. `address` stands for `{address}` in the profile.
//!
//! The meter converts all the time, and a request gets the latest value: light of the update interval and the
//! integration before the request. What an answer is believed for is said in `confirmed.rs`. A line in doubt is put in
//! step by the command of `[identity]`, whose reply must not read as a reading; without one the silence after a failure
//! is all there is.

mod profile;

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome, LuxRange,
    LuxReading, OpenError, Target,
};
use isolux_profile::{Exchange, identity};
use isolux_protocol_ascii::{Lines, Message, Plain, Received, Reply};
use isolux_transport::{Alone, Bus, Driver, Place, Ports};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::{Confirmed, Meter, Pace, one_range};
use profile::{Meaning, Profile};

const NAME: &str = "ascii-lux";

/// The true answer to a request that an old one seemed to answer has come within this.
const GUARD: Duration = Duration::from_millis(100);

/// Until the line is free: another device on it may be drained first.
const LINE: Duration = Duration::from_secs(5);

/// Lux meters in plain ASCII.
pub const ASCII_LUX: Driver = Driver {
    name: NAME,
    speaks_to: "lux meters in simple ASCII by a profile",
    examples: &[(Kind::LuxMeter, "ascii-lux:/dev/ttyUSB0?profile=template")],
    seen_with: "🧪 the virtual twin of the template",
    usb: &[],
    // Every language is another one: what could be asked stands in a profile.
    identify: &[],
    place: |target, _| {
        let line = profile(target)?.line;
        let address = target.option("address");
        let channel = address.map(|address| format!("meter {address}")).unwrap_or_default();
        Ok(Place { channel, line })
    },
    display_lx: |target| {
        let known = profile(target).ok();
        let display = known.and_then(|profile| Some((profile.range_lx.1, profile.resolution_lx?)));
        display.into_iter().collect()
    },
    factories: |ports| Factories {
        lux_meter: Some(Arc::new(AsciiLuxDriver { ports })),
        ..Factories::default()
    },
};

fn profile(target: &Target) -> Result<Profile, OpenError> {
    target.only(&["profile", "address"])?;
    Profile::of(target)
}

struct AsciiLuxDriver {
    ports: Arc<Ports>,
}

#[async_trait]
impl LuxMeterFactory for AsciiLuxDriver {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let profile = profile(target)?;
        let bus = self.ports.bus(target, profile.line, Lines::<Plain>::default).await?;
        let mut meter = AsciiLux {
            bus,
            name: target.to_string(),
            identity: Identity {
                driver: NAME,
                target: target.to_string(),
                model: profile.model.clone(),
                serial: None,
                firmware: None,
            },
            properties: LuxMeterProperties {
                range_full_scale: Lux::new(profile.range_lx.1).into_iter().collect(),
                update_interval: profile.update_interval,
                integration: profile.integration,
            },
            profile,
            confirmed: Confirmed::default(),
        };
        meter.begin().await?;
        Ok(Box::new(meter))
    }
}

struct AsciiLux {
    bus: Bus<Lines<Plain>>,
    name: String,
    identity: Identity,
    properties: LuxMeterProperties,
    profile: Profile,
    confirmed: Confirmed,
}

impl AsciiLux {
    /// Identity, settings, and a first reading of any light.
    async fn begin(&mut self) -> Result<(), DeviceError> {
        if let Some(exchange) = self.profile.identity.clone() {
            let said = self.setting(&exchange).await?;
            let (model, serial, firmware) = identity(&said.answer.fields);
            if !model.is_empty() {
                self.identity.model = format!("{} ({model})", self.profile.model);
            }
            (self.identity.serial, self.identity.firmware) = (serial, firmware);
        }
        for exchange in self.profile.setup.clone() {
            self.setting(&exchange).await?;
        }
        let reading = self.reading();
        let action = reading.text.clone();
        let asked = self.ask_again(reading, &action).await?;
        if let Some(Meaning::Error(reason)) = self.meaning(&asked) {
            return Err(self.fault(&action, reason, asked.bytes));
        }
        self.confirmed.in_service(self).await;
        Ok(())
    }

    /// A reading may be answered by no reading's form but its own.
    fn reading(&self) -> Message {
        let profile = &self.profile;
        profile.manners.message(&profile.reading, "", &[])
    }

    /// Any other message: its answer must not be a reading's.
    fn message(&self, exchange: &Exchange) -> Message {
        let profile = &self.profile;
        profile.manners.message(exchange, "", &profile.reading.replies)
    }

    fn proof(&self) -> Option<Message> {
        self.profile.identity.as_ref().map(|exchange| self.message(exchange))
    }

    fn meaning(&self, said: &Reply<Received>) -> Option<Meaning> {
        self.profile.meaning(said.answer.form, said.answer.fields.get("value"))
    }

    async fn ask_again(&self, message: Message, action: &str) -> Result<Reply<Received>, DeviceError> {
        let proof = self.proof().filter(|proof| *proof != message);
        let patience = self.profile.manners.answer;
        let asked = self
            .bus
            .ask_again(message, proof, patience, Instant::now() + LINE + 4 * patience);
        asked.await.map_err(|error| error.during(&self.name, action))
    }

    /// A message whose answer cannot be a reading.
    async fn setting(&self, exchange: &Exchange) -> Result<Reply<Received>, DeviceError> {
        let message = self.message(exchange);
        let action = message.text.clone();
        let said = self.ask_again(message, &action).await?;
        match self.profile.manners.error(exchange, said.answer.form) {
            None => Ok(said),
            Some(meaning) => Err(DeviceError::Refused {
                device: self.name.clone(),
                action,
                reason: meaning.to_owned(),
                frame: said.bytes,
            }),
        }
    }
}

#[async_trait]
impl Meter for AsciiLux {
    type Language = Lines<Plain>;

    fn bus(&self) -> &Bus<Lines<Plain>> {
        &self.bus
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn pace(&self) -> Pace {
        Pace {
            interval: self.profile.update_interval,
            reach: self.profile.update_interval + self.profile.integration,
            patience: self.profile.manners.answer,
            guard: GUARD,
        }
    }

    async fn exchange(&self, line: &Alone<'_, Lines<Plain>>, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let message = self.reading();
        let action = message.text.clone();
        let exchanged = self.ask(line, message, &action, deadline).await?;
        let ended = Instant::now();
        let evidence = exchanged.answer.bytes.clone();
        let malformed = |reason: &str| self.malformed(&action, reason, evidence.clone());
        let mut digit_lx = self.profile.resolution_lx.unwrap_or(1.0);
        let outcome = match self.meaning(&exchanged.answer) {
            Some(Meaning::Lux(lux, step)) => {
                digit_lx = step;
                LuxOutcome::Measured(Lux::new(lux).map_err(|error| malformed(&error.to_string()))?)
            }
            Some(Meaning::OverRange) => LuxOutcome::OverRange,
            Some(Meaning::UnderRange) => LuxOutcome::UnderRange,
            Some(Meaning::Error(reason)) => return Err(self.fault(&action, reason, evidence)),
            None => return Err(malformed("no reading")),
        };
        Ok(LuxReading {
            outcome,
            range: 0,
            confirmed_by: None,
            digit: Lux::new(digit_lx).map_err(|error| malformed(&error.to_string()))?,
            began: exchanged.sent - self.pace().reach,
            ended,
            caution: None,
            retries: 0,
            evidence,
        })
    }

    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError> {
        let Some(proof) = self.proof() else { return Ok(()) };
        let action = proof.text.clone();
        let asked = self.bus.ask_within(proof, self.profile.manners.answer, deadline).await;
        asked.map(|_| ()).map_err(|error| error.during(&self.name, &action))
    }
}

#[async_trait]
impl LuxMeter for AsciiLux {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        self.confirmed.read(self, not_before, deadline).await
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        one_range(&self.name, range)
    }
}
