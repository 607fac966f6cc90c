//! What happens while a run is made. The engine emits it, events.jsonl holds it, the screens show it, and whoever reads
//! the run gets it back.

use std::fmt;

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

use crate::reading::Reading;
use crate::spectra::SpectrumRecord;

/// The file in a run directory, one event a line.
pub const EVENTS_FILE: &str = "events.jsonl";

/// An event and when it happened, by the clock of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Logged {
    /// UTC, RFC 3339.
    pub time_utc: String,
    /// What happened.
    #[serde(flatten)]
    pub event: Event,
}

/// How a run ended, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopHow {
    /// Every point of the plan was read.
    Completed,
    /// A person or a signal asked for it.
    Interrupted,
    /// An instrument or the system failed.
    Failed,
}

impl fmt::Display for StopHow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Completed => "completed",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        })
    }
}

/// One thing that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// A session at the bench begins: the axes search their reference.
    Began {
        /// Points of the plan.
        points: u64,
        /// Whether an earlier session has read some of them.
        resumed: bool,
    },
    /// Damaged files were set aside: what they held is read again.
    Reread {
        /// What is damaged, one sentence each.
        damage: Vec<String>,
        /// Number of the first row that follows.
        first_row: u64,
    },
    /// Instruments or the run directory were taken from a process that did not answer.
    TakenOver {
        /// Why, as a person said.
        reason: String,
        /// From whom.
        from: Vec<String>,
    },
    /// The axes have found their reference.
    Homed {},
    /// The rail has brought the detector here.
    Rail {
        /// As read back.
        distance_mm: f64,
    },
    /// The lamp was switched.
    Lamp {
        /// Whether it is on now.
        on: bool,
    },
    /// The shutter was moved.
    Shutter {
        /// Whether it is open now.
        on: bool,
    },
    /// The baffle was moved.
    Baffle {
        /// Whether it is in the beam now.
        on: bool,
    },
    /// A person was asked to do something.
    Asked {
        /// What.
        prompt: String,
        /// Where the detector has to be.
        distance_mm: f64,
        /// Who has done it.
        who: Option<String>,
        /// Why nobody has.
        declined: Option<String>,
    },
    /// The lamp was looked at during its warm-up.
    WarmUp(WarmUp),
    /// The lamp is stable.
    Stable {
        /// Seconds since it was switched on.
        #[serde(alias = "time_s")]
        lamp_s: f64,
        /// (max − min)/mean of the light over the window.
        spread_rel: f64,
        /// Scatter of single readings over the window, relative.
        noise_rel: f64,
    },
    /// A block of the plan begins.
    Block {
        /// Its name.
        name: String,
    },
    /// A reading was recorded; `readings.csv` holds it, `events.jsonl` does not.
    Reading(Box<Reading>),
    /// A spectrum was recorded.
    Spectrum {
        /// Its number.
        index: u64,
        /// Integration time.
        integration_s: f64,
        /// What was read; the file of that number in `spectra/` holds it.
        #[serde(skip)]
        record: Option<Box<SpectrumRecord>>,
    },
    /// A whole sweep was recorded.
    Sweep {
        /// Its number, from 0; the file of that number in `sweeps/` holds it.
        index: u64,
        /// The block.
        block: String,
        /// C from and to, degrees: of a half-plane one and the same.
        c_deg: [f64; 2],
        /// γ from and to, degrees: of a ring one and the same.
        gamma_deg: [f64; 2],
        /// Conversions of the meter.
        conversions: u64,
        /// Positions of the axis.
        positions: u64,
    },
    /// Half-planes of a block of sweeps were chosen.
    HalfPlanes {
        /// The block.
        block: String,
        /// Those that are swept next, degrees.
        c_deg: Vec<f64>,
        /// Why these.
        reason: String,
    },
    /// A part of a half-plane is swept a second time.
    SecondSweep {
        /// The block.
        block: String,
        /// The half-plane, degrees.
        c_deg: f64,
        /// γ from and to, degrees.
        gamma_deg: [f64; 2],
        /// At this speed.
        speed_deg_s: f64,
        /// In this range of the meter; none: in that of the sweeps before.
        range: Option<u8>,
        /// Why.
        reason: String,
    },
    /// Rings show how far the light has the symmetry that half-planes of a block assume.
    Symmetry {
        /// The block.
        block: String,
        /// The symmetry, as words.
        symmetry: String,
        /// The largest difference, in shares of the largest light.
        largest_rel: f64,
        /// There: C, degrees.
        c_deg: f64,
        /// There: γ, degrees.
        gamma_deg: f64,
        /// What the plan allows.
        most_rel: f64,
        /// The narrowest dip of 5 % that would have been seen, degrees of C.
        narrowest_deg: Option<f64>,
    },
    /// A visit or a warm-up is made again.
    Again {
        /// Why.
        reason: String,
    },
    /// The reference point is at a limit of the plan: the scan waits for a stable lamp.
    LampOutsideBand {
        /// Seconds since the run began.
        time_s: f64,
        /// The limit, with its numbers.
        reason: String,
    },
    /// The reference point is within the limits again.
    LampInsideBand {
        /// Seconds since the run began.
        time_s: Option<f64>,
        /// What it gives.
        found_lx: Option<f64>,
        /// How long that took.
        waited_s: f64,
    },
    /// The scan pauses: both axes were stopped and verified at rest.
    Paused {
        /// Who asked for it.
        by: String,
        /// Where C rests.
        c_deg: f64,
        /// Where γ rests.
        gamma_deg: f64,
        /// Whether the lamp stays on.
        lamp_is_on: bool,
        /// Points of the plan done so far.
        points_done: u64,
    },
    /// The scan goes on.
    Resumed {
        /// Who asked for it.
        by: String,
        /// How long it was paused.
        paused_s: f64,
    },
    /// The program did not run for a time: the process was stopped, or the computer slept.
    Slept {
        /// Since when, UTC.
        from_utc: String,
        /// The same in seconds since the run began.
        time_s: f64,
        /// For how long.
        slept_s: f64,
        /// Part of it in which the computer slept.
        suspended_s: f64,
    },
    /// After that the axes were stopped and asked where they are.
    BenchFound {
        /// Where C rests.
        c_deg: f64,
        /// Where γ rests.
        gamma_deg: f64,
        /// Whether an axis had lost its reference.
        homed_again: bool,
    },
    /// Somebody has set the clock of the computer; the times of the run go on as they were.
    ClockSet {
        /// By how much.
        step_s: f64,
        /// How far it is ahead of the run's now.
        ahead_s: f64,
    },
    /// A sentence for the journal.
    Note {
        /// It.
        message: String,
    },
    /// The session has ended, and so it leaves the bench.
    Stopped {
        /// How.
        how: StopHow,
        /// In a sentence.
        message: String,
        /// Whether both axes were verified at rest.
        axes_at_rest: bool,
        /// The bench; none in a record that does not say so.
        #[serde(default)]
        left: Option<BenchState>,
    },
}

/// A look at the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WarmUp {
    /// Seconds since the lamp was switched on.
    #[serde(alias = "time_s")]
    pub lamp_s: f64,
    /// Illuminance at the reference point.
    pub illuminance_lx: f64,
    /// (max − min)/mean over the window, once it is full.
    pub spread_rel: Option<f64>,
    /// The power; none without a power meter.
    #[serde(flatten)]
    pub power: Option<PowerSample>,
}

/// The power at a look at the lamp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PowerSample {
    /// Active power; none where the meter gave no number. A line without the key is of a bench without a power meter.
    #[serde(deserialize_with = "Option::deserialize")]
    pub power_w: Option<f64>,
    /// (max − min)/mean over the window, once it is full and ends with a number.
    pub power_spread_rel: Option<f64>,
}

/// The bench after a scan. What has no instrument, or one that gives no answer, is none.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BenchState {
    /// Position of C in degrees.
    pub c_deg: Option<f64>,
    /// Position of γ in degrees.
    pub gamma_deg: Option<f64>,
    /// Whether both axes were stopped and verified at rest.
    pub axes_at_rest: bool,
    /// Whether the lamp is on.
    pub lamp_is_on: Option<bool>,
    /// Whether the shutter is open.
    pub shutter_is_open: Option<bool>,
    /// Whether the baffle is in the beam.
    pub baffle_is_in: Option<bool>,
}

/// The events of the run directory `run`, as far as they can be read: no number is computed from them. A line that is
/// not whole, and one of an event that this program does not know, are left out.
pub fn read(run: &Utf8Path) -> Vec<Logged> {
    let text = std::fs::read_to_string(run.join(EVENTS_FILE)).unwrap_or_default();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let lines = whole.lines();
    lines.filter_map(|line| serde_json::from_str(line).ok()).collect()
}

impl fmt::Display for BenchState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rest = if self.axes_at_rest {
            "at rest"
        } else {
            "NOT verified at rest"
        };
        write!(f, "axes {rest}")?;
        if let (Some(c_deg), Some(gamma_deg)) = (self.c_deg, self.gamma_deg) {
            // Adding 0 makes −0 and 0 one.
            write!(f, " at C {:.2}°, γ {:.2}°", c_deg + 0.0, gamma_deg + 0.0)?;
        }
        for (what, state, words) in [
            ("lamp", self.lamp_is_on, ["on", "off"]),
            ("shutter", self.shutter_is_open, ["open", "closed"]),
            ("baffle", self.baffle_is_in, ["in the beam", "out of the beam"]),
        ] {
            if let Some(state) = state {
                write!(f, "; {what} {}", words[usize::from(!state)])?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of a run by an earlier program, and what this one makes of it.
    fn read_line(line: &str) -> Logged {
        serde_json::from_str(line).unwrap()
    }

    #[test]
    fn a_line_is_written_as_it_was_read() {
        for line in [
            r#"{"event":"began","points":2275,"resumed":false,"time_utc":"2026-01-01T00:00:00Z"}"#,
            r#"{"event":"homed","time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"lamp","on":true,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"warm_up","illuminance_lx":24.5,"lamp_s":30.25,"spread_rel":null,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"warm_up","illuminance_lx":24.5,"lamp_s":30.25,"power_spread_rel":null,"power_w":10.0,"spread_rel":0.01,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"warm_up","illuminance_lx":24.5,"lamp_s":30.25,"power_spread_rel":0.001,"power_w":null,"spread_rel":0.01,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"stable","lamp_s":1800.5,"noise_rel":0.0002,"spread_rel":0.003,"time_utc":"2026-01-01T00:30:00Z"}"#,
            r#"{"declined":null,"distance_mm":500.0,"event":"asked","prompt":"cap","time_utc":"2026-01-01T00:00:01Z","who":"Ada"}"#,
            r#"{"block":"lit","c_deg":[90.0,90.0],"conversions":231,"event":"sweep","gamma_deg":[180.0,-180.0],"index":4,"positions":1210,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"event":"spectrum","index":0,"integration_s":0.25,"time_utc":"2026-01-01T00:00:01Z"}"#,
            r#"{"axes_at_rest":true,"event":"stopped","how":"completed","left":{"axes_at_rest":true,"baffle_is_in":null,"c_deg":0.0,"gamma_deg":1.5,"lamp_is_on":true,"shutter_is_open":null},"message":"every point of the plan was read","time_utc":"2026-01-01T00:00:01Z"}"#,
        ] {
            let written = serde_json::to_value(read_line(line)).unwrap().to_string();
            assert_eq!(written, line);
        }
    }

    #[test]
    fn lines_of_format_3_are_read() {
        let utc = "\"time_utc\":\"2026-01-01T00:00:01Z\"";
        let look = read_line(&format!(
            r#"{{"event":"warm_up","illuminance_lx":24.5,"spread_rel":null,"time_s":30.25,{utc}}}"#
        ));
        assert!(matches!(look.event, Event::WarmUp(WarmUp { lamp_s, power: _, .. }) if lamp_s == 30.25));
        let stopped = read_line(&format!(
            r#"{{"event":"stopped","how":"interrupted","message":"SIGINT","axes_at_rest":true,{utc}}}"#
        ));
        assert!(matches!(stopped.event, Event::Stopped { left: None, .. }));
    }

    #[test]
    fn what_is_not_known_is_not_said() {
        let state = BenchState {
            c_deg: Some(-0.0),
            gamma_deg: Some(12.5),
            axes_at_rest: true,
            lamp_is_on: Some(true),
            baffle_is_in: Some(false),
            ..BenchState::default()
        };
        assert_eq!(
            state.to_string(),
            "axes at rest at C 0.00°, γ 12.50°; lamp on; baffle out of the beam"
        );
        let dead = BenchState::default();
        assert_eq!(dead.to_string(), "axes NOT verified at rest");
    }
}
