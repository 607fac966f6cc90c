//! A driver of one's own: a lux meter that answers `LX?` with a line such as `123.4`.
//!
//!     cargo run -p isolux-examples --example driver
//!
//! Three parts: the language (which bytes ask, which answer), the device (what an answer means), and the link, here a
//! pipe to a scripted meter. `docs/architecture.md`, "Adding an instrument", says how a driver gets into the program.

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    Conversions, DeviceError, Identity, LuxMeter, LuxMeterProperties, LuxOutcome, LuxRange, LuxReading, LuxSample,
    OpenError, Target,
};
use isolux_protocol_ascii::{Judgement, Language, Line, Lines, Number, line};
use isolux_transport::{Bus, BusError, LineSettings, MemoryLinks, Parity, Ports};
use isolux_units::Lux;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep_until};

/// The language. There is one request.
struct Lumeter;

impl Language for Lumeter {
    type Request = ();
    type Answer = Number;

    /// The slowest answer begins after 0.2 s.
    fn quiet(&self) -> Duration {
        Duration::from_millis(500)
    }

    fn start(&mut self, (): ()) -> (Vec<u8>, Option<Number>) {
        (b"LX?\n".to_vec(), None)
    }

    fn judge(&self, received: &[u8]) -> Judgement<Number> {
        match line(received) {
            Line::More => Judgement::More,
            Line::Damaged(reason) => Judgement::Damaged(reason),
            Line::Whole(text) => match Number::parse(text) {
                Some(number) => Judgement::Answer(number),
                None => Judgement::Damaged(format!("\"{text}\" is no number")),
            },
        }
    }
}

/// The device: it measures from each request on, for as long as it takes to answer.
struct Meter {
    bus: Bus<Lines<Lumeter>>,
    identity: Identity,
    properties: LuxMeterProperties,
}

impl Meter {
    async fn open(target: &Target, ports: &Ports) -> Result<Self, OpenError> {
        let settings = LineSettings {
            baud: 9600,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        };
        Ok(Self {
            bus: ports.bus(target, settings, || Lines::new(Lumeter)).await?,
            identity: Identity {
                driver: "lumeter",
                target: target.to_string(),
                model: "Lumeter".to_owned(),
                serial: None,
                firmware: None,
            },
            properties: LuxMeterProperties {
                range_full_scale: Vec::new(),
                update_interval: Duration::from_millis(200),
                integration: Duration::from_millis(200),
                range_integration: Vec::new(),
                needs_dark: false,
                converts: Conversions::OnRequest,
            },
        })
    }
}

#[async_trait]
impl LuxMeter for Meter {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        sleep_until(not_before).await;
        let failed = |error: BusError| error.during(&self.identity.target, "read illuminance");
        let line = self.bus.exclusive(deadline).await.map_err(failed)?;
        let patience = Duration::from_secs(1);
        let exchanged = line.exchange((), patience, deadline).await.map_err(failed)?;
        let lux = |value| {
            let frame = exchanged.answer.bytes.clone();
            Lux::new(value).map_err(|error| {
                failed(BusError::Malformed {
                    reason: error.to_string(),
                    frame,
                })
            })
        };
        Ok(LuxReading {
            outcome: LuxOutcome::Measured(lux(exchanged.answer.answer.value)?),
            range: 0,
            confirmed_by: None,
            digit: lux(exchanged.answer.answer.step)?,
            began: exchanged.sent,
            ended: Instant::now(),
            caution: None,
            retries: 0,
            evidence: exchanged.answer.bytes,
        })
    }

    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError> {
        let reading = self.read(Instant::now(), deadline).await?;
        Ok(LuxSample {
            outcome: reading.outcome,
            range: reading.range,
            digit: reading.digit,
            requested: reading.began,
            answered: reading.ended,
            evidence: reading.evidence,
        })
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        match range {
            LuxRange::Auto => Ok(()),
            LuxRange::Fixed(number) => Err(DeviceError::Unsupported {
                device: self.identity.target.clone(),
                action: format!("use range {number}"),
                reason: "the meter has one range".to_owned(),
            }),
        }
    }

    async fn take_dark(&self, _: Instant) -> Result<Option<String>, DeviceError> {
        Ok(None)
    }
}

/// A reading of the meter that answers each request with the next of `answers`.
async fn reading(answers: &'static [&'static str]) -> Result<LuxReading, Box<dyn Error>> {
    let links = MemoryLinks::default();
    let mut listener = links.listen("bench")?;
    tokio::spawn(async move {
        let mut stream = listener.accept().await?;
        let mut request = [0; 4];
        for answer in answers {
            stream.read_exact(&mut request).await.ok()?;
            stream.write_all(answer.as_bytes()).await.ok()?;
        }
        // The link stays open until the host closes it.
        stream.read_exact(&mut request).await.ok()
    });
    let ports = Ports::new(Arc::new(links));
    let meter = Meter::open(&Target::parse("lumeter:memory:bench")?, &ports).await?;
    let now = Instant::now();
    Ok(meter.read(now, now + Duration::from_secs(10)).await?)
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    let reading = reading(&["123.4\r\n"]).await?;
    let lux = reading.illuminance().ok_or("no number")?;
    println!("{} lx, one digit {} lx", lux.value(), reading.digit.value());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_line_is_a_reading_with_its_digit() {
        let reading = reading(&["123.4\r\n"]).await.unwrap();
        assert_eq!(reading.illuminance().map(Lux::value), Some(123.4));
        assert_eq!(
            (reading.digit.value(), reading.evidence.as_slice()),
            (0.1, &b"123.4\r\n"[..])
        );
    }

    #[tokio::test]
    async fn a_damaged_line_is_an_error_with_its_bytes() {
        let error = reading(&["12?.4\r\n"]).await.unwrap_err().to_string();
        assert!(
            error.contains("lumeter:memory:bench") && error.contains("12?.4"),
            "{error}"
        );
    }
}
