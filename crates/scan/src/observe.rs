//! What the engine tells while it works.

use isolux_record::Reading;

/// One thing that happened in a scan.
#[derive(Debug, Clone, PartialEq)]
pub enum ScanEvent<'a> {
    /// The axes are being homed.
    Homing,
    /// The lamp was switched on; the gate opens `least_s` seconds later at the earliest.
    WarmUpBegan {
        /// Least time.
        least_s: f64,
    },
    /// A look at the lamp during warm-up.
    WarmUp {
        /// Seconds since the lamp was switched on.
        elapsed_s: f64,
        /// Illuminance at the reference point.
        illuminance_lx: f64,
        /// (max − min) ÷ mean over the window, once it is full.
        spread_rel: Option<f64>,
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
    },
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
