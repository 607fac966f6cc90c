//! The instruments of a room, and what goes wrong on their links.

use serde::{Deserialize, Serialize};

/// One thing that goes wrong on a link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// The instrument that it happens to.
    pub instrument: Instrument,
    /// What happens.
    pub kind: FaultKind,
    /// From when, s after the room was opened.
    #[serde(default)]
    pub at_s: f64,
    /// For how long, s; left out: once (`disconnect`, `stall`: for good).
    pub for_s: Option<f64>,
    /// Delay of a late reply, or of the second of two, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Probability for each reply inside the window.
    #[serde(default = "one")]
    pub probability: f64,
}

fn one() -> f64 {
    1.0
}

/// An instrument of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Instrument {
    /// The axes and the switches on their controller.
    Axes,
    /// The lux meter.
    Luxmeter,
    /// The spectroradiometer.
    Spectroradiometer,
    /// A second controller, for lamp, shutter, baffle, rail and thermometer, where that of the axes has none of them.
    Outputs,
    /// The power meter in the lamp's supply line.
    Powermeter,
    /// The supply that feeds the lamp and switches it.
    Supply,
    /// The oscilloscope with a photodiode that sees the lamp.
    Oscilloscope,
}

impl Instrument {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Axes,
        Self::Luxmeter,
        Self::Spectroradiometer,
        Self::Outputs,
        Self::Powermeter,
        Self::Supply,
        Self::Oscilloscope,
    ];

    /// Its name, as a darkroom's document writes it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axes => "axes",
            Self::Luxmeter => "luxmeter",
            Self::Spectroradiometer => "spectroradiometer",
            Self::Outputs => "outputs",
            Self::Powermeter => "powermeter",
            Self::Supply => "supply",
            Self::Oscilloscope => "oscilloscope",
        }
    }
}

/// What a link can do to a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// One byte of the reply is lost.
    DropByte,
    /// One bit of the reply is turned.
    FlipBit,
    /// One digit of the reply is another one: it still reads as a number.
    WrongDigit,
    /// The reply comes after `delay_s`.
    Late,
    /// The reply comes twice, the second time `delay_s` after the first.
    Double,
    /// The reply never comes.
    Silent,
    /// The link ends.
    Disconnect,
    /// The axis stops short and reports a stall.
    Stall,
    /// The axes' drives stop with an alarm of their own, at once.
    Alarm,
    /// More light falls on the meter than any range can show.
    Saturate,
}
