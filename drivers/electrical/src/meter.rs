//! Power meters in SCPI: `scpi-meter:LINK?profile=gpm-8213`.
//!
//! All quantities come in one answer, so that they are of one update. The meter updates all the time and a request gets
//! the latest values: of the update interval before the request. A reading is given when two exchanges, more than an
//! update apart, agree, and no byte arrived that nothing had asked for.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, OpenError, PowerMeter, PowerMeterFactory, PowerReading, Target,
};
use isolux_protocol_scpi::{Answer, Reading, Request};
use isolux_transport::{Driver, LineSettings, Parity, Place, Ports, Probe, no_display, printable};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

use crate::exchange::{Exchange, GUARD, Source, confirmed};
use crate::instrument::Instrument;
use crate::profile::{Field, Meter};

const NAME: &str = "scpi-meter";

/// Power meters in SCPI.
pub const SCPI_METER: Driver = Driver {
    name: NAME,
    speaks_to: "power meters in SCPI by a profile: GW Instek GPM-8213, Hioki PW3336/3337",
    examples: &[(Kind::PowerMeter, "scpi-meter:/dev/ttyUSB0?profile=gpm-8213")],
    seen_with: "🧪 its virtual twin; pyvisa-py 0.8.1 (GPM-8213)",
    usb: &[],
    identify: &[Probe {
        line: LineSettings {
            baud: 9600,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        },
        request: b"\n*IDN?\n",
        read: |bytes| {
            let text = printable(bytes);
            // Maker, model, serial number, firmware (IEEE 488.2, 10.14).
            (text.split(',').count() == 4).then(|| format!("an instrument in SCPI: {text}"))
        },
    }],
    place: |target, _| {
        let (line, channel) = (profile(target)?.manners.line, String::new());
        Ok(Place { channel, line })
    },
    display_lx: no_display,
    factories: |ports| Factories {
        power_meter: Some(Arc::new(ScpiMeterDriver { ports })),
        ..Factories::default()
    },
};

fn profile(target: &Target) -> Result<Meter, OpenError> {
    target.only(&["profile"])?;
    Meter::of(target)
}

struct ScpiMeterDriver {
    ports: Arc<Ports>,
}

#[async_trait]
impl PowerMeterFactory for ScpiMeterDriver {
    async fn open_power_meter(&self, target: &Target) -> Result<Box<dyn PowerMeter>, OpenError> {
        let profile = profile(target)?;
        let instrument = Instrument::open(&self.ports, target, NAME, &profile.manners).await?;
        let requested = Mutex::default();
        Ok(Box::new(ScpiMeter {
            instrument,
            profile,
            requested,
        }))
    }
}

struct ScpiMeter {
    instrument: Instrument,
    profile: Meter,
    /// When the last reading was asked for.
    requested: Mutex<Option<Instant>>,
}

#[async_trait]
impl Source for ScpiMeter {
    fn name(&self) -> &str {
        self.instrument.name()
    }

    fn query(&self) -> &str {
        &self.profile.query
    }

    fn update(&self) -> Duration {
        self.profile.update
    }

    /// One reading asked for and answered, and the line watched for as long as a second answer could come.
    async fn exchange(&self, deadline: Instant) -> Result<Exchange, DeviceError> {
        let query = &self.profile.query;
        let line = self.instrument.bus().exclusive(deadline).await;
        let line = line.map_err(|error| error.during(self.instrument.name(), query))?;
        let unsolicited = self.instrument.bus().unsolicited();
        let request = Request {
            message: query.clone(),
            expect: self.profile.form,
        };
        let exchanged = self.instrument.exchange(&line, request, deadline).await?;
        let times = (exchanged.sent, Instant::now());
        sleep(GUARD).await;
        let (answer, evidence) = (exchanged.answer.answer, exchanged.answer.bytes);
        if self.instrument.bus().unsolicited() != unsolicited {
            let reason = "more bytes arrived than the answer to one request";
            return Err(self.instrument.malformed(query, reason, evidence));
        }
        let values: Vec<Reading> = match &answer {
            Answer::Text(text) => text.split(self.profile.separator).map(value).collect(),
            Answer::Block(bytes) if bytes.len() % 4 == 0 => {
                let words = bytes
                    .chunks_exact(4)
                    .map(|four| four.iter().fold(0, |word, byte| word << 8 | u32::from(*byte)));
                words.map(Reading::of_single).collect()
            }
            _ => return Err(self.instrument.malformed(query, "no block of whole numbers", evidence)),
        };
        if values.len() != self.profile.fields.len() {
            let reason = format!("{} values, expected {}", values.len(), self.profile.fields.len());
            return Err(self.instrument.malformed(query, &reason, evidence));
        }
        let mut quantities = [const { Reading::NoData }; 4];
        for (field, value) in self.profile.fields.iter().zip(values) {
            let place = match field {
                Field::Voltage => 0,
                Field::Current => 1,
                Field::Power => 2,
                Field::PowerFactor => 3,
                Field::Unused => continue,
            };
            quantities[place] = value;
        }
        Exchange::of(quantities, times, self.profile.update, evidence.clone())
            .map_err(|reason| self.instrument.malformed(query, &reason, evidence))
    }

    async fn put_in_step(&self) -> Result<(), DeviceError> {
        // Its answer looks like no reading: whatever was on its way has come.
        self.instrument.twice("*IDN?").await.map(drop)
    }
}

/// One field, with or without a header before it: `U +110.14E+0`.
fn value(field: &str) -> Reading {
    let text = field.trim();
    Reading::parse(text.rsplit(' ').next().unwrap_or(text), "")
}

#[async_trait]
impl PowerMeter for ScpiMeter {
    fn identity(&self) -> &Identity {
        self.instrument.identity()
    }

    fn update_interval(&self) -> Duration {
        self.profile.update
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<PowerReading, DeviceError> {
        confirmed(self, &self.requested, not_before, deadline).await
    }
}
