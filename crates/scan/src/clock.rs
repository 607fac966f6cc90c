//! Seconds of the run and UTC, both from the one clock that a test can pause. The clock on the wall is asked once, at
//! the start: whoever sets it during the run changes no time of the record.

use jiff::Timestamp;
use tokio::time::Instant;

use crate::awake::Awake;

/// Ties [`Instant`]s to the seconds of a run and to UTC. Made once at the start of a session.
#[derive(Clone)]
pub struct RunClock {
    start: Instant,
    start_utc: Timestamp,
    start_s: f64,
    awake: Awake,
}

impl RunClock {
    /// A clock that reads `start_utc` now, `start_s` seconds after the run began, and counts what passed while the
    /// computer slept.
    pub fn starting(start_utc: Timestamp, start_s: f64, awake: &Awake) -> Self {
        Self {
            start: Instant::now(),
            start_utc,
            start_s,
            awake: awake.clone(),
        }
    }

    /// Seconds from the start of the run to `at`.
    pub fn seconds(&self, at: Instant) -> f64 {
        self.start_s + self.session_seconds(at)
    }

    /// Seconds from the start of this session to `at`; negative before it.
    pub fn session_seconds(&self, at: Instant) -> f64 {
        match at.checked_duration_since(self.start) {
            Some(after) => (after + self.awake.suspended_before(at)).as_secs_f64(),
            None => -self.start.duration_since(at).as_secs_f64(),
        }
    }

    /// UTC of `at`, RFC 3339.
    pub fn utc(&self, at: Instant) -> String {
        let nanoseconds = (self.session_seconds(at) * 1e9).round();
        let span = jiff::SignedDuration::from_nanos(nanoseconds as i64);
        self.start_utc.checked_add(span).unwrap_or(self.start_utc).to_string()
    }

    /// UTC of now, RFC 3339.
    pub fn utc_now(&self) -> String {
        self.utc(Instant::now())
    }

    /// Seconds from the start of the run to a UTC that was written earlier; none if it is no time.
    pub fn seconds_of_utc(&self, utc: &str) -> Option<f64> {
        let at: Timestamp = utc.parse().ok()?;
        Some(self.start_s + at.duration_since(self.start_utc).as_secs_f64())
    }
}

/// Rounds to the microsecond: finer times are noise of the scheduler and only lengthen the record.
pub(crate) fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}
