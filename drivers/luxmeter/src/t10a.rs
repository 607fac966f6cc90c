//! Konica Minolta T-10A: `konica-t10a:LINK?head=0`.
//!
//! The meter converts all the time, a new value every half second, and a request gets the latest one. So a request sent
//! at `t` is answered with light of (t − 1 s, t], and while the automatic range is changing the old value is repeated
//! for one interval more (manual, section 1). The driver therefore waits two intervals after `not_before` in a fixed
//! range, three in automatic range, and more than one interval between two requests, so that no conversion is returned
//! twice.
//!
//! An answer carries no number that would tie it to its request: see the module `confirmed` for when a value is
//! believed.
//!
//! Several heads on one line are as many meters that share the line: while one of them waits for its answer, and for as
//! long after it as the true answer could still come, no other request is sent; a byte that nothing had asked for
//! discards what was read from every head. The commands 54 and 55 concern all heads alike.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    Caution, DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome,
    LuxRange, LuxReading, OpenError, Target,
};
use isolux_protocol_t10a::{Answer, Host, Measurement, QUIET, Range, Request, Value};
use isolux_transport::{
    Alone, Bus, Driver, LineSettings, Parity, Place, Ports, Probe, TRIES, printable, worth_another_try,
};
use isolux_units::Lux;
use tokio::time::{Instant, sleep};

use crate::confirmed::{Confirmed, Meter, Pace};

/// Name of the driver in `open = "konica-t10a:…"`.
const NAME: &str = "konica-t10a";

/// Konica Minolta T-10A.
pub const KONICA_T10A: Driver = Driver {
    name: NAME,
    speaks_to: "Konica Minolta T-10A lux meter",
    examples: &[(Kind::LuxMeter, "konica-t10a:/dev/ttyUSB1?head=0")],
    seen_with: "🧪 its virtual twin",
    usb: &[],
    identify: &[Probe {
        line: LINE,
        // Command 54, the only one that a meter answers when it was just switched on: it goes into PC mode.
        request: b"\x0200541   \x0313\r\n",
        read: |bytes| {
            let text = printable(bytes);
            // Its status, and no echo of the request.
            let status = text.strip_prefix("0054")?;
            (!status.starts_with("1   ")).then(|| "Konica Minolta T-10A, in PC mode".to_owned())
        },
    }],
    place: |target, _| {
        let channel = format!("head {}", head(target)?);
        Ok(Place { channel, line: LINE })
    },
    // Four digits (manual, specifications): 29.99 lx in steps of 0.01 lx, and so on by tens.
    display_lx: |_| {
        let digit = |range: usize| 0.01 * 10_f64.powi(range as i32);
        (0..FULL_SCALE_LX.len())
            .map(|range| (FULL_SCALE_LX[range], digit(range)))
            .collect()
    },
    factories: |ports| Factories {
        lux_meter: Some(Arc::new(T10aDriver::new(ports))),
        ..Factories::default()
    },
};

fn head(target: &Target) -> Result<u8, OpenError> {
    target.only(&["head"])?;
    match target.number("head", 0_u8)? {
        head @ 0..=29 => Ok(head),
        head => Err(target.wrong(format!("head={head} is not 0 to 29"))),
    }
}

/// Manual, section 2.
const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 7,
    parity: Parity::Even,
    stop_bits: 1,
};

/// A new value appears this often, and integrates as long.
const UPDATE: Duration = Duration::from_millis(500);

/// An answer of 32 bytes takes 33 ms at 9600 baud; the meter may finish a conversion first.
const ANSWER: Duration = Duration::from_millis(800);

/// For one try at commands 54 and 55, silence of the line before and other heads' readings included.
const OPENING: Duration = Duration::from_secs(6);

/// After commands 54 and 55 the meter wants half a second (manual, sections 5.4 and 5.5).
const SETTLE: Duration = Duration::from_millis(500);

/// Upper ends of the five ranges in lx.
const FULL_SCALE_LX: [f64; 5] = [29.99, 299.9, 2999.0, 29_990.0, 299_900.0];

/// After the last answer the line is watched for so long: a request and an answer take 48 ms, so the true answer to a
/// request that an old one seemed to answer has arrived by then.
const GUARD: Duration = Duration::from_millis(100);

/// Opens T-10A meters.
pub struct T10aDriver {
    ports: Arc<Ports>,
}

impl T10aDriver {
    /// A driver of what is on `ports`.
    pub const fn new(ports: Arc<Ports>) -> Self {
        Self { ports }
    }
}

#[async_trait]
impl LuxMeterFactory for T10aDriver {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let head = head(target)?;
        let bus = self.ports.bus(target, LINE, Host::default).await?;
        let range_full_scale = FULL_SCALE_LX.iter().filter_map(|lx| Lux::new(*lx).ok()).collect();
        let meter = T10a {
            bus,
            name: target.to_string(),
            head,
            identity: Identity {
                driver: NAME,
                target: target.to_string(),
                model: "Konica Minolta T-10A".to_owned(),
                // The language has no word for either.
                serial: None,
                firmware: None,
            },
            properties: LuxMeterProperties {
                range_full_scale,
                update_interval: UPDATE,
                integration: UPDATE,
            },
            range: Mutex::new(Range::Auto),
            confirmed: Confirmed::default(),
        };
        let mut tries = 1;
        while let Err(error) = meter.put_in_step(Instant::now() + OPENING).await {
            if tries >= TRIES || !worth_another_try(error.kind()) {
                return Err(error.into());
            }
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
        meter.confirmed.in_service(&meter).await;
        Ok(Box::new(meter))
    }
}

struct T10a {
    bus: Bus<Host>,
    name: String,
    head: u8,
    identity: Identity,
    properties: LuxMeterProperties,
    range: Mutex<Range>,
    confirmed: Confirmed,
}

#[async_trait]
impl LuxMeter for T10a {
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
        let wanted = match range {
            LuxRange::Auto => Range::Auto,
            LuxRange::Fixed(range @ 1..=5) => Range::Fixed(range),
            LuxRange::Fixed(range) => {
                let (device, action) = (self.name.clone(), format!("use range {range}"));
                let reason = "the T-10A has ranges 1 to 5".to_owned();
                return Err(DeviceError::Unsupported { device, action, reason });
            }
        };
        // A reading under way ends in the range in which it began.
        let _state = self.confirmed.state().await;
        *self.range.lock().unwrap_or_else(PoisonError::into_inner) = wanted;
        Ok(())
    }
}

#[async_trait]
impl Meter for T10a {
    type Language = Host;

    fn bus(&self) -> &Bus<Host> {
        &self.bus
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn pace(&self) -> Pace {
        Pace {
            interval: UPDATE,
            reach: if self.range() == Range::Auto { 3 } else { 2 } * UPDATE,
            patience: ANSWER,
            guard: GUARD,
        }
    }

    async fn exchange(&self, line: &Alone<'_, Host>, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let (range, reach) = (self.range(), self.pace().reach);
        let request = Request::Read {
            head: self.head,
            range,
            hold: false,
        };
        let exchanged = self.ask(line, request, "read", deadline).await?;
        let (measurement, evidence) = match exchanged.answer {
            Some((Answer::Long { measurement, .. }, evidence)) => (measurement, evidence),
            Some((Answer::Short { .. }, evidence)) => return Err(self.malformed("read", "no measurement", evidence)),
            None => return Err(self.malformed("read", "nobody answers this request", Vec::new())),
        };
        // A range that was asked for and is not there yet: the value is an old one.
        if matches!(range, Range::Fixed(range) if measurement.status.range != range) {
            return Err(self.malformed("read", "the range that was asked for is not in use yet", evidence));
        }
        self.reading(measurement, exchanged.sent - reach, evidence)
    }

    /// PC mode, then all heads running. The short answer to 54 proves that no reading is on its way, and a meter that
    /// was switched off and on answers nothing else. No head is asked anything before the meter is ready again.
    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError> {
        let action = "connect (command 54)";
        let line = self.bus.alone(deadline).await;
        let line = line.map_err(|error| error.during(&self.name, action))?;
        self.ask(&line, Request::Connect, action, deadline).await?;
        sleep(SETTLE).await;
        let running = Instant::now() + 2 * QUIET;
        self.ask(&line, Request::Hold(false), "run (command 55)", running)
            .await?;
        sleep(SETTLE).await;
        Ok(())
    }
}

impl T10a {
    fn range(&self) -> Range {
        *self.range.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn reading(&self, measurement: Measurement, began: Instant, evidence: Vec<u8>) -> Result<LuxReading, DeviceError> {
        let status = measurement.status;
        let fault = |reason: String| self.fault("read", reason, evidence.clone());
        if let Some(error) = status.error {
            return Err(fault(error.to_string()));
        }
        if status.hold {
            return Err(fault(
                "the meter holds its reading (HOLD key): the value is old; release it".to_owned(),
            ));
        }
        let unusable = |reason: &str| self.malformed("read", reason, evidence.clone());
        let (outcome, digit) = match (status.over_range, measurement.illuminance_lx) {
            (true, value) => (LuxOutcome::OverRange, value.map_or(1.0, |value| value.digit())),
            (false, Some(value)) => {
                if let Err(reason) = shown_in(status.range, value) {
                    return Err(unusable(&reason));
                }
                let lux = Lux::new(value.number()).map_err(|error| unusable(&error.to_string()))?;
                (LuxOutcome::Measured(lux), value.digit())
            }
            (false, None) => return Err(unusable("no error, and no value")),
        };
        Ok(LuxReading {
            outcome,
            range: status.range,
            confirmed_by: None,
            digit: Lux::new(digit).map_err(|error| unusable(&error.to_string()))?,
            began,
            ended: Instant::now(),
            caution: status.low_battery.then_some(Caution::LowBattery),
            retries: 0,
            evidence,
        })
    }
}

/// Refuses a value that a meter in `range` cannot show: above the range's end, or in steps coarser than its digit. A
/// meter that states no range (0) is held to its widest.
fn shown_in(range: u8, value: Value) -> Result<(), String> {
    let place = if range == 0 {
        FULL_SCALE_LX.len()
    } else {
        usize::from(range)
    };
    let Some(top_lx) = FULL_SCALE_LX.get(place - 1) else {
        return Err(format!("the meter has no range {range}"));
    };
    // Four digits, of which the first goes up to 2: range 1 ends at 29.99 lx and shows 0.01 lx.
    let digit_lx = top_lx / 2999.0;
    if value.number().abs() > top_lx * 1.000_001 || value.digit() > digit_lx * 1.000_001 {
        return Err(format!(
            "{} lx in steps of {} lx is nothing that range {range} can show (up to {top_lx} lx)",
            value.number(),
            value.digit()
        ));
    }
    Ok(())
}
