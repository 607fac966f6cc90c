//! What a scan needs beside the instruments, and what it answers.

use isolux_record::Station;
use jiff::Timestamp;

use crate::awake::Awake;
use crate::devices::Operator;
use crate::observe::Observer;
use crate::pause::Pause;

/// Everything around the instruments that a scan needs to know.
pub struct Engine<'a> {
    /// The bench.
    pub station: &'a Station,
    /// The person beside it.
    pub operator: &'a dyn Operator,
    /// Asks for pauses.
    pub pause: &'a Pause,
    /// Is told what happens.
    pub observer: &'a dyn Observer,
    /// Notices where the program did not run.
    pub awake: &'a Awake,
    /// UTC now, by which the run counts from here on.
    pub now_utc: Timestamp,
    /// The computer's clock, where the run goes on as fast as it does: setting it changes no time of the run, and is
    /// recorded.
    pub wall_clock: Option<&'a dyn Fn() -> Timestamp>,
}

/// What a finished scan did.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ScanSummary {
    /// Points of the plan.
    pub points: u64,
    /// Readings recorded in this session.
    pub readings: u64,
    /// Spectra recorded in this session.
    pub spectra: u64,
    /// Readings without a number: over or under range, failed.
    pub without_number: u64,
    /// Points whose light did not settle.
    pub unsettled: u64,
    /// Answers that were lost or damaged and asked again.
    pub retries: u64,
    /// Visits that were made again: an axis or an output was not as it was left, or readings did not agree.
    pub visits_again: u64,
    /// How long it took.
    pub duration_s: f64,
    /// Seconds until the lamp was stable, where it was warmed up.
    pub warm_up_s: Option<f64>,
}
