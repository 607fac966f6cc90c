//! One reading of the lux meter, with the pose that was read back and everything needed to judge it later.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What the detector could see while it was read. Decides which parts of a prediction apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadingKind {
    /// Lamp on, nothing in the way.
    Lit,
    /// Lamp on, the direct path blocked: lamp-made stray light + ambient + offset.
    Baffled,
    /// Lamp off: ambient + offset.
    LampOff,
    /// Detector capped: offset only.
    Capped,
}

impl ReadingKind {
    /// All kinds, in the order of the documentation.
    pub const ALL: [Self; 4] = [Self::Lit, Self::Baffled, Self::LampOff, Self::Capped];

    /// The word in files.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Lit => "lit",
            Self::Baffled => "baffled",
            Self::LampOff => "lamp_off",
            Self::Capped => "capped",
        }
    }

    /// Whether the lamp must be on for such a reading. A capped detector does not care.
    pub const fn needs_lamp(self) -> bool {
        matches!(self, Self::Lit | Self::Baffled)
    }
}

/// What a reading is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// A number to use.
    Ok,
    /// The meter was over its range: there is no number.
    OverRange,
    /// The meter was under its range: there is no number.
    UnderRange,
    /// The meter answered with a fault, or not at all: there is no number.
    Failed,
}

impl Quality {
    /// The word in files.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::OverRange => "over_range",
            Self::UnderRange => "under_range",
            Self::Failed => "failed",
        }
    }
}

/// A word in a file that names no kind, quality or role.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{found}` is none of {expected}")]
pub struct UnknownWord {
    /// The word found.
    pub found: String,
    /// The words that are known.
    pub expected: &'static str,
}

impl FromStr for ReadingKind {
    type Err = UnknownWord;
    fn from_str(word: &str) -> Result<Self, UnknownWord> {
        Ok(match word {
            "lit" => Self::Lit,
            "baffled" => Self::Baffled,
            "lamp_off" => Self::LampOff,
            "capped" => Self::Capped,
            _ => {
                return Err(UnknownWord {
                    found: word.to_owned(),
                    expected: "lit, baffled, lamp_off, capped",
                });
            }
        })
    }
}

impl FromStr for Quality {
    type Err = UnknownWord;
    fn from_str(word: &str) -> Result<Self, UnknownWord> {
        Ok(match word {
            "ok" => Self::Ok,
            "over_range" => Self::OverRange,
            "under_range" => Self::UnderRange,
            "failed" => Self::Failed,
            _ => {
                return Err(UnknownWord {
                    found: word.to_owned(),
                    expected: "ok, over_range, under_range, failed",
                });
            }
        })
    }
}

/// Why the engine took a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// A point of the plan.
    Point,
    /// A visit to the reference point (C 0°, γ 0°): drift.
    Reference,
    /// A direction of a block of sweeps that is read at rest afterwards: whether the sweeps say the same.
    Check,
}

impl Role {
    /// The word in files.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Reference => "reference",
            Self::Check => "check",
        }
    }
}

impl FromStr for Role {
    type Err = UnknownWord;
    fn from_str(word: &str) -> Result<Self, UnknownWord> {
        Ok(match word {
            "point" => Self::Point,
            "reference" => Self::Reference,
            "check" => Self::Check,
            _ => {
                return Err(UnknownWord {
                    found: word.to_owned(),
                    expected: "point, reference, check",
                });
            }
        })
    }
}

macro_rules! shown_as_in_files {
    ($($name:ident),*) => {$(
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.as_str())
            }
        }
    )*};
}
shown_as_in_files!(ReadingKind, Quality, Role);

/// The lamp's supply line during a reading, as the power meter gave it: each where it gave a number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Electrical {
    /// RMS voltage (mean for DC).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voltage_v: Option<f64>,
    /// RMS current (mean for DC).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_a: Option<f64>,
    /// Active power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_w: Option<f64>,
    /// Active power ÷ (voltage · current).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_factor: Option<f64>,
}

/// One row of `readings.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// Number of the row, from 0, without gaps.
    pub index: u64,
    /// Name of the plan's block.
    pub block: String,
    /// What the detector could see.
    pub kind: ReadingKind,
    /// Middle of the integration in seconds since the run began, on one axis over all its sessions.
    pub time_s: Option<f64>,
    /// Read-back C in degrees.
    pub c_deg: f64,
    /// Read-back γ in degrees, signed.
    pub gamma_deg: f64,
    /// Distance from the intersection of the axes to the detector's reference plane.
    pub distance_mm: f64,
    /// Sign of the last non-zero γ motion, held through C moves and repeats; 0: none yet or not known.
    pub travel: i8,
    /// The meter's range.
    pub range: i32,
    /// Temperature of the room in °C, where it is measured.
    pub ambient_c: Option<f64>,
    /// The illuminance; present exactly when `quality` is [`Quality::Ok`]. May be negative.
    pub illuminance_lx: Option<f64>,
    /// Stated standard uncertainty of this one reading (k = 1).
    pub u_lx: Option<f64>,
    /// What the reading is worth.
    pub quality: Quality,
    /// Why it was taken.
    pub role: Role,
    /// Number of the point in the plan (over all blocks, from 0), so that a scan can be resumed.
    pub point: u64,
    /// Number of the repeat at this visit, from 0.
    pub repeat: u32,
    /// C that the plan asked for.
    pub c_target_deg: f64,
    /// γ that the plan asked for.
    pub gamma_target_deg: f64,
    /// One digit of the display at this range.
    pub digit_lx: Option<f64>,
    /// Integration time.
    pub integration_s: Option<f64>,
    /// The bytes that the meter sent, in hexadecimal, where the driver keeps them.
    pub raw: String,
    /// Number of the session at the bench in which it was taken, from 0; set by the record.
    pub session: u32,
    /// How often the lamp had been switched on in this run; set by the record.
    pub burning: Option<u32>,
    /// Middle of the integration in seconds since the lamp was last switched on; none before that.
    pub lamp_s: Option<f64>,
    /// The lamp's supply line meanwhile; empty without a power meter.
    pub electrical: Electrical,
}

impl Reading {
    /// For how long the lamp had been on, in seconds: since it was switched on where that is known, else since the run
    /// began; none where neither is known.
    pub fn lamp_age_s(&self) -> Option<f64> {
        self.lamp_s.or(self.time_s)
    }
}
