//! What the engine tells while it works.

use isolux_record::Reading;
use isolux_record::spectra::SpectrumRecord;

use crate::bench_state::BenchState;
use crate::warmup::{Criterion, Power};

/// One thing that happened in a scan.
#[derive(Debug, Clone, PartialEq)]
pub enum ScanEvent<'a> {
    /// The axes are being homed.
    Homing,
    /// The lamp is watched until it is stable.
    WarmUpBegan {
        /// When it counts as stable.
        criterion: &'a Criterion,
    },
    /// A look at the lamp during warm-up.
    WarmUp {
        /// Seconds since the lamp was switched on.
        elapsed_s: f64,
        /// Illuminance at the reference point.
        illuminance_lx: f64,
        /// (max − min) ÷ mean over the window, once it is full.
        spread_rel: Option<f64>,
        /// The power; none without a power meter.
        power: Option<Power>,
    },
    /// The lamp is stable.
    WarmUpEnded {
        /// Seconds since the lamp was switched on.
        elapsed_s: f64,
        /// (max − min) ÷ mean over the window.
        spread_rel: f64,
    },
    /// A block begins.
    Block {
        /// Its name.
        name: &'a str,
        /// Points of the plan done so far.
        done: u64,
        /// Points of the plan.
        total: u64,
    },
    /// A reading was recorded.
    Reading {
        /// The reading.
        reading: &'a Reading,
        /// Points of the plan done so far.
        done: u64,
        /// Points of the plan.
        total: u64,
    },
    /// A spectrum was recorded.
    Spectrum {
        /// Its number.
        index: u64,
        /// What was read.
        record: &'a SpectrumRecord,
    },
    /// The scan pauses: both axes were stopped and verified at rest.
    Paused {
        /// Who asked for it.
        by: &'a str,
        /// Where C rests.
        c_deg: f64,
        /// Where γ rests.
        gamma_deg: f64,
        /// Whether the lamp burns on.
        lamp_is_on: bool,
    },
    /// The scan goes on.
    Resumed {
        /// Who asked for it.
        by: &'a str,
        /// How long it was paused.
        paused_s: f64,
    },
    /// The program did not run for a time: the process was stopped, or the computer slept. The axes were stopped and
    /// asked where they are; the lamp is proved at the reference point before the next lit visit.
    Slept {
        /// For how long.
        slept_s: f64,
        /// Where C rests.
        c_deg: f64,
        /// Where γ rests.
        gamma_deg: f64,
    },
    /// The scan has ended, and so it leaves the bench.
    Ended(&'a BenchState),
    /// A call was repeated, a reading did not settle, somebody was asked: a sentence.
    Note(&'a str),
}

/// Receives the events of a scan.
pub trait Observer {
    /// Takes one event. Must not block for long.
    fn event(&self, event: &ScanEvent<'_>);
}

/// Discards every event.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _: &ScanEvent<'_>) {}
}
