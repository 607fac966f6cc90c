//! What the drivers of lux meters share: new light only, and no value on the word of a single answer.
//!
//! The languages of these meters have no request numbers, or only short cycles of them. A value is therefore given only
//! when two exchanges in a row agree and no byte arrived that nothing had asked for; such a byte discards what was
//! read, and the line is put in step again. The exchange before confirms the next one, so a series of readings of the
//! same light costs one exchange more in all.

use std::time::Duration;

use isolux_device::{DeviceError, LuxOutcome, LuxReading, LuxSample, awake};
use isolux_transport::{BusError, TRIES, worth_another_try};
use tokio::time::{Instant, sleep, sleep_until};

use crate::connected::Connected;
use crate::language::{Failure, Language};

/// Exchanges of one reading within which two in a row must agree.
const MOST_EXCHANGES: usize = 12;

/// Two exchanges agree when they differ by no more than this share of the value. Scatter of 0.1 %, as a stable lamp
/// has, stays inside; a lamp that changes faster than 1 % a second is not steady.
const AGREEMENT: f64 = 0.005;

/// Over and above the interval between two requests: the meter's clock is not this one.
const MARGIN: Duration = Duration::from_millis(50);

/// After each answer the line is watched for so long: a request and an answer take less, so the true answer to a
/// request that an old one seemed to answer has arrived by then.
const GUARD: Duration = Duration::from_millis(100);

/// What is known of the line and of the readings before.
#[derive(Debug, Default)]
pub(crate) struct State {
    /// When the last reading was asked for.
    requested: Option<Instant>,
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
    requested: Instant,
    indistinct_lx: f64,
    reading: LuxReading,
}

impl State {
    /// A line in step, on which so many bytes have come unasked.
    pub fn in_step(unsolicited: u64) -> Self {
        Self {
            unsolicited,
            ..Self::default()
        }
    }

    /// What was read before no longer confirms anything.
    pub fn forget(&mut self) {
        self.earlier.clear();
    }

    /// Whether bytes have arrived that answer no request. They discard what was read: any answer since may be an old
    /// one.
    fn surplus<L: Language>(&mut self, meter: &Connected<L>) -> bool {
        let unsolicited = meter.link.bus.unsolicited();
        let surplus = unsolicited != self.unsolicited;
        if surplus {
            let device = &meter.link.name;
            tracing::warn!(device, "bytes arrived that nobody asked for: the line is drained");
            self.unsolicited = unsolicited;
            self.earlier.clear();
            self.in_doubt = true;
        }
        surplus
    }

    /// The next conversion, confirmed by nothing; see [`isolux_device::LuxMeter::sample`]. Nobody watches the line
    /// after it: what arrives too much is seen before the next one.
    pub async fn sample<L: Language>(
        &mut self,
        meter: &Connected<L>,
        deadline: Instant,
    ) -> Result<LuxSample, DeviceError> {
        // It is of another light than what is read at rest.
        self.earlier.clear();
        if self.in_doubt {
            meter.language.put_in_step(&meter.link, deadline).await?;
            self.in_doubt = false;
            self.unsolicited = meter.link.bus.unsolicited();
        }
        let line = meter.link.bus.exclusive(deadline).await;
        let line = line.map_err(|error| error.during(&meter.link.name, "read"))?;
        let too_much = || {
            let failure = Failure::malformed("bytes arrived that nobody asked for");
            meter.link.failure("read", failure, Vec::new())
        };
        if self.surplus(meter) {
            return Err(too_much());
        }
        self.in_doubt = true;
        let reading = meter.exchange(&line, meter.patience(), deadline).await?;
        let requested = reading.began + meter.reach();
        self.requested = Some(requested);
        if self.surplus(meter) {
            return Err(too_much());
        }
        let soonest = meter.language.soonest();
        if soonest.is_some_and(|soonest| reading.ended < requested + soonest) {
            // Every answer after it would be that to the request before, so the line is put in step again.
            let failure = Failure::malformed(
                "it came before its light could be integrated or its bytes be on the line: it answers an \
                 earlier request",
            );
            return Err(meter.link.failure("read", failure, reading.evidence));
        }
        self.in_doubt = false;
        Ok(LuxSample {
            outcome: reading.outcome,
            range: reading.range,
            digit: reading.digit,
            requested,
            answered: reading.ended,
            evidence: reading.evidence,
        })
    }

    /// One reading asked for and answered, and the line watched for as long as a second answer could come.
    async fn exchange<L: Language>(
        &mut self,
        meter: &Connected<L>,
        deadline: Instant,
    ) -> Result<Exchange, DeviceError> {
        let line = meter.link.bus.exclusive(deadline).await;
        let line = line.map_err(|error| error.during(&meter.link.name, "read"))?;
        // Another device may have had its turn in between.
        if self.surplus(meter) {
            let failure = Failure::malformed("bytes arrived that nobody asked for");
            return Err(meter.link.failure("read", failure, Vec::new()));
        }
        self.in_doubt = true;
        self.requested = Some(Instant::now());
        let reading = meter.exchange(&line, meter.language.timing().answer, deadline).await?;
        self.in_doubt = false;
        let requested = reading.began + meter.reach();
        self.requested = Some(requested);
        sleep(GUARD).await;
        if self.surplus(meter) {
            let failure = Failure::malformed("more bytes arrived than the answer to one request");
            return Err(meter.link.failure("read", failure, reading.evidence));
        }
        Ok(Exchange {
            requested,
            indistinct_lx: meter.language.indistinct_lx(&reading),
            reading,
        })
    }

    /// A reading of light after `not_before` that two exchanges agree on; see [`isolux_device::LuxMeter::read`].
    pub async fn confirmed<L: Language>(
        &mut self,
        meter: &Connected<L>,
        not_before: Instant,
        mut deadline: Instant,
    ) -> Result<LuxReading, DeviceError> {
        let began = Instant::now();
        let patience = deadline.saturating_duration_since(began);
        let (mut damaged, mut exchanges) = (0, 0);
        let mut disagreed: Option<LuxReading> = None;
        loop {
            self.surplus(meter);
            let (interval, reach) = (meter.language.timing().interval(), meter.reach());
            let fresh = match self.requested {
                Some(requested) if !interval.is_zero() => requested + interval + MARGIN,
                _ => began,
            };
            // Nothing is asked before now: where the deadline has passed meanwhile, nothing is asked any more.
            let at = fresh.max(not_before + reach).max(Instant::now());
            let late = at + GUARD + MARGIN > deadline;
            if late && awake::missed(deadline) && !patience.is_zero() {
                // Nobody waited for the meter meanwhile; what it said before may be of another light.
                deadline = Instant::now() + patience;
                self.forget();
                continue;
            }
            if let Some(reading) = disagreed.take_if(|_| late || exchanges >= MOST_EXCHANGES) {
                return Ok(reading);
            }
            if late {
                sleep_until(deadline).await;
                let (waited, received) = (began.elapsed(), Vec::new());
                return Err(BusError::Timeout { waited, received }.during(&meter.link.name, "read"));
            }
            let tried = if self.in_doubt {
                // The meter answers in order: an answer of another kind proves that no reading is still on its way.
                let Some(proved) = awake::until(deadline, meter.language.put_in_step(&meter.link, deadline)).await
                else {
                    continue;
                };
                if proved.is_ok() {
                    self.in_doubt = false;
                    self.unsolicited = meter.link.bus.unsolicited();
                }
                proved.map(|()| None)
            } else {
                sleep_until(at).await;
                // Bytes that came while nothing was asked: the line is not in step with the requests.
                if self.surplus(meter) {
                    continue;
                }
                self.exchange(meter, deadline).await.map(Some)
            };
            let error = match tried {
                Ok(None) => continue,
                Ok(Some(exchange)) => {
                    exchanges += 1;
                    // Those before count if their light, too, fell after `not_before`.
                    self.earlier.retain(|before| before.requested >= not_before + reach);
                    let confirmed_by = exchange.confirmed(&self.earlier).map(|by| by.reading.outcome);
                    let (alone, mut reading) = (self.earlier.is_empty(), exchange.reading.clone());
                    reading.retries = damaged;
                    self.earlier.push(exchange);
                    if self.earlier.len() > 2 {
                        self.earlier.remove(0);
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
            self.earlier.clear();
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
