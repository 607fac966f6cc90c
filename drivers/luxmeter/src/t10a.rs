//! Konica Minolta T-10A: `konica-t10a:LINK?head=0`.
//!
//! The meter converts all the time, a new value every half second, and a request gets the latest one. So a request sent at
//! `t` is answered with light of (t − 1 s, t], and while the automatic range is changing the old value is repeated for one
//! interval more (manual, section 1). The driver therefore waits two intervals after `not_before` in a fixed range, three in
//! automatic range, and more than one interval between two requests, so that no conversion is returned twice.
//!
//! An answer carries no number that would tie it to its request. A value is therefore given only when two exchanges in a
//! row agree, when it fits the range it states, and when no byte arrived that nothing had asked for; such a byte discards
//! what was read, and the line is drained and put in step again. The exchange before confirms the next one, so a series
//! of readings of the same light costs one exchange more in all.
//!
//! Several heads on one line are as many meters that share the line: while one of them waits for its answer, and for as
//! long after it as the true answer could still come, no other request is sent; a byte that nothing had asked for discards
//! what was read from every head. The commands 54 and 55 concern all heads alike.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    Caution, DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxOutcome,
    LuxRange, LuxReading, OpenError, Target,
};
use isolux_protocol_t10a::{Answer, Host, Measurement, QUIET, Range, Request, Value};
use isolux_transport::{Bus, BusError, Driver, LineSettings, Parity, Place, Ports, TRIES, worth_another_try};
use isolux_units::Lux;
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep, sleep_until, timeout_at};

/// Name of the driver in `open = "konica-t10a:…"`.
const NAME: &str = "konica-t10a";

/// Konica Minolta T-10A.
pub const KONICA_T10A: Driver = Driver {
    name: NAME,
    speaks_to: "Konica Minolta T-10A illuminance meter, one or several heads on a line",
    examples: &[(Kind::LuxMeter, "konica-t10a:/dev/ttyUSB1?head=0")],
    seen_with: "🧪 its virtual twin and scripted bytes; not yet real hardware",
    usb: &[],
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

/// Over and above the update interval between two requests: the meter's clock is not this one.
const MARGIN: Duration = Duration::from_millis(50);

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

/// Exchanges of one reading within which two in a row must agree.
const MOST_EXCHANGES: usize = 12;

/// Two exchanges agree when they differ by no more than this share of the value. Scatter of 0.1 %, as a stable lamp has,
/// stays inside; a lamp that changes faster than 1 % a second is not steady.
const AGREEMENT: f64 = 0.005;

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
            state: Mutex::new(State {
                range: Range::Auto,
                asked: None,
                in_doubt: false,
                earlier: Vec::new(),
                unsolicited: 0,
            }),
        };
        let mut tries = 1;
        while let Err(error) = meter.connect(Instant::now() + OPENING).await {
            if tries >= TRIES || !worth_another_try(error.kind()) {
                return Err(error.into());
            }
            tracing::warn!(%error, tries, "asking again");
            tries += 1;
        }
        meter.state.lock().await.unsolicited = meter.bus.unsolicited();
        Ok(Box::new(meter))
    }
}

struct T10a {
    bus: Bus<Host>,
    name: String,
    head: u8,
    identity: Identity,
    properties: LuxMeterProperties,
    state: Mutex<State>,
}

struct State {
    range: Range,
    /// When the last reading was asked for.
    asked: Option<Instant>,
    /// A reading was given up and may still come, or something came that nobody asked for.
    in_doubt: bool,
    /// The exchanges that may confirm the next one, the latest last; at most two.
    earlier: Vec<Exchange>,
    /// Count of the bus when the line was last known to be in step.
    unsolicited: u64,
}

/// A request and its answer.
#[derive(Clone)]
struct Exchange {
    asked: Instant,
    reading: LuxReading,
}

impl Exchange {
    /// Whether both can be readings of the same light, which one digit may separate or none. A change of range between them
    /// is a disagreement: the meter repeats old values while it changes.
    fn agrees(&self, other: &Self, digits: f64) -> bool {
        let (a, b) = (&self.reading, &other.reading);
        match (a.outcome, b.outcome) {
            (LuxOutcome::Measured(first), LuxOutcome::Measured(second)) => {
                let (first, second, digit) = (first.value(), second.value(), a.digit.value());
                let allowed = (AGREEMENT * first.abs().max(second.abs())).max((digits + 1e-6) * digit);
                a.range == b.range && a.digit == b.digit && (first - second).abs() <= allowed
            }
            (first, second) => first == second,
        }
    }

    /// The exchange that confirms this one: the one before, with the same value; or, where the light lies between two values
    /// of the display, the one before that, if the one between is a single digit away.
    fn confirmed<'a>(&self, earlier: &'a [Self]) -> Option<&'a Self> {
        match earlier {
            [.., before] if self.agrees(before, 0.0) => Some(before),
            [first, between] if self.agrees(first, 0.0) && self.agrees(between, 1.0) => Some(first),
            _ => None,
        }
    }
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
        let began = Instant::now();
        let mut state = self.state.lock().await;
        let (mut damaged, mut exchanges) = (0, 0);
        let mut disagreed: Option<LuxReading> = None;
        loop {
            self.surplus(&mut state);
            let reach = if state.range == Range::Auto { 3 } else { 2 } * UPDATE;
            let fresh = state.asked.map_or(began, |asked| asked + UPDATE + MARGIN);
            let at = fresh.max(not_before + reach);
            let late = at + GUARD + MARGIN > deadline;
            if let Some(reading) = disagreed.take_if(|_| late || exchanges >= MOST_EXCHANGES) {
                return Ok(reading);
            }
            if late {
                sleep_until(deadline).await;
                let (device, action) = (self.name.clone(), "read".to_owned());
                return Err(DeviceError::Timeout {
                    device,
                    action,
                    waited: began.elapsed(),
                    received: Vec::new(),
                });
            }
            let tried = if state.in_doubt {
                // The meter answers in order, so the short answer to 54 proves that no reading is still on its way; and one
                // that was switched off and on answers nothing else.
                let Ok(connected) = timeout_at(deadline, self.connect(deadline)).await else {
                    continue;
                };
                if connected.is_ok() {
                    state.in_doubt = false;
                    state.unsolicited = self.bus.unsolicited();
                }
                connected.map(|()| None)
            } else {
                sleep_until(at).await;
                // Bytes that came while nothing was asked: the line is not in step with the requests.
                if self.surplus(&mut state) {
                    continue;
                }
                self.exchange(&mut state, reach, deadline).await.map(Some)
            };
            let error = match tried {
                Ok(None) => continue,
                Ok(Some(exchange)) => {
                    exchanges += 1;
                    // Those before count if their light, too, fell after `not_before`.
                    state.earlier.retain(|before| before.asked >= not_before + reach);
                    let confirmed_by = exchange.confirmed(&state.earlier).map(|by| by.reading.outcome);
                    let (alone, mut reading) = (state.earlier.is_empty(), exchange.reading.clone());
                    reading.retries = damaged;
                    state.earlier.push(exchange);
                    if state.earlier.len() > 2 {
                        state.earlier.remove(0);
                    }
                    if confirmed_by.is_some() {
                        return Ok(LuxReading {
                            confirmed_by,
                            ..reading
                        });
                    }
                    if !alone {
                        tracing::warn!(outcome = ?reading.outcome, "an answer disagrees with the one before");
                        let outcome = LuxOutcome::Unsteady;
                        disagreed = Some(LuxReading { outcome, ..reading });
                    }
                    continue;
                }
                Err(error) => error,
            };
            state.earlier.clear();
            damaged += 1;
            if damaged >= TRIES || !worth_another_try(error.kind()) {
                return Err(error);
            }
            tracing::warn!(%error, damaged, "asking again");
        }
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
        self.state.lock().await.range = wanted;
        Ok(())
    }
}

impl T10a {
    /// PC mode, then all heads running; tried once. No head is asked anything before the meter is ready again.
    async fn connect(&self, deadline: Instant) -> Result<(), DeviceError> {
        let action = "connect (command 54)";
        let line = self.bus.alone(deadline).await;
        let line = line.map_err(|error| error.during(&self.name, action))?;
        let answered = line.exchange(Request::Connect, ANSWER, deadline).await;
        answered.map_err(|error| error.during(&self.name, action))?;
        sleep(SETTLE).await;
        let sent = line
            .exchange(Request::Hold(false), ANSWER, Instant::now() + 2 * QUIET)
            .await;
        sent.map_err(|error| error.during(&self.name, "run (command 55)"))?;
        sleep(SETTLE).await;
        Ok(())
    }

    /// Whether bytes have arrived that answer no request. They discard what was read: any answer since may be an old one.
    fn surplus(&self, state: &mut State) -> bool {
        let unsolicited = self.bus.unsolicited();
        let surplus = unsolicited != state.unsolicited;
        if surplus {
            tracing::warn!(
                device = self.name,
                "bytes arrived that nobody asked for: the line is drained"
            );
            state.unsolicited = unsolicited;
            state.earlier.clear();
            state.in_doubt = true;
        }
        surplus
    }

    /// One reading asked for and answered, and the line watched for as long as a second answer could come.
    async fn exchange(&self, state: &mut State, reach: Duration, deadline: Instant) -> Result<Exchange, DeviceError> {
        let failed = |error: BusError| error.during(&self.name, "read");
        let line = self.bus.alone(deadline).await.map_err(failed)?;
        // Another head may have had its turn in between.
        if self.surplus(state) {
            return Err(self.malformed("read", "bytes arrived that nobody asked for", Vec::new()));
        }
        state.in_doubt = true;
        let request = Request::Read {
            head: self.head,
            range: state.range,
            hold: false,
        };
        let exchanged = line.exchange(request, ANSWER, deadline).await.map_err(failed)?;
        let asked = exchanged.sent;
        state.asked = Some(asked);
        let (measurement, evidence) = match exchanged.answer {
            Some((Answer::Long { measurement, .. }, evidence)) => (measurement, evidence),
            Some((Answer::Short { .. }, evidence)) => return Err(self.malformed("read", "no measurement", evidence)),
            None => return Err(self.malformed("read", "nobody answers this request", Vec::new())),
        };
        // A range that was asked for and is not there yet: the value is an old one.
        let switching = matches!(state.range, Range::Fixed(range) if measurement.status.range != range);
        state.in_doubt = false;
        if switching {
            return Err(self.malformed("read", "the range that was asked for is not in use yet", evidence));
        }
        let reading = self.reading(measurement, asked - reach, evidence)?;
        sleep(GUARD).await;
        if self.surplus(state) {
            let reason = "more bytes arrived than the answer to one request";
            return Err(self.malformed("read", reason, reading.evidence));
        }
        Ok(Exchange { asked, reading })
    }

    fn reading(&self, measurement: Measurement, began: Instant, evidence: Vec<u8>) -> Result<LuxReading, DeviceError> {
        let status = measurement.status;
        let fault = |reason: String| DeviceError::Fault {
            device: self.name.clone(),
            action: "read".to_owned(),
            reason,
            evidence: evidence.clone(),
        };
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

    fn malformed(&self, action: &str, reason: &str, frame: Vec<u8>) -> DeviceError {
        let (device, action, reason) = (self.name.clone(), action.to_owned(), reason.to_owned());
        DeviceError::Malformed {
            device,
            action,
            reason,
            frame,
        }
    }
}

/// Refuses a value that a meter in `range` cannot show: above the range's end, or in steps coarser than its digit. A meter
/// that states no range (0) is held to its widest.
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
