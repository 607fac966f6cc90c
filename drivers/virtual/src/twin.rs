//! What a twin is: an instrument that answers bytes, and what servers and writers of station files know of it.

use isolux_darkroom::{Darkroom, Instrument, Room};
use isolux_transport::LineSettings;

use crate::world::World;

/// A twin, for servers and for the writer of station files.
pub struct TwinKind {
    /// The instrument of the room that it plays.
    pub instrument: Instrument,
    /// The driver that speaks to it: `open = "driver:address…"`.
    pub driver: &'static str,
    /// How its line must be set; asked for otherwise, it is not reached.
    pub line: LineSettings,
    /// The parts of a station that it can be, and what follows its address in their `open`: `("axis.c", "?axis=1")`.
    pub opens: &'static [(&'static str, &'static str)],
    /// How it takes part in a plan that reads while γ moves; none where this axis or meter cannot.
    pub sweeps: Option<InMotion>,
    /// Of a lux meter: its noise without light in that room, lx, where it is not that of the room's meter.
    pub noise_lx: Option<fn(&Darkroom) -> f64>,
    /// Text of the calibration file that its driver needs, `wavelength_nm,factor` in W/(m² nm) for one linear count per
    /// second; none where the instrument keeps its own calibration, and for every instrument but a spectroradiometer.
    pub calibration: Option<fn(&Room) -> String>,
    /// The twin at power-up.
    pub(crate) start: fn(&World) -> Box<dyn Twin>,
}

/// What an instrument does while γ moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum InMotion {
    /// It moves at a speed.
    Moves,
    /// It converts on request, for so many milliseconds with `open` behind its address.
    OnRequest {
        /// What the station has to say for that.
        open: &'static str,
        /// Integration time with it, ms.
        integration_ms: u32,
    },
    /// It converts by a clock of its own, in so many milliseconds.
    ByOwnClock {
        /// From one value to the next, ms.
        update_interval_ms: u32,
    },
}

impl TwinKind {
    /// What follows the address in the `open` of `part`; none where it is no such part.
    pub fn open(&self, part: &str) -> Option<&'static str> {
        self.opens.iter().find(|(name, _)| *name == part).map(|(_, rest)| *rest)
    }
}

/// An instrument that answers bytes.
pub(crate) trait Twin: Send {
    /// Takes one request off the front of `inbox`; `None` if none is complete.
    fn receive(&mut self, inbox: &mut Vec<u8>, world: &mut World, now_s: f64) -> Option<Answer>;

    /// Stops with an alarm of its own, at once. Only what drives axes has one.
    fn alarm(&mut self, _world: &mut World, _now_s: f64) {}

    /// Stops short what moves past `from_s`; true if that has come to pass by `now_s`.
    fn stall(&mut self, _world: &mut World, _from_s: f64, _now_s: f64) -> bool {
        false
    }
}

/// Reads an answer off the room.
pub(crate) type Look = Box<dyn FnOnce(&World) -> Vec<u8> + Send>;

/// An answer and when it is sent, s after the room was opened. No bytes: no answer.
pub(crate) enum Answer {
    /// These bytes.
    At(f64, Vec<u8>),
    /// What the room gives at that time.
    When(f64, Look),
}
