//! One instrument on its link: asking it something, and what went wrong.

use std::time::Duration;

use isolux_device::DeviceError;
use isolux_protocol_ooi::{Answer, Host, InstrumentStatus, Request};
use isolux_transport::Bus;
use tokio::time::Instant;

/// A short answer.
const ANSWER: Duration = Duration::from_millis(500);

/// For a short request, all tries and the silence between them included.
const PATIENCE: Duration = Duration::from_secs(5);

/// The bus, with the words for what went wrong on it.
pub(crate) struct Line {
    bus: Bus<Host>,
    pub name: String,
}

impl Line {
    /// The instrument on `bus`.
    pub const fn new(bus: Bus<Host>, name: String) -> Self {
        Self { bus, name }
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

    /// A short request, again if the line damaged or lost the answer. The status proves in between that nothing older
    /// is on its way: the instrument answers in order, and the status looks like no other answer.
    pub async fn ask(&self, request: Request) -> Result<Answer, DeviceError> {
        let prove = (request != Request::Status).then_some(Request::Status);
        let requested = self
            .bus
            .ask_again(request, prove, ANSWER, Instant::now() + PATIENCE)
            .await;
        match requested {
            Ok(Some(answer)) => Ok(answer),
            Ok(None) => Err(self.fault("nobody answers this command", &[])),
            Err(error) => Err(error.during(&self.name, &format!("{request:?}"))),
        }
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
        DeviceError::fault(&self.name, "read the instrument", reason, evidence.to_vec())
    }
}
