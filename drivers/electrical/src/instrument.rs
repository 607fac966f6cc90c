//! One instrument in SCPI on a port: asking it, its identity, its error queue.

use std::time::Duration;

use isolux_device::{DeviceError, Identity, OpenError, Target};
use isolux_protocol_ascii::{Lines, Reply};
use isolux_protocol_scpi::{Answer, Expect, QueuedError, Request, Scpi};
use isolux_transport::{Bus, BusError, Exchanged, ExclusiveAccess, Ports};
use tokio::time::Instant;

use crate::profile::Manners;

/// The language on a port.
pub(crate) type Host = Lines<Scpi>;

/// How long a request waits for its turn and for a line that is drained.
const LINE: Duration = Duration::from_secs(10);

/// Answers to one question within which two in a row must be the same.
const MOST_ANSWERS: usize = 6;

/// Entries of an error queue that are read before it is given up: no instrument keeps more.
const MOST_ERRORS: usize = 64;

/// An instrument.
pub(crate) struct Instrument {
    bus: Bus<Host>,
    answer: Duration,
    errors: Option<String>,
    identity: Identity,
}

impl Instrument {
    /// Asks who is there, empties the error queue, and sends what the profile says.
    pub async fn open(
        ports: &Ports,
        target: &Target,
        driver: &'static str,
        manners: &Manners,
    ) -> Result<Self, OpenError> {
        let (terminator, quiet, longest) = (manners.terminator, 2 * manners.answer, manners.longest_block);
        let bus = ports
            .bus(target, manners.line, || {
                Lines::new(Scpi::new(terminator, quiet).with_blocks_up_to(longest))
            })
            .await?;
        let mut instrument = Self {
            bus,
            answer: manners.answer,
            errors: manners.errors.clone(),
            identity: Identity {
                driver,
                target: target.to_string(),
                model: String::new(),
                serial: None,
                firmware: None,
            },
        };
        instrument.identify(manners).await?;
        for command in &manners.setup {
            instrument.command(command).await?;
        }
        for (query, expected) in &manners.check {
            instrument.expect(query, expected).await?;
        }
        Ok(instrument)
    }

    /// `*IDN?`: maker, model, serial number, firmware. The model is looked for in all of it, since makers divide it
    /// differently.
    async fn identify(&mut self, manners: &Manners) -> Result<(), DeviceError> {
        const ACTION: &str = "*IDN?";
        let reply = self.twice(ACTION).await?;
        if !reply
            .to_ascii_uppercase()
            .contains(&manners.identity.to_ascii_uppercase())
        {
            return Err(DeviceError::unsupported(
                self.name(),
                "use this profile",
                format!("the instrument is \"{reply}\", the profile is for {}", manners.identity),
            ));
        }
        let fields: Vec<&str> = reply.split(',').map(str::trim).collect();
        self.identity.model = fields.iter().take(2).copied().collect::<Vec<_>>().join(" ");
        if let [_, _, serial, firmware, ..] = fields[..] {
            self.identity.serial = Some(serial.to_owned());
            self.identity.firmware = Some(firmware.to_owned());
        }
        // What an earlier program left there is nobody's failure now.
        self.queued().await.map(|_| ())
    }

    pub const fn identity(&self) -> &Identity {
        &self.identity
    }

    pub fn name(&self) -> &str {
        &self.identity.target
    }

    pub const fn bus(&self) -> &Bus<Host> {
        &self.bus
    }

    /// A query answered by a line. After a failure `*IDN?`, whose answer looks like no reading, must be answered first.
    pub async fn query(&self, message: &str) -> Result<(String, Vec<u8>), DeviceError> {
        let proof = Some(Request::query("*IDN?")).filter(|_| message != "*IDN?");
        let requested = self
            .bus
            .ask_again(Request::query(message), proof, self.answer, Instant::now() + LINE)
            .await;
        let reply = requested.map_err(|error| error.during(self.name(), message))?;
        self.text(message, reply)
    }

    /// A query answered by a block of `length` bytes that do not change, until two blocks in a row are the same.
    pub async fn block_twice(&self, message: &str, length: usize) -> Result<Vec<u8>, DeviceError> {
        let mut before = None;
        for _ in 0..MOST_ANSWERS {
            let request = Request {
                message: message.to_owned(),
                expect: Expect::Block,
            };
            let proof = Some(Request::query("*IDN?"));
            let deadline = Instant::now() + LINE + self.answer;
            let reply = self.bus.ask_again(request, proof, self.answer, deadline).await;
            let reply = reply.map_err(|error| error.during(self.name(), message))?;
            let Answer::Block(block) = reply.answer else {
                return Err(self.malformed(message, "no block", reply.bytes));
            };
            if block.len() == length && before.as_ref() == Some(&block) {
                return Ok(block);
            }
            before = Some(block);
        }
        let found = before.map_or(0, |block| block.len());
        let reason =
            format!("of {MOST_ANSWERS} blocks no two in a row are the same {length} bytes; the last has {found}");
        Err(self.malformed(message, &reason, Vec::new()))
    }

    /// One exchange on a line that is kept.
    pub async fn exchange(
        &self,
        line: &ExclusiveAccess<'_, Host>,
        request: Request,
        deadline: Instant,
    ) -> Result<Exchanged<Reply<Answer>>, DeviceError> {
        let action = request.message.clone();
        let exchanged = line.exchange(request, self.answer, deadline).await;
        exchanged.map_err(|error| error.during(self.name(), &action))
    }

    fn text(&self, message: &str, reply: Reply<Answer>) -> Result<(String, Vec<u8>), DeviceError> {
        match reply.answer {
            Answer::Text(text) => Ok((text, reply.bytes)),
            _ => Err(self.malformed(message, "no line of text", reply.bytes)),
        }
    }

    /// A query of what does not change, until two answers in a row are the same.
    pub async fn twice(&self, message: &str) -> Result<String, DeviceError> {
        let mut unsolicited = self.bus.unsolicited();
        let (mut before, mut bytes) = self.query(message).await?;
        for _ in 1..MOST_ANSWERS {
            let (now, next) = self.query(message).await?;
            let in_step = std::mem::replace(&mut unsolicited, self.bus.unsolicited()) == unsolicited;
            if in_step && now == before {
                return Ok(now);
            }
            (before, bytes) = (now, next);
        }
        let reason = format!("of {MOST_ANSWERS} answers no two in a row agree");
        Err(self.malformed(message, &reason, bytes))
    }

    async fn expect(&self, query: &str, expected: &str) -> Result<(), DeviceError> {
        let found = self.twice(query).await?;
        // A header may stand before the value, in its short or its long form.
        let value = found.rsplit(' ').next().unwrap_or(&found);
        if value.eq_ignore_ascii_case(expected) {
            return Ok(());
        }
        let reason = format!("it reads back \"{found}\" and not {expected}");
        Err(self.fault(query, reason, Vec::new()))
    }

    /// A message without a query, and what the error queue says of it.
    pub async fn command(&self, message: &str) -> Result<(), DeviceError> {
        let sent = self
            .bus
            .ask_within(Request::command(message), self.answer, Instant::now() + LINE)
            .await;
        sent.map_err(|error| error.during(self.name(), message))?;
        match self.queued().await?.first() {
            None => Ok(()),
            Some(error) => Err(DeviceError::refused(
                self.name(),
                message,
                format!("error {}, {}", error.code, error.text),
                Vec::new(),
            )),
        }
    }

    /// Empties the error queue.
    async fn queued(&self) -> Result<Vec<QueuedError>, DeviceError> {
        let Some(query) = &self.errors else {
            return Ok(Vec::new());
        };
        let mut queued = Vec::new();
        while queued.len() < MOST_ERRORS {
            let (answer, bytes) = self.query(query).await?;
            let error = QueuedError::parse(&answer);
            let error = error.map_err(|error| self.malformed(query, &error.to_string(), bytes))?;
            if error.code == 0 {
                return Ok(queued);
            }
            queued.push(error);
        }
        Err(self.fault(
            query,
            format!("the error queue does not empty: {:?}", queued.last()),
            Vec::new(),
        ))
    }

    pub fn malformed(&self, action: &str, reason: &str, frame: Vec<u8>) -> DeviceError {
        let reason = reason.to_owned();
        BusError::Malformed { reason, frame }.during(self.name(), action)
    }

    pub fn fault(&self, action: &str, reason: String, evidence: Vec<u8>) -> DeviceError {
        DeviceError::fault(self.name(), action, reason, evidence)
    }
}
