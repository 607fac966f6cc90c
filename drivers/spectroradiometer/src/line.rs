//! One instrument on its link: asking it something, and what went wrong.

use std::time::Duration;

use isolux_device::{DeviceError, ErrorKind};
use isolux_protocol_ooi::{Answer, Conversation, Event, InstrumentStatus, Request};
use isolux_transport::{Bus, Link, Outcome};
use tokio::time::Instant;

/// A short answer.
const ANSWER: Duration = Duration::from_millis(500);

/// Tries at one request before its error is told.
pub(crate) const TRIES: usize = 3;

/// The bus, with the words for what went wrong on it.
pub(crate) struct Line {
    bus: Bus<Talk>,
    pub name: String,
}

impl Line {
    /// Gives `link` to a task of its own.
    pub fn new(link: Box<dyn Link>, name: String) -> Self {
        Self {
            bus: Bus::spawn(link, Talk::default()),
            name,
        }
    }

    /// How often bytes have arrived that nothing had asked for.
    pub fn unsolicited(&self) -> u64 {
        self.bus.unsolicited()
    }

    /// Sends what nobody answers.
    pub async fn send(&self, request: Request) -> Result<(), DeviceError> {
        let deadline = Instant::now() + 4 * ANSWER;
        match self.bus.ask(request, deadline).await {
            Ok(_) => Ok(()),
            Err(error) => Err(error.during(&self.name, &format!("{request:?}"))),
        }
    }

    pub async fn ask_within(
        &self,
        request: Request,
        action: &str,
        patience: Duration,
        deadline: Instant,
    ) -> Result<Answer, DeviceError> {
        match self.bus.ask_within(request, patience, deadline).await {
            Ok(Some(answer)) => Ok(answer),
            Ok(None) => Err(self.fault("nobody answers this command", &[])),
            Err(error) => Err(error.during(&self.name, action)),
        }
    }

    /// A short request, again if the line damaged or lost the answer.
    pub async fn ask(&self, request: Request) -> Result<Answer, DeviceError> {
        let mut tries = 1;
        loop {
            let deadline = Instant::now() + 4 * ANSWER;
            match self
                .ask_within(request, &format!("{request:?}"), ANSWER, deadline)
                .await
            {
                Err(error) if tries < TRIES && matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Malformed) => {
                    tracing::warn!(%error, tries, "asking again");
                    tries += 1;
                    if request != Request::Status {
                        self.synchronise().await?;
                    }
                }
                result => return result,
            }
        }
    }

    /// Proves that nothing older is on its way: the instrument answers in order, and the status looks like no other answer.
    pub async fn synchronise(&self) -> Result<(), DeviceError> {
        Box::pin(self.status()).await.map(|_| ())
    }

    pub async fn status(&self) -> Result<InstrumentStatus, DeviceError> {
        match self.ask(Request::Status).await? {
            Answer::Status(status) => Ok(status),
            _ => Err(self.fault("another answer than the status", &[])),
        }
    }

    /// The status, asked for once.
    pub async fn status_once(&self) -> Result<InstrumentStatus, DeviceError> {
        let deadline = Instant::now() + 4 * ANSWER;
        match self.ask_within(Request::Status, "Status", ANSWER, deadline).await? {
            Answer::Status(status) => Ok(status),
            _ => Err(self.fault("another answer than the status", &[])),
        }
    }

    /// The status, the same in two answers: a bit that flipped on the way changes one of them.
    pub async fn status_twice(&self) -> Result<InstrumentStatus, DeviceError> {
        let same = |a: &InstrumentStatus, b: &InstrumentStatus| {
            (a.pixels, a.integration_us, a.trigger) == (b.pixels, b.integration_us, b.trigger)
        };
        let (first, second) = (self.status().await?, self.status().await?);
        if same(&first, &second) {
            return Ok(second);
        }
        let third = self.status().await?;
        if same(&first, &third) || same(&second, &third) {
            return Ok(third);
        }
        Err(self.fault(
            &format!("its status was read three times with three answers: {first:?}, {second:?}, {third:?}"),
            &[],
        ))
    }

    pub fn fault(&self, reason: &str, evidence: &[u8]) -> DeviceError {
        let (device, action) = (self.name.clone(), "read the instrument".to_owned());
        DeviceError::Fault {
            device,
            action,
            reason: reason.to_owned(),
            evidence: evidence.to_vec(),
        }
    }
}

/// The codec as the owner of a bus.
#[derive(Default)]
struct Talk(Conversation);

impl isolux_transport::Conversation for Talk {
    type Request = Request;
    /// `None`: sent, and nobody answers.
    type Answer = Option<Answer>;

    fn ready_at(&self, now: Instant) -> Instant {
        Instant::from_std(self.0.ready_at(now.into_std()))
    }

    fn start(&mut self, _: Instant, request: Request) -> (Vec<u8>, Option<Self::Answer>) {
        let (frame, answered) = self.0.start(request);
        (frame, if answered { None } else { Some(None) })
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Option<Outcome<Self::Answer>> {
        Some(match self.0.handle_input(now.into_std(), bytes)? {
            Event::Answer(answer) => Outcome::Answer(Some(answer)),
            Event::Damaged { reason, frame } => Outcome::Malformed { reason, frame },
        })
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.0.abandon(now.into_std())
    }
}
