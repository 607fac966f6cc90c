//! Requests to an instrument, and what it says to them.

use std::time::Duration;

use isolux_device::DeviceError;
use isolux_protocol_obp::{Answer, Host, Request, Value};
use isolux_transport::{Bus, TRIES};
use tokio::time::Instant;

/// The longest answer, 4 kB at 9600 baud.
pub(super) const LONG_ANSWER: Duration = Duration::from_secs(6);

/// For a request, all tries and the silence between them included.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);

/// Most coefficients of a polynomial.
const MOST_COEFFICIENTS: u32 = 8;

/// The bus, with the words for what went wrong on it.
pub(super) struct Asker {
    pub bus: Bus<Host>,
    pub name: String,
}

impl Asker {
    pub async fn once(&self, request: Request, patience: Duration, deadline: Instant) -> Result<Answer, DeviceError> {
        let answer = self.bus.ask_within(request, patience, deadline).await;
        answer.map_err(|error| error.during(&self.name, &format!("{request:?}")))
    }

    /// What the instrument says to `request`; twice the same where no sum protects it.
    pub async fn ask(&self, request: Request) -> Result<Value, DeviceError> {
        let mut before: Option<Value> = None;
        for _ in 0..TRIES {
            let deadline = Instant::now() + PATIENCE;
            let prove = (request != Request::Serial).then_some(Request::Serial);
            let answer = self.bus.ask_again(request, prove, LONG_ANSWER, deadline).await;
            let answer = answer.map_err(|error| error.during(&self.name, &format!("{request:?}")))?;
            if answer.checked || before.as_ref() == Some(&answer.value) {
                return Ok(answer.value);
            }
            before = Some(answer.value);
        }
        Err(self.fault(&format!(
            "{request:?} has another answer each time, and none has a checksum"
        )))
    }

    /// A command that must be carried out.
    pub async fn command(&self, request: Request) -> Result<(), DeviceError> {
        match self.ask(request).await? {
            Value::Done => Ok(()),
            other => Err(self.refused(request, &other)),
        }
    }

    pub async fn number(&self, request: Request) -> Result<f64, DeviceError> {
        match self.ask(request).await? {
            Value::Number(number) if number.is_finite() => Ok(f64::from(number)),
            other => Err(self.refused(request, &other)),
        }
    }

    /// The coefficients of a polynomial, lowest power first; empty where the instrument has none.
    pub async fn coefficients(&self, count: Request, one: fn(u8) -> Request) -> Result<Vec<f64>, DeviceError> {
        let count = match self.ask(count).await? {
            Value::Count(number) if number <= MOST_COEFFICIENTS => number,
            Value::Refused { .. } => 0,
            other => return Err(self.refused(count, &other)),
        };
        let mut found = Vec::new();
        for place in 0..count {
            found.push(self.number(one(place as u8)).await?);
        }
        Ok(found)
    }

    pub fn refused(&self, request: Request, answer: &Value) -> DeviceError {
        let reason = match answer {
            Value::Refused { error, reason } => format!("error {error}: {reason}"),
            other => format!("{other:?} is no answer to it"),
        };
        DeviceError::refused(&self.name, format!("{request:?}"), reason, Vec::new())
    }

    pub fn fault(&self, reason: &str) -> DeviceError {
        DeviceError::malformed(&self.name, "read the instrument", reason, Vec::new())
    }
}
