//! Power meters in SCPI: `scpi-meter:LINK?profile=gpm-8213`.
//!
//! All quantities come in one answer, so that they are of one update. The meter updates all the time and a request gets the
//! latest values: of the update interval before the request. A reading is given when two exchanges, more than an update apart,
//! agree, and no byte arrived that nothing had asked for.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    DeviceError, Factories, Identity, Kind, OpenError, PowerMeter, PowerMeterFactory, PowerReading, Quantity, Target,
};
use isolux_protocol_scpi::{Answer, Reading, Request};
use isolux_transport::{
    BusError, Driver, LineSettings, Parity, Place, Ports, Probe, TRIES, no_display, printable, worth_another_try,
};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep, sleep_until};

use crate::instrument::Instrument;
use crate::profile::{Field, Meter};

const NAME: &str = "scpi-meter";

/// Over and above the update interval between two requests: the meter's clock is not this one.
const MARGIN: Duration = Duration::from_millis(50);

/// The true answer to a request that an old one seemed to answer has come within this.
const GUARD: Duration = Duration::from_millis(100);

/// Two readings agree when each quantity differs by no more than this share, or by two of its last digits.
const AGREEMENT: f64 = 0.005;

/// Exchanges of one reading within which two in a row must agree.
const MOST_EXCHANGES: usize = 12;

/// Power meters in SCPI.
pub const SCPI_METER: Driver = Driver {
    name: NAME,
    speaks_to: "power meters in SCPI over serial or TCP, by a profile in TOML (GW Instek GPM-8213, Hioki PW3336/3337)",
    examples: &[(Kind::PowerMeter, "scpi-meter:/dev/ttyUSB0?profile=gpm-8213")],
    seen_with: "🧪 its virtual twin, which pyvisa-py reads too, and scripted bytes; not yet real hardware",
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
        let asked = Mutex::default();
        Ok(Box::new(ScpiMeter {
            instrument,
            profile,
            asked,
        }))
    }
}

struct ScpiMeter {
    instrument: Instrument,
    profile: Meter,
    /// When the last reading was asked for.
    asked: Mutex<Option<Instant>>,
}

/// A request and its answer.
struct Exchange {
    asked: Instant,
    reading: PowerReading,
    /// Last digits of the quantities.
    steps: [f64; 4],
}

impl Exchange {
    fn agrees(&self, other: &Self) -> bool {
        let quantities =
            |reading: &PowerReading| [reading.voltage, reading.current, reading.power, reading.power_factor];
        let pairs = quantities(&self.reading)
            .into_iter()
            .zip(quantities(&other.reading))
            .zip(self.steps);
        pairs.into_iter().all(|((a, b), step)| match (a, b) {
            (Quantity::Measured(a), Quantity::Measured(b)) => {
                (a - b).abs() <= (AGREEMENT * a.abs().max(b.abs())).max(2.0 * step * (1.0 + 1e-6))
            }
            (a, b) => a == b,
        })
    }
}

impl ScpiMeter {
    /// One reading asked for and answered, and the line watched for as long as a second answer could come.
    async fn exchange(&self, deadline: Instant) -> Result<Exchange, DeviceError> {
        let query = &self.profile.query;
        let line = self.instrument.bus().alone(deadline).await;
        let line = line.map_err(|error| error.during(self.instrument.name(), query))?;
        let unsolicited = self.instrument.bus().unsolicited();
        let request = Request {
            message: query.clone(),
            expect: self.profile.form,
        };
        let exchanged = self.instrument.exchange(&line, request, deadline).await?;
        let ended = Instant::now();
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
        let mut quantities = [Quantity::NoData; 4];
        let mut steps = [0.0; 4];
        for (field, value) in self.profile.fields.iter().zip(values) {
            let place = match field {
                Field::Voltage => 0,
                Field::Current => 1,
                Field::Power => 2,
                Field::PowerFactor => 3,
                Field::Unused => continue,
            };
            quantities[place] = match value {
                Reading::Value(number) => {
                    steps[place] = number.step;
                    Quantity::Measured(number.value)
                }
                Reading::NoData => Quantity::NoData,
                Reading::OverRange => Quantity::OverRange,
                Reading::Unusable(text) => {
                    let reason = format!("\"{text}\" is no value of {field:?}");
                    return Err(self.instrument.malformed(query, &reason, evidence));
                }
            };
        }
        let [voltage, current, power, power_factor] = quantities;
        self.possible(quantities, steps, &evidence)?;
        let began = exchanged
            .sent
            .checked_sub(self.profile.update)
            .unwrap_or(exchanged.sent);
        Ok(Exchange {
            asked: exchanged.sent,
            steps,
            reading: PowerReading {
                voltage,
                current,
                power,
                power_factor,
                began,
                ended,
                steady: false,
                retries: 0,
                evidence,
            },
        })
    }

    /// Refuses values that belong to different quantities: |P| is never above U·I, and λ is P ÷ (U·I).
    fn possible(&self, quantities: [Quantity; 4], steps: [f64; 4], evidence: &[u8]) -> Result<(), DeviceError> {
        let [Some(voltage), Some(current), Some(power), factor] = quantities.map(Quantity::value) else {
            return Ok(());
        };
        // Near nothing the noise of the meter decides.
        let apparent = (voltage * current).abs();
        let doubt = 0.01 * apparent + voltage.abs() * 2.0 * steps[1] + current.abs() * 2.0 * steps[0] + 2.0 * steps[2];
        let mut reason = None;
        if power.abs() > apparent + doubt {
            reason = Some(format!("{power} W from {voltage} V and {current} A cannot be"));
        }
        if let Some(factor) = factor
            && ((factor.abs() > 1.0 + 2.0 * steps[3])
                || (apparent > 20.0 * doubt && (factor.abs() * apparent - power.abs()).abs() > 0.02 * apparent + doubt))
        {
            reason = Some(format!(
                "a power factor of {factor} with {power} W, {voltage} V and {current} A cannot be"
            ));
        }
        match reason {
            None => Ok(()),
            Some(reason) => Err(self
                .instrument
                .malformed(&self.profile.query, &reason, evidence.to_vec())),
        }
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
        let began = Instant::now();
        let mut asked = self.asked.lock().await;
        let (mut retries, mut exchanges) = (0, 0);
        let mut before: Option<Exchange> = None;
        loop {
            let fresh = asked.map_or(began, |asked| asked + self.profile.update + MARGIN);
            let at = fresh.max(not_before + self.profile.update);
            let late = at + GUARD + MARGIN > deadline || exchanges >= MOST_EXCHANGES;
            if late && let Some(before) = before.take() {
                return Ok(before.reading);
            }
            if late {
                sleep_until(deadline).await;
                let (waited, received) = (began.elapsed(), Vec::new());
                return Err(BusError::Timeout { waited, received }.during(self.instrument.name(), &self.profile.query));
            }
            sleep_until(at).await;
            *asked = Some(Instant::now());
            match self.exchange(deadline).await {
                Ok(mut exchange) => {
                    exchanges += 1;
                    *asked = Some(exchange.asked);
                    exchange.reading.retries = retries;
                    exchange.reading.steady = before.is_some_and(|before| exchange.agrees(&before));
                    if exchange.reading.steady {
                        return Ok(exchange.reading);
                    }
                    before = Some(exchange);
                }
                Err(error) => {
                    retries += 1;
                    if retries >= TRIES || !worth_another_try(error.kind()) {
                        return Err(error);
                    }
                    tracing::warn!(%error, retries, "asking again");
                    before = None;
                    // Its answer looks like no reading: whatever was on its way has come.
                    self.instrument.twice("*IDN?").await?;
                }
            }
        }
    }
}
