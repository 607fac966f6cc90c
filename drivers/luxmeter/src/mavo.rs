//! Gossen MAVO-USB (MAVOLUX 5032): `gossen-mavo-usb:LINK`.
//!
//! The meter converts once in two seconds and a request gets the latest value, so the driver waits two intervals after
//! `not_before` in a fixed range, three in automatic range, and more than one between two requests. A measurement is
//! followed by the question for its range; both together are one exchange.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome, LuxRange,
    LuxReading, OpenError, Target,
};
use isolux_protocol_ascii::{Lines, Number};
use isolux_protocol_mavo::{Answer, ErrorCode, Mavo, Request};
use isolux_transport::{Alone, Bus, Driver, LineSettings, Parity, Place, Ports, Probe, no_display, printable};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::{Confirmed, Meter, Pace};

const NAME: &str = "gossen-mavo-usb";

/// Interface description, section 1.2.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 7,
    parity: Parity::Even,
    stop_bits: 2,
};

/// "0,5 measurements per second", section 4.1.
const UPDATE: Duration = Duration::from_secs(2);

/// An answer takes some 30 ms at 9600 baud; the meter may finish a conversion first.
const ANSWER: Duration = Duration::from_secs(3);

/// Request and answer take less than this.
const GUARD: Duration = Duration::from_millis(100);

/// The MAVO-USB interface of Gossen.
pub const GOSSEN_MAVO_USB: Driver = Driver {
    name: NAME,
    speaks_to: "Gossen MAVOLUX 5032 with MAVO-USB",
    examples: &[(Kind::LuxMeter, "gossen-mavo-usb:/dev/ttyUSB0")],
    seen_with: "🧪 its virtual twin; exchanges printed in its description",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        request: b"\n*IDN?\n",
        read: |bytes| {
            let text = printable(bytes);
            let (_, name) = text.split_once("GOSSEN,")?;
            Some(format!("Gossen {}", name.trim()))
        },
    }],
    place: |target, _| place(target),
    display_lx: no_display,
    factories: |ports| Factories {
        lux_meter: Some(Arc::new(MavoDriver { ports })),
        ..Factories::default()
    },
};

fn place(target: &Target) -> Result<Place, OpenError> {
    target.only(&[])?;
    let channel = String::new();
    Ok(Place { channel, line: LINE })
}

struct MavoDriver {
    ports: Arc<Ports>,
}

#[async_trait]
impl LuxMeterFactory for MavoDriver {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let line = place(target)?.line;
        let bus = self.ports.bus(target, line, Lines::<Mavo>::default).await?;
        let identity = Identity {
            driver: NAME,
            target: target.to_string(),
            model: String::new(),
            serial: None,
            firmware: None,
        };
        let mut meter = MavoUsb {
            bus,
            name: target.to_string(),
            identity,
            properties: LuxMeterProperties {
                // They differ between the models, which the meter names by a number that no public document explains.
                range_full_scale: Vec::new(),
                update_interval: UPDATE,
                integration: UPDATE,
            },
            wanted: Mutex::new(LuxRange::Auto),
            confirmed: Confirmed::default(),
        };
        meter.begin().await?;
        Ok(Box::new(meter))
    }
}

struct MavoUsb {
    bus: Bus<Lines<Mavo>>,
    name: String,
    identity: Identity,
    properties: LuxMeterProperties,
    wanted: Mutex<LuxRange>,
    confirmed: Confirmed,
}

impl MavoUsb {
    /// Echo, identity, unit, automatic range.
    async fn begin(&mut self) -> Result<(), DeviceError> {
        self.set(Request::Echo, "ECHO ON").await?;
        let (answer, bytes) = self.setting(Request::Identify, "*IDN?").await?;
        let Answer::Identity(text) = answer else {
            return Err(self.malformed("*IDN?", "no identity", bytes));
        };
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let [maker, model, serial, _, firmware] = fields[..] else {
            return Err(self.malformed(
                "*IDN?",
                "expected five fields: maker, type, serial, hardware, firmware",
                bytes,
            ));
        };
        self.identity.model = format!("{maker} {model}");
        self.identity.serial = Some(serial.to_owned());
        self.identity.firmware = Some(firmware.to_owned());
        self.set(Request::Lux, "UNI:PHOT LX").await?;
        self.set(Request::SetAuto(true), "RAN:AUTO ON").await?;
        self.confirmed.in_service(self).await;
        Ok(())
    }

    /// A request whose answer cannot be a reading; once more after `RAN?` where its answer is lost.
    async fn setting(&self, request: Request, action: &str) -> Result<(Answer, Vec<u8>), DeviceError> {
        let deadline = Instant::now() + 4 * ANSWER;
        let asked = self
            .bus
            .ask_again(request, Some(Request::Range), ANSWER, deadline)
            .await;
        let reply = asked.map_err(|error| error.during(&self.name, action))?;
        match reply.answer {
            Answer::Error(code) => Err(self.refused(action, code, reply.bytes)),
            answer => Ok((answer, reply.bytes)),
        }
    }

    async fn set(&self, request: Request, action: &str) -> Result<(), DeviceError> {
        match self.setting(request, action).await? {
            (Answer::Done, _) => Ok(()),
            (_, bytes) => Err(self.malformed(action, "not the answer to a setting", bytes)),
        }
    }

    fn refused(&self, action: &str, code: ErrorCode, frame: Vec<u8>) -> DeviceError {
        DeviceError::Refused {
            device: self.name.clone(),
            action: action.to_owned(),
            reason: format!("error {}, {}", code.0, code.meaning()),
            frame,
        }
    }

    fn wanted(&self) -> LuxRange {
        *self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[async_trait]
impl Meter for MavoUsb {
    type Language = Lines<Mavo>;

    fn bus(&self) -> &Bus<Lines<Mavo>> {
        &self.bus
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn pace(&self) -> Pace {
        Pace {
            interval: UPDATE,
            // While the automatic range changes, the old value may be repeated for one interval more.
            reach: if self.wanted() == LuxRange::Auto { 3 } else { 2 } * UPDATE,
            patience: ANSWER,
            guard: GUARD,
        }
    }

    async fn exchange(&self, line: &Alone<'_, Lines<Mavo>>, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let measured = self.ask(line, Request::Measure, "PHOT?", deadline).await?;
        let ended = Instant::now();
        let range = self.ask(line, Request::Range, "RAN?", deadline).await?;
        let evidence = [&measured.answer.bytes[..], &range.answer.bytes].concat();
        let Answer::Range(range) = range.answer.answer else {
            return Err(self.malformed("RAN?", "no range", evidence));
        };
        // Its numbers begin at 0; a reading's begin at 1, the most sensitive.
        let range = range + 1;
        if matches!(self.wanted(), LuxRange::Fixed(wanted) if wanted != range) {
            return Err(self.malformed("PHOT?", "the range that was asked for is not in use yet", evidence));
        }
        let (outcome, digit) = match measured.answer.answer {
            Answer::Measurement(measurement) => {
                let Number { value, step } = measurement.lux;
                (Lux::new(value).map(LuxOutcome::Measured), step)
            }
            Answer::Error(code) if code.is_over_range() => (Ok(LuxOutcome::OverRange), 1.0),
            // The request was damaged on its way to the meter.
            Answer::Error(code) if code.is_transmission() => {
                return Err(self.malformed("PHOT?", code.meaning(), evidence));
            }
            Answer::Error(code) => {
                return Err(self.fault("PHOT?", format!("error {}, {}", code.0, code.meaning()), evidence));
            }
            _ => return Err(self.malformed("PHOT?", "no measurement", evidence)),
        };
        let unusable = |error: isolux_units::NotFinite| self.malformed("PHOT?", &error.to_string(), evidence.clone());
        Ok(LuxReading {
            outcome: outcome.map_err(unusable)?,
            range,
            confirmed_by: None,
            digit: Lux::new(digit).map_err(unusable)?,
            began: measured.sent - self.pace().reach,
            ended,
            caution: None,
            retries: 0,
            evidence,
        })
    }

    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError> {
        let asked = self.bus.ask_within(Request::Identify, ANSWER, deadline).await;
        asked.map(|_| ()).map_err(|error| error.during(&self.name, "*IDN?"))
    }
}

#[async_trait]
impl LuxMeter for MavoUsb {
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
        let mut state = self.confirmed.state().await;
        match range {
            LuxRange::Auto => self.set(Request::SetAuto(true), "RAN:AUTO ON").await?,
            LuxRange::Fixed(number @ 1..=5) => {
                self.set(Request::SetAuto(false), "RAN:AUTO OFF").await?;
                self.set(Request::SetRange(number - 1), &format!("RAN {}", number - 1))
                    .await?;
            }
            LuxRange::Fixed(number) => {
                return Err(DeviceError::Unsupported {
                    device: self.name.clone(),
                    action: format!("use range {number}"),
                    reason: "the meter has ranges 1 to 5 (0 to 4 in its own count)".to_owned(),
                });
            }
        }
        *self.wanted.lock().unwrap_or_else(PoisonError::into_inner) = range;
        state.forget();
        Ok(())
    }
}
