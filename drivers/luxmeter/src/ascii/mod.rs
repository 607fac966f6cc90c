//! Lux meters with a simple ASCII language, by a profile: `ascii-lux:LINK?profile=FILE.toml`.
//!
//! `profile` is the path of a TOML file, from the folder of the station file; `template` is one that shows every key
//! and is no real meter. `address` stands for `{address}` in the profile.
//!
//! The meter converts all the time, and a request gets the latest value: light of the update interval and the
//! integration before the request. One whose profile says `converts = "on_request"` begins a conversion with the
//! request, and can be read in motion. What an answer is believed for is said in `confirmed.rs`. A line in doubt is
//! put in step by the command of `[identity]`, whose reply must not read as a reading; without one the silence after a
//! failure is all there is.

mod profile;

use isolux_device::{Identity, Kind, LuxRange, OpenError, Target};
use isolux_profile::{Exchange, identity};
use isolux_protocol_ascii::{Lines, Message, Plain, Received, Reply};
use isolux_transport::{Driver, Place};

use crate::language::{Failure, Language, Meaning, Said, Step, Timing};
use crate::meter;
use profile::Profile;

/// Lux meters in plain ASCII.
pub const ASCII_LUX: Driver = Driver {
    name: AsciiLux::NAME,
    speaks_to: "lux meters in simple ASCII by a profile",
    examples: &[(Kind::LuxMeter, "ascii-lux:/dev/ttyUSB0?profile=template")],
    seen_with: "🧪 the virtual twin of the template",
    usb: &[],
    // Every language is another one: what could be asked stands in a profile.
    identify: &[],
    place: meter::place::<AsciiLux>,
    display_lx: meter::display_lx::<AsciiLux>,
    factories: meter::factories::<AsciiLux>,
};

struct AsciiLux {
    profile: Profile,
    /// What several meters on a line are told apart by.
    channel: String,
}

impl AsciiLux {
    /// A message whose answer must not be a reading's.
    fn setting(&self, exchange: &Exchange) -> Step<Self> {
        let profile = &self.profile;
        named(profile.manners.message(exchange, "", &profile.reading.replies))
    }

    /// A reading may be answered by no reading's form but its own.
    fn measurement(&self) -> Message {
        self.profile.manners.message(&self.profile.reading, "", &[])
    }

    fn meaning(&self, reply: &Reply<Received>) -> Option<(Meaning, f64)> {
        let Received { form, fields } = &reply.answer;
        self.profile.meaning(*form, fields.get("value"))
    }
}

fn named(message: Message) -> Step<AsciiLux> {
    let action = message.text.clone();
    (message, action)
}

impl Language for AsciiLux {
    type Conversation = Lines<Plain>;

    const NAME: &'static str = "ascii-lux";

    fn of(target: &Target) -> Result<Self, OpenError> {
        target.only(&["profile", "address"])?;
        let address = target.option("address");
        Ok(Self {
            profile: Profile::of(target)?,
            channel: address.map(|address| format!("meter {address}")).unwrap_or_default(),
        })
    }

    fn place(&self) -> Place {
        let (channel, line) = (self.channel.clone(), self.profile.line);
        Place { channel, line }
    }

    fn conversation(&self, _: &Target) -> Lines<Plain> {
        Lines::default()
    }

    fn model(&self) -> String {
        self.profile.model.clone()
    }

    fn ranges_lx(&self) -> Vec<(f64, Option<f64>)> {
        vec![(self.profile.range_lx.1, self.profile.resolution_lx)]
    }

    fn timing(&self) -> Timing {
        Timing {
            update_interval: self.profile.update_interval,
            integration: self.profile.integration,
            converts: self.profile.converts,
            answer: self.profile.manners.answer,
        }
    }

    /// A profile knows one range.
    fn choosing(&self, range: LuxRange) -> Result<Vec<Step<Self>>, String> {
        match range {
            LuxRange::Auto | LuxRange::Fixed(1) => Ok(Vec::new()),
            LuxRange::Fixed(_) => Err("a profile knows one range".to_owned()),
        }
    }

    /// Identity, settings, and a first reading of any light.
    fn opening(&self) -> Vec<Step<Self>> {
        let settings = self.profile.identity.iter().chain(&self.profile.setup);
        let settings = settings.map(|exchange| self.setting(exchange));
        settings.chain([named(self.measurement())]).collect()
    }

    fn taken(&self, requested: &Message, reply: &Reply<Received>, known: &mut Identity) -> Result<(), Failure> {
        if *requested == self.measurement() {
            return match self.meaning(reply) {
                Some((Meaning::Error(reason), _)) => Err(Failure::Fault(reason)),
                _ => Ok(()),
            };
        }
        let is_asked = |exchange: &&Exchange| self.setting(exchange).0 == *requested;
        let profile = &self.profile;
        let mut exchanges = profile.identity.iter().chain(&profile.setup);
        if let Some(exchange) = exchanges.find(is_asked)
            && let Some(meaning) = profile.manners.error(exchange, reply.answer.form)
        {
            return Err(Failure::Refused(meaning.to_owned()));
        }
        if profile.identity.as_ref().is_some_and(|exchange| is_asked(&exchange)) {
            let (model, serial, firmware) = identity(&reply.answer.fields);
            if !model.is_empty() {
                known.model = format!("{} ({model})", profile.model);
            }
            (known.serial, known.firmware) = (serial, firmware);
        }
        Ok(())
    }

    fn reading(&self, _: LuxRange) -> Vec<Step<Self>> {
        vec![named(self.measurement())]
    }

    fn stated(&self, _: LuxRange, answers: &[Reply<Received>]) -> Result<Said, Failure> {
        let stated = answers.first().and_then(|reply| self.meaning(reply));
        let (meaning, digit_lx) = stated.ok_or_else(|| Failure::malformed("no reading"))?;
        Ok(Said {
            meaning,
            digit_lx,
            range: 0,
            caution: None,
        })
    }

    fn bytes(reply: &Reply<Received>) -> &[u8] {
        &reply.bytes
    }

    fn proof(&self) -> Option<Step<Self>> {
        self.profile.identity.as_ref().map(|exchange| self.setting(exchange))
    }
}
