//! Requests to a power meter and their answers, and what two of them say together.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{DeviceError, PowerReading, Quantity, awake};
use isolux_protocol_scpi::Reading;
use isolux_transport::{BusError, TRIES, worth_another_try};
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep_until};

/// Over and above the update interval between two requests: the meter's clock is not this one.
const MARGIN: Duration = Duration::from_millis(50);

/// The true answer to a request that an old one seemed to answer has come within this.
pub(crate) const GUARD: Duration = Duration::from_millis(100);

/// Two readings agree when each quantity differs by no more than this share, or by two of its last digits.
const AGREEMENT: f64 = 0.005;

/// Exchanges of one reading within which two in a row must agree.
const MOST_EXCHANGES: usize = 12;

/// The quantities of a reading, in its order.
const NAMES: [&str; 4] = ["Voltage", "Current", "Power", "PowerFactor"];

/// A request and its answer.
pub(crate) struct Exchange {
    requested: Instant,
    reading: PowerReading,
    /// Last digits of the quantities.
    steps: [f64; 4],
}

impl Exchange {
    /// What was answered at `ended` to a request that was sent at `requested`: voltage, current, power and power
    /// factor, as the meter gave them.
    ///
    /// # Errors
    /// Why these values cannot be of one moment.
    pub fn of(
        values: [Reading; 4],
        (requested, ended): (Instant, Instant),
        update: Duration,
        evidence: Vec<u8>,
    ) -> Result<Self, String> {
        let mut quantities = [Quantity::NoData; 4];
        let mut steps = [0.0; 4];
        for (((quantity, step), name), value) in quantities.iter_mut().zip(&mut steps).zip(NAMES).zip(values) {
            *quantity = match value {
                Reading::Value(number) => {
                    *step = number.step;
                    Quantity::Measured(number.value)
                }
                Reading::NoData => Quantity::NoData,
                Reading::OverRange => Quantity::OverRange,
                Reading::Unusable(text) => return Err(format!("\"{text}\" is no value of {name}")),
            };
        }
        possible(quantities, steps)?;
        let [voltage, current, power, power_factor] = quantities;
        Ok(Self {
            requested,
            steps,
            reading: PowerReading {
                voltage,
                current,
                power,
                power_factor,
                began: requested.checked_sub(update).unwrap_or(requested),
                ended,
                steady: false,
                retries: 0,
                evidence,
            },
        })
    }

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

/// Refuses values that belong to different quantities: |P| is never above U·I, and λ is P ÷ (U·I).
fn possible(quantities: [Quantity; 4], steps: [f64; 4]) -> Result<(), String> {
    let [Some(voltage), Some(current), Some(power), factor] = quantities.map(Quantity::value) else {
        return Ok(());
    };
    // Near nothing the noise of the meter decides.
    let apparent = (voltage * current).abs();
    let doubt = 0.01 * apparent + voltage.abs() * 2.0 * steps[1] + current.abs() * 2.0 * steps[0] + 2.0 * steps[2];
    if let Some(factor) = factor
        && ((factor.abs() > 1.0 + 2.0 * steps[3])
            || (apparent > 20.0 * doubt && (factor.abs() * apparent - power.abs()).abs() > 0.02 * apparent + doubt))
    {
        return Err(format!(
            "a power factor of {factor} with {power} W, {voltage} V and {current} A cannot be"
        ));
    }
    if power.abs() > apparent + doubt {
        return Err(format!("{power} W from {voltage} V and {current} A cannot be"));
    }
    Ok(())
}

/// A power meter that answers one request.
#[async_trait]
pub(crate) trait Source: Send + Sync {
    /// Driver and target.
    fn name(&self) -> &str;

    /// What is asked, for messages.
    fn query(&self) -> &str;

    /// A new value appears this often.
    fn update(&self) -> Duration;

    /// One reading asked for and answered, once.
    async fn exchange(&self, deadline: Instant) -> Result<Exchange, DeviceError>;

    /// Lets whatever was on its way come, after an answer that was lost or damaged.
    async fn put_in_step(&self) -> Result<(), DeviceError>;
}

/// A reading of nothing from before `not_before`: two exchanges, more than an update apart, that agree; without
/// agreement the last one, not steady. `requested` is when the last reading was asked for.
pub(crate) async fn confirmed(
    source: &dyn Source,
    requested: &Mutex<Option<Instant>>,
    not_before: Instant,
    mut deadline: Instant,
) -> Result<PowerReading, DeviceError> {
    let began = Instant::now();
    let patience = deadline.saturating_duration_since(began);
    let mut requested = requested.lock().await;
    let (mut retries, mut exchanges) = (0, 0);
    let mut before: Option<Exchange> = None;
    loop {
        let fresh = requested.map_or(began, |requested| requested + source.update() + MARGIN);
        let at = fresh.max(not_before + source.update());
        if at + GUARD + MARGIN > deadline && awake::missed(deadline) && !patience.is_zero() {
            // Nobody waited for the meter meanwhile.
            deadline = Instant::now() + patience;
            before = None;
        }
        let late = at + GUARD + MARGIN > deadline || exchanges >= MOST_EXCHANGES;
        if late && let Some(before) = before.take() {
            return Ok(before.reading);
        }
        if late {
            sleep_until(deadline).await;
            let (waited, received) = (began.elapsed(), Vec::new());
            return Err(BusError::Timeout { waited, received }.during(source.name(), source.query()));
        }
        sleep_until(at).await;
        *requested = Some(Instant::now());
        match source.exchange(deadline).await {
            Ok(mut exchange) => {
                exchanges += 1;
                *requested = Some(exchange.requested);
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
                source.put_in_step().await?;
            }
        }
    }
}
