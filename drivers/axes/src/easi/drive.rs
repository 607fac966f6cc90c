//! One drive on a line: asking it, and what it refused.

use std::time::Duration;

use isolux_device::{DeviceError, Identity, Target};
use isolux_protocol_ascii::{Lines, Number, Reply};
use isolux_protocol_easi::{Answer, Bits, Easi, Request, drive_fault, user_fault};
use isolux_transport::{Bus, BusError, TRIES};
use tokio::time::{Instant, sleep};

use crate::polled::fault;

/// Name of the driver in `open = "parker-easi:…"`.
pub(super) const NAME: &str = "parker-easi";

/// The longest exchange takes 0.1 s at 9600 baud.
const ANSWER: Duration = Duration::from_millis(500);

/// Until the line is free: another drive on it may be drained first.
const LINE: Duration = Duration::from_secs(5);

/// "Wait 1-2 seconds before sending any other command following a Z."
const RESET: Duration = Duration::from_secs(2);

/// Answers to one question within which two in a row must be the same.
const MOST_ANSWERS: usize = 6;

/// A drive.
pub(crate) struct Indexer {
    bus: Bus<Lines<Easi>>,
    address: u8,
    identity: Identity,
}

/// What was reported, and the bytes.
pub(crate) struct Reported {
    pub value: String,
    pub frame: Vec<u8>,
}

impl Indexer {
    /// Brings the line into the state that the codec expects, and asks who is there.
    pub async fn open(bus: Bus<Lines<Easi>>, address: u8, target: &Target) -> Result<Self, DeviceError> {
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: "Parker XLi".to_owned(),
            serial: None,
            firmware: None,
        };
        let mut indexer = Self { bus, address, identity };
        indexer.begin().await?;
        indexer.identity.firmware = Some(indexer.twice("R(RV)").await?.value);
        indexer.identity.serial = Some(indexer.twice("R(SN)").await?.value);
        Ok(indexer)
    }

    /// Echo on, speak when spoken to; reports are answered during moves too; targets are absolute.
    async fn begin(&self) -> Result<(), DeviceError> {
        // Whether it echoes is not known yet: nothing that comes now is listened to.
        let blind = Request::blind(self.address, "W(EX,2)");
        let sent = self.bus.ask_within(blind, ANSWER, Instant::now() + LINE).await;
        sent.map_err(|error| error.during(self.name(), "W(EX,2)"))?;
        sleep(ANSWER).await;
        self.expect("R(EX)", "2").await?;
        for (command, report, value) in [("W(CQ,0)", "R(CQ)", "0"), ("MA", "M", "MA")] {
            self.command(command).await?;
            self.expect(report, value).await?;
        }
        Ok(())
    }

    /// As after power-on; everything that was not saved is lost.
    pub async fn reset(&self) -> Result<(), DeviceError> {
        let blind = Request::blind(self.address, "Z");
        let sent = self.bus.ask_within(blind, ANSWER, Instant::now() + LINE).await;
        sent.map_err(|error| error.during(self.name(), "Z"))?;
        sleep(RESET).await;
        self.begin().await
    }

    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    pub fn name(&self) -> &str {
        &self.identity.target
    }

    pub fn unsolicited(&self) -> u64 {
        self.bus.unsolicited()
    }

    async fn ask(&self, request: Request, action: &str) -> Result<Reply<Answer>, DeviceError> {
        let proof = Request::report(self.address, "R(RV)");
        let requested = self
            .bus
            .ask_again(request, Some(proof), ANSWER, Instant::now() + LINE)
            .await;
        requested.map_err(|error| error.during(self.name(), action))
    }

    /// A report.
    pub async fn report(&self, report: &str) -> Result<Reported, DeviceError> {
        let reply = self.ask(Request::report(self.address, report), report).await?;
        Ok(Reported {
            value: reply.answer.value,
            frame: reply.bytes,
        })
    }

    /// A report of what does not change, until two answers in a row are the same.
    pub async fn twice(&self, report: &str) -> Result<Reported, DeviceError> {
        let mut unsolicited = self.unsolicited();
        let mut before = self.report(report).await?;
        for _ in 1..MOST_ANSWERS {
            let now = self.report(report).await?;
            let in_step = std::mem::replace(&mut unsolicited, self.unsolicited()) == unsolicited;
            if in_step && now.value == before.value {
                return Ok(now);
            }
            before = now;
        }
        let reason = format!("of {MOST_ANSWERS} answers no two in a row agree");
        Err(self.malformed(report, reason, before.frame))
    }

    async fn expect(&self, report: &str, value: &str) -> Result<(), DeviceError> {
        let stated = self.twice(report).await?;
        if stated.value == value {
            return Ok(());
        }
        let reason = format!("it reads back {} and not {value}", stated.value);
        Err(fault(self.name(), report, reason, stated.frame))
    }

    /// A report that `parse` reads. The language has no checksum: an answer that is none is asked for again.
    async fn parsed<T>(
        &self,
        report: &str,
        parse: impl Fn(&str) -> Result<T, String> + Send,
    ) -> Result<(T, Vec<u8>), DeviceError> {
        let mut tries = 1;
        loop {
            let stated = self.report(report).await?;
            match parse(&stated.value) {
                Ok(value) => return Ok((value, stated.frame)),
                Err(reason) if tries >= TRIES => return Err(self.malformed(report, reason, stated.frame)),
                Err(reason) => tracing::warn!(report, reason, tries, "asking again"),
            }
            tries += 1;
        }
    }

    /// A status word.
    pub async fn bits(&self, report: &str) -> Result<(Bits, Vec<u8>), DeviceError> {
        let parse = |value: &str| Bits::parse(value).map_err(|error| error.to_string());
        self.parsed(report, parse).await
    }

    /// The absolute position.
    pub async fn steps(&self) -> Result<(i32, Vec<u8>), DeviceError> {
        let parse = |value: &str| value.parse().map_err(|_| format!("\"{value}\" is no count"));
        self.parsed("R(PA)", parse).await
    }

    /// A command, whatever the drive says to it; the user faults since the last look, which this look clears.
    pub async fn say(&self, command: &str) -> Result<(Bits, Reply<Answer>), DeviceError> {
        let reply = self.ask(Request::command(self.address, command), command).await?;
        match Bits::parse(&reply.answer.value) {
            Ok(faults) => Ok((faults, reply)),
            Err(error) => Err(self.malformed(command, error.to_string(), reply.bytes)),
        }
    }

    /// A command that must be taken.
    pub async fn command(&self, command: &str) -> Result<(), DeviceError> {
        let (faults, reply) = self.say(command).await?;
        if faults.is_empty() && !reply.answer.refused {
            return Ok(());
        }
        Err(self.refused(command, faults, reply.bytes))
    }

    /// What the drive has against a command.
    pub fn refused(&self, command: &str, faults: Bits, frame: Vec<u8>) -> DeviceError {
        let words: Vec<_> = faults
            .numbers()
            .map(|number| format!("{} (UF {number})", user_fault(number)))
            .collect();
        DeviceError::Refused {
            device: self.name().to_owned(),
            action: command.to_owned(),
            reason: if words.is_empty() {
                "*E".to_owned()
            } else {
                words.join(", ")
            },
            frame,
        }
    }

    /// Sets `name` to `value`, and reads it back.
    pub async fn set(&self, name: &str, value: &str) -> Result<(), DeviceError> {
        self.command(&format!("{name}{value}")).await?;
        let stated = self.twice(name).await?;
        let same =
            Number::parse(&stated.value).map(|number| number.value) == Number::parse(value).map(|number| number.value);
        if same {
            return Ok(());
        }
        let reason = format!("it reads back {} and not {value}", stated.value);
        Err(fault(self.name(), &format!("{name}{value}"), reason, stated.frame))
    }

    /// What the drive has taken the current from the motor for, if for anything.
    pub async fn drive_faults(&self) -> Result<Option<String>, DeviceError> {
        let (faults, _) = self.bits("R(DF)").await?;
        let words: Vec<_> = faults
            .numbers()
            .map(|number| format!("{} (DF {number})", drive_fault(number)))
            .collect();
        Ok((!words.is_empty()).then(|| format!("the motor has no current: {}", words.join(", "))))
    }

    pub fn malformed(&self, action: &str, reason: String, frame: Vec<u8>) -> DeviceError {
        BusError::Malformed { reason, frame }.during(self.name(), action)
    }
}
