//! Reading light: trusted only when consecutive readings agree.

use std::time::Duration;

use isolux_device::{DeviceError, LuxMeter, LuxOutcome, LuxReading, awake};
use tokio::time::Instant;

use crate::error::ScanError;

/// Readings within which two consecutive ones must agree.
const MOST_READINGS: u32 = 20;

/// What scatter of consecutive readings is noise and no settling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of one reading, relative to it.
    pub relative: f64,
    /// Standard deviation of one reading near zero, in lx.
    pub absolute_lx: f64,
}

impl Noise {
    /// Assumed until the warm-up has measured it: half a percent.
    pub const UNKNOWN: Self = Self {
        relative: 5e-3,
        absolute_lx: 0.0,
    };

    /// Standard uncertainty of one reading of `illuminance_lx` shown in digits of `digit_lx`: its scatter, and the
    /// rectangular distribution of its rounding (half-width digit/2, so digit/√12).
    pub fn u_lx(&self, illuminance_lx: f64, digit_lx: f64) -> f64 {
        let rounding = digit_lx / 12.0_f64.sqrt();
        (self.relative * illuminance_lx).hypot(self.absolute_lx).hypot(rounding)
    }

    fn agree(&self, first: (f64, f64), second: (f64, f64)) -> bool {
        let u = self.u_lx(first.0, first.1).hypot(self.u_lx(second.0, second.1));
        // Two readings one digit apart may be the same light on either side of a rounding step.
        (first.0 - second.0).abs() <= (3.0 * u).max(first.1.max(second.1) * 1.000_001)
    }
}

/// One settled visit: the reading to record first, and whether it may be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct Settled {
    /// The later of the two readings that agree; the last one taken where none agreed.
    pub reading: LuxReading,
    /// Whether two consecutive readings agreed.
    pub stable: bool,
}

/// A meter with the patience and the suspicion that a scan needs.
pub struct Photometer<'a> {
    meter: &'a dyn LuxMeter,
    /// Scatter of its readings.
    pub noise: Noise,
    /// Replies that were lost or damaged so far.
    pub retries: u64,
}

impl<'a> Photometer<'a> {
    /// `meter`, with noise that is not known yet.
    pub fn new(meter: &'a dyn LuxMeter) -> Self {
        Self {
            meter,
            noise: Noise::UNKNOWN,
            retries: 0,
        }
    }

    /// One new reading of light after `not_before`. The driver asks again when an answer is lost or damaged.
    ///
    /// # Errors
    /// [`ScanError::Device`] when it stays lost, or the meter is at fault.
    pub async fn read(&mut self, not_before: Instant) -> Result<LuxReading, ScanError> {
        let properties = self.meter.properties();
        let patience = 10 * (properties.update_interval + properties.integration) + Duration::from_secs(5);
        let deadline = Instant::now().max(not_before) + patience;
        let answer = awake::until(deadline + Duration::from_secs(2), self.meter.read(not_before, deadline)).await;
        let source = match answer {
            Some(Ok(reading)) => {
                self.retries += u64::from(reading.retries);
                return Ok(reading);
            }
            Some(Err(error)) => error,
            None => DeviceError::Timeout {
                device: self.meter.identity().target.clone(),
                action: "read".to_owned(),
                waited: patience,
                received: Vec::new(),
            },
        };
        Err(ScanError::Device {
            role: "luxmeter",
            source,
        })
    }

    /// The error for light of which no reading could be confirmed where a number is needed.
    pub(crate) fn unsteady(&self) -> ScanError {
        ScanError::Device {
            role: "luxmeter",
            source: DeviceError::Fault {
                device: self.meter.identity().target.clone(),
                action: "read".to_owned(),
                reason: "no two answers in a row agree: the light changes, or the link damages or delays answers"
                    .to_owned(),
                evidence: Vec::new(),
            },
        }
    }
}

/// The readings of one visit until two in a row agree within noise and digit. Out of range twice is agreement too: more
/// readings would say the same. The exchange by which a driver confirmed the first reading is the first of two; light
/// that the driver found unsteady does not settle.
#[derive(Debug, Default)]
pub struct Settling {
    before: Option<LuxReading>,
    taken: u32,
}

impl Settling {
    /// Takes the next reading; the visit's first reading once it is known.
    pub fn add(&mut self, reading: LuxReading, noise: &Noise) -> Option<Settled> {
        self.taken += 1;
        let before = match &self.before {
            Some(before) => Some((before.outcome, before.digit.value())),
            None => reading.confirmed_by.map(|earlier| (earlier, reading.digit.value())),
        };
        let stable = before.is_some_and(|before| agree(noise, before, &reading));
        if stable || self.taken >= MOST_READINGS || reading.outcome == LuxOutcome::Unsteady {
            return Some(Settled { reading, stable });
        }
        self.before = Some(reading);
        None
    }
}

fn agree(noise: &Noise, (before, digit_lx): (LuxOutcome, f64), reading: &LuxReading) -> bool {
    match (before, reading.outcome) {
        (LuxOutcome::Measured(a), LuxOutcome::Measured(b)) => {
            noise.agree((a.value(), digit_lx), (b.value(), reading.digit.value()))
        }
        (LuxOutcome::Unsteady, _) => false,
        (a, b) => a == b,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_rectangular_and_one_digit_is_no_disagreement() {
        let noise = Noise {
            relative: 0.001,
            absolute_lx: 0.0,
        };
        assert!((noise.u_lx(0.0, 0.01) - 0.01 / 12.0_f64.sqrt()).abs() < 1e-15);
        assert!(noise.agree((3.37, 0.01), (3.38, 0.01)));
        assert!(!noise.agree((3.37, 0.01), (3.40, 0.01)));
        assert!(noise.agree((1000.0, 0.1), (1003.0, 0.1)));
        assert!(!noise.agree((1000.0, 0.1), (1006.0, 0.1)));
    }
}
