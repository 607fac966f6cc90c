//! One controller on a bus: asking it something, and what went wrong.

use std::time::Duration;

use isolux_device::{DeviceError, Identity, Target};
use isolux_protocol_zaber::{CHECKSUMS_ON, Command, Host, Status, WarningFlag};
use isolux_transport::Bus;
use tokio::time::Instant;

/// Name of the driver in `open = "zaber:…"`.
pub(super) const NAME: &str = "zaber";

/// A reply takes a few milliseconds at 115200 baud, some 100 ms at 9600.
const ANSWER: Duration = Duration::from_millis(500);

/// Answers to one question within which two in a row must be the same.
const MOST_ANSWERS: usize = 6;

/// Until the line is free: another instrument on it may be drained first.
const LINE: Duration = Duration::from_secs(5);

/// What a device said: data, moving or not, the flag that came along, and the frame as evidence.
#[derive(Debug, Clone)]
pub(crate) struct Reported {
    pub data: String,
    pub busy: bool,
    pub flag: Option<WarningFlag>,
    pub frame: Vec<u8>,
}

/// A device on a bus.
#[derive(Clone)]
pub(crate) struct Controller {
    bus: Bus<Host>,
    device: u8,
    name: String,
    identity: Identity,
}

impl Controller {
    /// Turns checksums on and asks who is there.
    pub async fn open(bus: Bus<Host>, device: u8, target: &Target) -> Result<Self, DeviceError> {
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: String::new(),
            serial: None,
            firmware: None,
        };
        let mut controller = Self {
            bus,
            device,
            name: target.to_string(),
            identity,
        };
        controller.ask(0, CHECKSUMS_ON).await?;
        let id = controller.ask_twice(0, "get device.id").await?.data;
        controller.identity.model = format!("Zaber device id {id}");
        controller.identity.serial = Some(controller.ask_twice(0, "get system.serial").await?.data);
        controller.identity.firmware = Some(controller.ask_twice(0, "get version").await?.data);
        Ok(controller)
    }

    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Asks for what does not change, until two answers in a row are the same. Message ids repeat after a hundred
    /// requests, and the checksum is a sum: a reply that old, or one with two damaged bytes, can answer one request,
    /// but not two in a row.
    pub async fn ask_twice(&self, axis: u8, text: &str) -> Result<Reported, DeviceError> {
        self.ask_until(axis, text, |before, now| before.data == now.data).await
    }

    /// The same, for what may change a little.
    pub async fn ask_until(
        &self,
        axis: u8,
        text: &str,
        agree: impl Fn(&Reported, &Reported) -> bool + Send,
    ) -> Result<Reported, DeviceError> {
        let mut surplus = self.surplus();
        let mut before = self.ask(axis, text).await?;
        for _ in 1..MOST_ANSWERS {
            let now = self.ask(axis, text).await?;
            let in_step = std::mem::replace(&mut surplus, self.surplus()) == surplus;
            if in_step && agree(&before, &now) {
                return Ok(now);
            }
            tracing::warn!(
                text,
                before = before.data,
                now = now.data,
                in_step,
                "two answers disagree"
            );
            before = now;
        }
        let reason = format!("of {MOST_ANSWERS} answers no two in a row agree");
        Err(self.malformed(text, &reason, before.frame))
    }

    /// How many answers came that no request was waiting for: a change between two looks spoils what was read between
    /// them.
    pub fn surplus(&self) -> u64 {
        self.bus.unsolicited()
    }

    /// Asks for a number that does not change.
    pub async fn number<T: std::str::FromStr>(&self, axis: u8, text: &str) -> Result<(T, Reported), DeviceError> {
        let stated = self.ask_twice(axis, text).await?;
        self.parsed(text, stated)
    }

    /// The number in an answer.
    pub fn parsed<T: std::str::FromStr>(&self, text: &str, stated: Reported) -> Result<(T, Reported), DeviceError> {
        // Firmware 7 writes decimals where a setting has a fraction; a count never has one.
        match stated.data.parse() {
            Ok(number) => Ok((number, stated)),
            Err(_) => Err(self.malformed(
                text,
                &format!("\"{}\" is not the number asked for", stated.data),
                stated.frame,
            )),
        }
    }

    /// Asks `axis` (0: the device), again if the line damaged or lost the answer: every command used here may be
    /// repeated, it asks, sets a value, or moves to an absolute place.
    pub async fn ask(&self, axis: u8, text: &str) -> Result<Reported, DeviceError> {
        let action = if text.is_empty() { "status" } else { text };
        let command = Command::new(self.device, axis, text)
            .map_err(|error| DeviceError::unsupported(&self.name, action, error.to_string()))?;
        let reply = self.bus.ask_again(command, None, ANSWER, Instant::now() + LINE).await;
        let reply = reply.map_err(|error| error.during(&self.name, action))?;
        let frame = reply.encode();
        match reply.outcome {
            Ok(data) => Ok(Reported {
                data,
                busy: reply.status == Status::Busy,
                flag: reply.flag,
                frame,
            }),
            Err(rejection) => Err(DeviceError::refused(&self.name, action, rejection.reason, frame)),
        }
    }

    pub fn malformed(&self, action: &str, reason: &str, frame: Vec<u8>) -> DeviceError {
        DeviceError::malformed(&self.name, action, reason, frame)
    }

    pub fn fault(&self, action: &str, reason: impl Into<String>, evidence: Vec<u8>) -> DeviceError {
        DeviceError::fault(&self.name, action, reason, evidence)
    }
}
