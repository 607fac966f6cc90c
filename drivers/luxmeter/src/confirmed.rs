//! What the drivers of lux meters share: new light only, and no value on the word of a single answer.
//!
//! The languages of these meters have no request numbers, or only short cycles of them. A value is therefore given only
//! when two exchanges in a row agree and no byte arrived that nothing had asked for; such a byte discards what was
//! read, and the line is put in step again. The exchange before confirms the next one, so a series of readings of the
//! same light costs one exchange more in all.

use std::time::Duration;

use async_trait::async_trait;
use isolux_conversation::Conversation;
use isolux_device::{DeviceError, LuxOutcome, LuxRange, LuxReading, awake};
use isolux_transport::{Alone, Bus, BusError, Exchanged, TRIES, worth_another_try};
use tokio::sync::{Mutex, MutexGuard};
use tokio::time::{Instant, sleep, sleep_until};

/// Exchanges of one reading within which two in a row must agree.
const MOST_EXCHANGES: usize = 12;

/// Two exchanges agree when they differ by no more than this share of the value. Scatter of 0.1 %, as a stable lamp
/// has, stays inside; a lamp that changes faster than 1 % a second is not steady.
const AGREEMENT: f64 = 0.005;

/// Over and above the interval between two requests: the meter's clock is not this one.
const MARGIN: Duration = Duration::from_millis(50);

/// How a meter converts and answers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// A new value appears this often; zero where a request begins a measurement of its own.
    pub interval: Duration,
    /// Light of so long before a request may be in its answer.
    pub reach: Duration,
    /// The longest that an exchange takes.
    pub patience: Duration,
    /// After each answer the line is watched for so long: the true answer to a request that an old one seemed to answer
    /// has arrived by then.
    pub guard: Duration,
}

/// A profile describes one range, which is always in use.
///
/// # Errors
/// [`DeviceError::Unsupported`] for a fixed range.
pub(crate) fn one_range(device: &str, range: LuxRange) -> Result<(), DeviceError> {
    match range {
        LuxRange::Auto => Ok(()),
        LuxRange::Fixed(range) => Err(DeviceError::Unsupported {
            device: device.to_owned(),
            action: format!("use range {range}"),
            reason: "a profile knows one range".to_owned(),
        }),
    }
}

/// A meter whose readings must be confirmed.
#[async_trait]
pub(crate) trait Meter: Send + Sync {
    /// What it speaks.
    type Language: Conversation;

    /// Its handle on the port.
    fn bus(&self) -> &Bus<Self::Language>;

    /// Driver and target, for messages.
    fn name(&self) -> &str;

    /// How it converts and answers now.
    fn pace(&self) -> Pace;

    /// One reading asked for and answered, confirmed by nothing; began and ended as the pace says.
    async fn exchange(&self, line: &Alone<'_, Self::Language>, deadline: Instant) -> Result<LuxReading, DeviceError>;

    /// Proves by an answer that looks like no other that none is still on its way; tried once.
    async fn put_in_step(&self, deadline: Instant) -> Result<(), DeviceError>;

    /// Readings that differ by no more than this are the same to the meter, by its specification; digits aside.
    fn indistinct_lx(&self, _: &LuxReading) -> f64 {
        0.0
    }

    /// A request of `action` on the line that is kept.
    async fn ask(
        &self,
        line: &Alone<'_, Self::Language>,
        request: <Self::Language as Conversation>::Request,
        action: &str,
        deadline: Instant,
    ) -> Result<Exchanged<<Self::Language as Conversation>::Answer>, DeviceError> {
        let exchanged = line.exchange(request, self.pace().patience, deadline).await;
        exchanged.map_err(|error| error.during(self.name(), action))
    }

    /// An answer that is none.
    fn malformed(&self, action: &str, reason: &str, frame: Vec<u8>) -> DeviceError {
        let reason = reason.to_owned();
        BusError::Malformed { reason, frame }.during(self.name(), action)
    }

    /// The meter says that it is at fault.
    fn fault(&self, action: &str, reason: String, evidence: Vec<u8>) -> DeviceError {
        DeviceError::Fault {
            device: self.name().to_owned(),
            action: action.to_owned(),
            reason,
            evidence,
        }
    }
}

/// What is known of the line and of the readings before.
#[derive(Debug, Default)]
pub(crate) struct Confirmed {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
pub(crate) struct State {
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
#[derive(Debug, Clone)]
struct Exchange {
    asked: Instant,
    indistinct_lx: f64,
    reading: LuxReading,
}

impl State {
    /// What was read before no longer confirms anything.
    pub fn forget(&mut self) {
        self.earlier.clear();
    }

    /// Whether bytes have arrived that answer no request. They discard what was read: any answer since may be an old
    /// one.
    fn surplus<M: Meter + ?Sized>(&mut self, meter: &M) -> bool {
        let unsolicited = meter.bus().unsolicited();
        let surplus = unsolicited != self.unsolicited;
        if surplus {
            let device = meter.name();
            tracing::warn!(device, "bytes arrived that nobody asked for: the line is drained");
            self.unsolicited = unsolicited;
            self.earlier.clear();
            self.in_doubt = true;
        }
        surplus
    }

    /// One reading asked for and answered, and the line watched for as long as a second answer could come.
    async fn exchange<M: Meter + ?Sized>(
        &mut self,
        meter: &M,
        pace: Pace,
        deadline: Instant,
    ) -> Result<Exchange, DeviceError> {
        let line = meter.bus().alone(deadline).await;
        let line = line.map_err(|error| error.during(meter.name(), "read"))?;
        // Another device may have had its turn in between.
        if self.surplus(meter) {
            return Err(meter.malformed("read", "bytes arrived that nobody asked for", Vec::new()));
        }
        self.in_doubt = true;
        self.asked = Some(Instant::now());
        let reading = meter.exchange(&line, deadline).await?;
        self.in_doubt = false;
        let asked = reading.began + pace.reach;
        self.asked = Some(asked);
        sleep(pace.guard).await;
        if self.surplus(meter) {
            let reason = "more bytes arrived than the answer to one request";
            return Err(meter.malformed("read", reason, reading.evidence));
        }
        Ok(Exchange {
            asked,
            indistinct_lx: meter.indistinct_lx(&reading),
            reading,
        })
    }
}

impl Confirmed {
    /// Keeps readings away while something is set; who changes what the meter shows calls [`State::forget`].
    pub async fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().await
    }

    /// What has arrived by now was part of putting the meter into service.
    pub async fn in_service<M: Meter + ?Sized>(&self, meter: &M) {
        self.state.lock().await.unsolicited = meter.bus().unsolicited();
    }

    /// A reading of light after `not_before` that two exchanges agree on; see [`isolux_device::LuxMeter::read`].
    pub async fn read<M: Meter + ?Sized>(
        &self,
        meter: &M,
        not_before: Instant,
        mut deadline: Instant,
    ) -> Result<LuxReading, DeviceError> {
        let began = Instant::now();
        let patience = deadline.saturating_duration_since(began);
        let mut state = self.state.lock().await;
        let (mut damaged, mut exchanges) = (0, 0);
        let mut disagreed: Option<LuxReading> = None;
        loop {
            state.surplus(meter);
            let pace = meter.pace();
            let fresh = match state.asked {
                Some(asked) if !pace.interval.is_zero() => asked + pace.interval + MARGIN,
                _ => began,
            };
            let at = fresh.max(not_before + pace.reach);
            let late = at + pace.guard + MARGIN > deadline;
            if late && awake::missed(deadline) && !patience.is_zero() {
                // Nobody waited for the meter meanwhile; what it said before may be of another light.
                deadline = Instant::now() + patience;
                state.forget();
                continue;
            }
            if let Some(reading) = disagreed.take_if(|_| late || exchanges >= MOST_EXCHANGES) {
                return Ok(reading);
            }
            if late {
                sleep_until(deadline).await;
                let (waited, received) = (began.elapsed(), Vec::new());
                return Err(BusError::Timeout { waited, received }.during(meter.name(), "read"));
            }
            let tried = if state.in_doubt {
                // The meter answers in order: an answer of another kind proves that no reading is still on its way.
                let Some(proved) = awake::until(deadline, meter.put_in_step(deadline)).await else {
                    continue;
                };
                if proved.is_ok() {
                    state.in_doubt = false;
                    state.unsolicited = meter.bus().unsolicited();
                }
                proved.map(|()| None)
            } else {
                sleep_until(at).await;
                // Bytes that came while nothing was asked: the line is not in step with the requests.
                if state.surplus(meter) {
                    continue;
                }
                state.exchange(meter, pace, deadline).await.map(Some)
            };
            let error = match tried {
                Ok(None) => continue,
                Ok(Some(exchange)) => {
                    exchanges += 1;
                    // Those before count if their light, too, fell after `not_before`.
                    state.earlier.retain(|before| before.asked >= not_before + pace.reach);
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
}

impl Exchange {
    /// Whether both can be readings of the same light, which one digit may separate or none. A change of range between
    /// them is a disagreement: a meter may repeat old values while it changes.
    fn agrees(&self, other: &Self, digits: f64) -> bool {
        let (a, b) = (&self.reading, &other.reading);
        match (a.outcome, b.outcome) {
            (LuxOutcome::Measured(first), LuxOutcome::Measured(second)) => {
                let (first, second, digit) = (first.value(), second.value(), a.digit.value());
                let shares = AGREEMENT * first.abs().max(second.abs());
                let allowed = shares.max((digits + 1e-6) * digit).max(self.indistinct_lx);
                a.range == b.range
                    && (a.digit == b.digit || self.indistinct_lx > 0.0)
                    && (first - second).abs() <= allowed
            }
            (first, second) => first == second,
        }
    }

    /// The exchange that confirms this one: the one before, with the same value; or, where the light lies between two
    /// values of the display, the one before that, if the one between is a single digit away.
    fn confirmed<'a>(&self, earlier: &'a [Self]) -> Option<&'a Self> {
        match earlier {
            [.., before] if self.agrees(before, 0.0) => Some(before),
            [first, between] if self.agrees(first, 0.0) && self.agrees(between, 1.0) => Some(first),
            _ => None,
        }
    }
}
