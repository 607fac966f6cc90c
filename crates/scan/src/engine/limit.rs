//! The reference point at a limit of the plan: the scan waits for a stable lamp, reads it again and says what it found.

use isolux_record::Event;
use tokio::time::Instant;

use super::session::Session;
use super::taken::Taken;
use crate::clock::microseconds;
use crate::error::ScanError;

/// A lamp that is waited for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Waiting {
    since_s: f64,
}

impl Session<'_> {
    /// The next visit begins with a warm-up: the lamp is watched at the reference point until it is stable again. `why`
    /// is the limit that was reached, with its numbers.
    pub(super) fn wait_for_lamp(&mut self, why: &str) -> Result<Waiting, ScanError> {
        let now = Instant::now();
        self.event(Event::LampOutsideBand {
            time_s: self.time_s(now),
            reason: why.to_owned(),
        })?;
        self.note(&format!("the scan waits until the lamp is stable again: {why}"))?;
        self.warm = false;
        let since_s = self.clock.seconds(now);
        Ok(Waiting { since_s })
    }

    /// After the wait the reference point gives what it should.
    pub(super) fn lamp_is_back(&mut self, waiting: Waiting, taken: &Taken) -> Result<(), ScanError> {
        let Taken::Readings(readings) = taken else {
            return Ok(());
        };
        let Some(reading) = readings.first() else { return Ok(()) };
        let waited_s = microseconds(self.clock.seconds(Instant::now()) - waiting.since_s);
        let (found_lx, time_s) = (reading.illuminance_lx, reading.time_s);
        self.event(Event::LampInsideBand {
            time_s,
            found_lx,
            waited_s,
        })?;
        let found = found_lx.map_or_else(|| "no number".to_owned(), |lux| format!("{lux:.3} lx"));
        self.note(&format!(
            "the lamp is stable after {waited_s:.0} s and the reference point gives {found}, within the limits: the scan goes on"
        ))
    }
}
