//! One drive that a profile describes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{AxisPosition, AxisSettings, Coordinate, DeviceError, Identity, Target};
use isolux_profile::{Exchange, counts, decimal, identity};
use isolux_protocol_ascii::{Form, Lines, Message, Plain, Received, Reply};
use isolux_transport::{Bus, BusError};
use tokio::time::Instant;

use super::profile::{Profile, Setting, State, Words};
use crate::polled::{AxisDriver, AxisStatus, fault, in_use};

/// Name of the driver in `open = "ascii-axis:…"`.
pub(super) const NAME: &str = "ascii-axis";

/// Until the line is free: another device on it may be drained first.
const LINE: Duration = Duration::from_secs(5);

/// Answers to one question within which two in a row must be the same.
const MOST_ANSWERS: usize = 6;

/// A drive.
pub(crate) struct Described<P> {
    bus: Bus<Lines<Plain>>,
    profile: Profile,
    identity: Identity,
    settings: AxisSettings<P>,
    /// The reference was found since the drive was opened: all there is to know of it where the profile has no
    /// [reference].
    homed: AtomicBool,
}

/// A field of a reply, and the bytes.
struct Word {
    text: String,
    frame: Vec<u8>,
}

impl<P: Coordinate> Described<P> {
    /// Asks who is there, and sets speed and acceleration where the profile says how. Moves nothing.
    pub async fn open(
        bus: Bus<Lines<Plain>>,
        target: &Target,
        profile: Profile,
        settings: AxisSettings<P>,
    ) -> Result<Self, DeviceError> {
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: profile.model.clone(),
            serial: None,
            firmware: None,
        };
        let mut drive = Self {
            bus,
            profile,
            identity,
            settings,
            homed: AtomicBool::new(false),
        };
        drive.introduce().await?;
        for exchange in drive.profile.setup.clone() {
            drive.command(&exchange, "").await?;
        }
        let steps_per_unit = settings.scale().steps_per_unit();
        let mut used = [settings.speed(), settings.acceleration()];
        let ways = [drive.profile.speed.clone(), drive.profile.acceleration.clone()];
        for (at, setting) in ways.into_iter().enumerate() {
            if let Some(setting) = setting {
                used[at] = drive.set(P::KEYS[2 + at], &setting, used[at], steps_per_unit).await?;
            }
        }
        drive.settings = in_use(drive.name(), &settings, used)?;
        Ok(drive)
    }

    async fn introduce(&mut self) -> Result<(), DeviceError> {
        if let Some(exchange) = self.profile.identity.clone() {
            let stated = self.ask(&exchange, "").await?;
            let (model, serial, firmware) = identity(&stated.answer.fields);
            if !model.is_empty() {
                self.identity.model = format!("{} ({model})", self.profile.model);
            }
            (self.identity.serial, self.identity.firmware) = (serial, firmware);
        }
        Ok(())
    }

    /// Sets a speed or an acceleration, in the axis' unit per s or s², and reads it back. Returns what is in use: down
    /// to a whole number of the drive's last digits, never more than the station allows.
    async fn set(&self, key: &str, setting: &Setting, wanted: f64, steps_per_unit: f64) -> Result<f64, DeviceError> {
        // Counts per s ÷ 10^decimals: the unit in which the drive states positions, per s.
        let unit = steps_per_unit / 10_f64.powi(self.profile.decimals.into());
        let digit = 10_f64.powi(setting.decimals.into());
        // The small part forgives the division.
        let count = (wanted * unit * digit + 1e-6).floor();
        let [least, most] = setting.range;
        if !(least - 1e-9..=most + 1e-9).contains(&(count / digit)) || count < 1.0 {
            let reason = format!("by its profile this drive can do {} to {}", least / unit, most / unit);
            return Err(self.unsupported(&format!("use {key} = {wanted}"), reason));
        }
        let text = decimal(count as i64, setting.decimals);
        self.command(&setting.set, &text).await?;
        let back = self.twice(&setting.query, "value").await?;
        let found = counts(&back.text, setting.decimals);
        if found != Some(count as i64) {
            let reason = format!("it reads back {} and not {text}", back.text);
            return Err(fault(self.name(), &setting.set.text(&text), reason, back.frame));
        }
        Ok(count / digit / unit)
    }

    fn name(&self) -> &str {
        &self.identity.target
    }

    fn unsupported(&self, action: &str, reason: String) -> DeviceError {
        DeviceError::unsupported(self.name(), action, reason)
    }

    fn malformed(&self, action: &str, reason: String, frame: Vec<u8>) -> DeviceError {
        BusError::Malformed { reason, frame }.during(self.name(), action)
    }

    /// The answer to the identity must have no form of an answer that is read.
    fn proof(&self) -> Option<Message> {
        let profile = &self.profile;
        let exchange = profile.identity.as_ref()?;
        let reference = profile.reference.as_ref().map(|words| &words.exchange);
        let read = [Some(&profile.position), Some(&profile.state.exchange), reference];
        let unlike: Vec<Form> = read
            .into_iter()
            .flatten()
            .flat_map(|other| other.replies.clone())
            .collect();
        Some(profile.manners.message(exchange, "", &unlike))
    }

    /// An exchange, four times in all where its reply is lost or damaged; an error that the profile knows is a refusal.
    async fn ask(&self, exchange: &Exchange, value: &str) -> Result<Reply<Received>, DeviceError> {
        let text = exchange.text(value);
        let proof = self.proof().filter(|proof| proof.text != text);
        let message = self.profile.manners.message(exchange, value, &[]);
        let patience = self.profile.manners.answer;
        let deadline = Instant::now() + LINE + 8 * patience;
        let requested = self.bus.ask_again(message, proof, patience, deadline).await;
        let stated = requested.map_err(|error| error.during(self.name(), &text))?;
        match self.profile.manners.error(exchange, stated.answer.form) {
            None => Ok(stated),
            Some(meaning) => Err(DeviceError::refused(self.name(), text, meaning, stated.bytes)),
        }
    }

    async fn command(&self, exchange: &Exchange, value: &str) -> Result<(), DeviceError> {
        self.ask(exchange, value).await.map(|_| ())
    }

    async fn read(&self, exchange: &Exchange, field: &str) -> Result<Word, DeviceError> {
        let stated = self.ask(exchange, "").await?;
        let text = stated.answer.fields.get(field).map(|text| text.trim().to_owned());
        Ok(Word {
            text: text.unwrap_or_default(),
            frame: stated.bytes,
        })
    }

    /// What does not change, until two answers in a row are the same.
    async fn twice(&self, exchange: &Exchange, field: &str) -> Result<Word, DeviceError> {
        let mut unsolicited = self.bus.unsolicited();
        let mut before = self.read(exchange, field).await?;
        for _ in 1..MOST_ANSWERS {
            let now = self.read(exchange, field).await?;
            let in_step = std::mem::replace(&mut unsolicited, self.bus.unsolicited()) == unsolicited;
            if in_step && now.text == before.text {
                return Ok(now);
            }
            before = now;
        }
        let reason = format!("of {MOST_ANSWERS} answers no two in a row agree");
        Err(self.malformed(&exchange.text(""), reason, before.frame))
    }

    async fn steps(&self) -> Result<(i64, Vec<u8>), DeviceError> {
        let exchange = &self.profile.position;
        let stated = self.read(exchange, "position").await?;
        let digits = self.profile.decimals;
        if let Some(steps) = counts(&stated.text, digits) {
            return Ok((steps, stated.frame));
        }
        let reason = format!(
            "\"{}\" is no position with {digits} digits after the point",
            stated.text
        );
        Err(self.malformed(&exchange.text(""), reason, stated.frame))
    }

    /// A question that is answered by one of a few words.
    async fn word<M: Clone>(&self, words: &Words<M>) -> Result<(M, Vec<u8>), DeviceError> {
        let stated = self.ask(&words.exchange, "").await?;
        match words.meaning(stated.answer.form) {
            Some(meaning) => Ok((meaning, stated.bytes)),
            // Forms beyond the words are errors, which `ask` has refused.
            None => Err(self.malformed(&words.exchange.text(""), "none of its words".to_owned(), stated.bytes)),
        }
    }

    async fn state(&self) -> Result<(State, Vec<u8>), DeviceError> {
        self.word(&self.profile.state).await
    }

    /// Whether the drive has a reference, and the bytes that say so.
    async fn homed(&self) -> Result<(bool, Vec<u8>), DeviceError> {
        match &self.profile.reference {
            Some(words) => self.word(words).await,
            None => Ok((self.homed.load(Ordering::Relaxed), Vec::new())),
        }
    }
}

#[async_trait]
impl<P: Coordinate> AxisDriver<P> for Described<P> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    fn tolerance_steps(&self) -> u64 {
        self.profile.tolerance_steps
    }

    /// State first, then position: an axis that had come to rest is where the second answer says.
    async fn status(&self) -> Result<AxisStatus<P>, DeviceError> {
        let before = self.bus.unsolicited();
        let (state, mut frame) = self.state().await?;
        let (steps, position) = self.steps().await?;
        let at = Instant::now();
        let (homed, reference) = self.homed().await?;
        frame.extend([position, reference].concat());
        let position = AxisPosition {
            place: self.settings.scale().place(steps),
            steps,
            moving: state == State::Moving,
            homed,
            at,
        };
        Ok(AxisStatus {
            fault: match state {
                State::Fault(meaning) => Some(meaning),
                State::Moving | State::Resting => None,
            },
            ..AxisStatus::new((before, self.bus.unsolicited()), position, frame)
        })
    }

    async fn go(&self, steps: i32) -> Result<(), DeviceError> {
        let target = decimal(steps.into(), self.profile.decimals);
        let (state, frame) = self.state().await?;
        if state == State::Moving {
            let reason = "it is still moving, and gets no other target until it rests";
            return Err(fault(self.name(), &self.profile.go.text(&target), reason, frame));
        }
        self.command(&self.profile.go, &target).await
    }

    async fn go_home(&self) -> Result<(), DeviceError> {
        // Until it has been found again there is no reference.
        self.homed.store(false, Ordering::Relaxed);
        self.command(&self.profile.home, "").await
    }

    async fn at_home(&self, _: i64, _: bool) -> Result<(), DeviceError> {
        let (steps, frame) = self.steps().await?;
        let home = self.profile.home_steps;
        if steps.abs_diff(home) > self.profile.tolerance_steps {
            let reason = format!("it came to rest at {steps}; the reference is {home}");
            return Err(fault(self.name(), "home", reason, frame));
        }
        self.homed.store(true, Ordering::Relaxed);
        Ok(())
    }

    async fn brake(&self) -> Result<(), DeviceError> {
        self.command(&self.profile.stop, "").await
    }

    async fn cut(&self) -> Result<(), DeviceError> {
        let kill = self.profile.kill.as_ref().unwrap_or(&self.profile.stop);
        self.command(kill, "").await
    }
}
