//! A station file as it is written, table by table.

use camino::Utf8PathBuf;
use serde::{Deserialize, Serialize};

use super::luxmeter::LuxMeter;
use super::ratio::Ratio;

/// A station file as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationDocument {
    /// [`FORMAT`](super::FORMAT).
    pub format: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// A `darkroom.toml` beside this file: the room behind links that begin with `memory:`. Without it the built-in
    /// one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub darkroom: Option<Utf8PathBuf>,
    /// Geometry.
    pub bench: Bench,
    /// The two axes.
    pub axis: Axes,
    /// The lux meter.
    pub luxmeter: LuxMeter,
    /// The spectroradiometer, if the bench has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectroradiometer: Option<Spectroradiometer>,
    /// The power meter in the lamp's supply line, if the bench has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub powermeter: Option<PowerMeter>,
    /// The supply that feeds the lamp and switches it, if the bench has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
    /// How the lamp is switched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp: Option<Lamp>,
    /// How the detector is capped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shutter: Option<Access>,
    /// How the direct path is blocked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baffle: Option<Access>,
    /// How the detector is set to another distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rail: Option<Rail>,
    /// The thermometer of the room.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<Access>,
}

/// Geometry of the bench.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bench {
    /// Type of goniophotometer.
    #[serde(rename = "type")]
    pub kind: BenchType,
    /// Intersection of the axes to the detector's reference plane.
    pub distance_mm: f64,
    /// Standard uncertainty of the distance (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_distance_mm: Option<f64>,
    /// Standard uncertainty of γ (k = 1), the same for all readings: zero of the axis and mounting of the luminaire.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_gamma_deg: Option<f64>,
    /// Height of the axes above the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor_mm: Option<f64>,
    /// Bound of the light of the lamp that does not come straight from it: the largest illuminance of it at
    /// `distance_mm`, over all directions of the lamp, ÷ the largest illuminance of the direct light there. For
    /// readings without a baffled block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stray_max_rel: Option<f64>,
    /// Bound of the illuminance at the detector with the lamp off. For readings without a lamp_off block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient_max_lx: Option<f64>,
    /// Bound of what the meter shows when it is capped, either sign. For readings without a capped block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dark_max_lx: Option<f64>,
}

/// Types of goniophotometer that are built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BenchType {
    /// The luminaire turns about both axes, the detector stands still.
    TurningLuminaire,
}

/// Both axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Turns the luminaire about its own optical axis.
    pub c: Axis,
    /// Turns the optical axis away from the detector.
    pub gamma: Axis,
}

/// One axis: angle = zero_deg + sense × counts ÷ counts_per_deg.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// `driver:target`.
    pub open: String,
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Counts of the drive per degree, a ratio so that no error accumulates.
    pub counts_per_deg: Ratio,
    /// The angle at which the drive counts zero.
    pub zero_deg: f64,
    /// +1 or −1: whether the angle rises with the counts.
    pub sense: i8,
    /// Smallest and largest angle that may be driven to.
    pub limit_deg: [f64; 2],
    /// Speed of a move.
    pub speed_deg_s: f64,
    /// Acceleration of a move.
    pub accel_deg_s2: f64,
    /// How far from the target an axis at rest may stand; without it one and a half counts, at least 0.01°.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tolerance_deg: Option<f64>,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day of the calibration, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
}

impl Axis {
    /// How far from its target the axis at rest may stand, in degrees.
    pub fn tolerance_deg(&self) -> f64 {
        self.tolerance_deg
            .unwrap_or_else(|| (1.5 / self.counts_per_deg.as_f64()).max(0.01))
    }
}

/// The spectroradiometer, fixed on the axis at its own distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spectroradiometer {
    /// `driver:target`.
    pub open: String,
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Intersection of the axes to its reference plane.
    pub distance_mm: f64,
    /// Standard uncertainty of that distance (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_distance_mm: Option<f64>,
    /// `device` for the factors stored in the instrument, or a CSV of `wavelength_nm,factor` beside the station.
    pub calibration: String,
    /// Its wavelength scale and bandpass, a file beside the station; without it the instrument's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelengths: Option<String>,
    /// The light that it scatters inside, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter: Option<String>,
    /// What is left of its non-linearity, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linearity: Option<String>,
    /// Relative standard uncertainty of the irradiance calibration (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rel: Option<f64>,
    /// Relative standard uncertainty of the ratio of the calibration at 700 nm to that at 400 nm (k = 1): its spectral
    /// shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_shape_rel: Option<f64>,
    /// Standard uncertainty of the wavelength scale (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_wavelength_nm: Option<f64>,
    /// Bound of the light that reaches it otherwise than straight from the lamp, ÷ the direct light on the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stray_max_rel: Option<f64>,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day of the calibration, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
}

/// The power meter in the lamp's supply line. Its uncertainties are of a reading at the level of the lamp: gain and
/// range.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PowerMeter {
    /// `driver:target`.
    pub open: String,
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Relative standard uncertainty of the voltage (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_voltage_rel: Option<f64>,
    /// Relative standard uncertainty of the current (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_current_rel: Option<f64>,
    /// Relative standard uncertainty of the active power (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_power_rel: Option<f64>,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day of the calibration, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
}

/// The supply that feeds the lamp: its levels are in its address.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Supply {
    /// `driver:target`.
    pub open: String,
}

/// The lamp's switch and size. On a bench with a supply that is the switch, and here there is neither `open` nor
/// `prompt`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// `driver:target`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<String>,
    /// What a person is asked to do instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prompt: Option<String>,
    /// Largest extent of the luminous area: decides the distance class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diameter_mm: Option<f64>,
    /// Estimate of the luminous flux, from a data sheet or an earlier run: only `isolux plan` uses it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flux_lm: Option<f64>,
    /// Estimate of the largest luminous intensity, for `isolux plan` too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_cd: Option<f64>,
    /// When the lamp counts as stable; without it EN 13032-4: 30 min on, then 0.5 % over 15 min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stable: Option<Stable>,
}

/// Stabilisation of the lamp: on for at least `least_s`, and (max − min)/mean over the last `window_s` below
/// `spread_rel`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stable {
    /// Least time on.
    pub least_s: f64,
    /// Length of the window.
    pub window_s: f64,
    /// Allowed relative spread over it.
    pub spread_rel: f64,
}

/// The detector's carriage: a linear axis, or a person who is asked. Distance = zero_mm + sense × counts ÷
/// counts_per_mm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rail {
    /// `driver:target`; then the five keys of a linear axis are needed too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<String>,
    /// What a person is asked to do instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prompt: Option<String>,
    /// Counts of the drive per millimetre.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts_per_mm: Option<Ratio>,
    /// The distance at which the drive counts zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero_mm: Option<f64>,
    /// +1 or −1: whether the distance rises with the counts; without it +1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sense: Option<i8>,
    /// Smallest and largest distance that may be driven to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_mm: Option<[f64; 2]>,
    /// Speed of a move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_mm_s: Option<f64>,
    /// Acceleration of a move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accel_mm_s2: Option<f64>,
}

/// A rail that is driven, with everything that a linear axis needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenRail<'a> {
    /// `driver:target`.
    pub open: &'a str,
    /// Counts per millimetre.
    pub counts_per_mm: Ratio,
    /// Distance at count zero.
    pub zero_mm: f64,
    /// +1 or −1.
    pub sense: i8,
    /// Smallest and largest distance.
    pub limit_mm: [f64; 2],
    /// Speed.
    pub speed_mm_s: f64,
    /// Acceleration.
    pub accel_mm_s2: f64,
}

impl Rail {
    /// The driven rail; none where a person moves the detector.
    pub fn driven(&self) -> Option<DrivenRail<'_>> {
        Some(DrivenRail {
            open: self.open.as_deref()?,
            counts_per_mm: self.counts_per_mm?,
            zero_mm: self.zero_mm?,
            sense: self.sense.unwrap_or(1),
            limit_mm: self.limit_mm?,
            speed_mm_s: self.speed_mm_s?,
            accel_mm_s2: self.accel_mm_s2?,
        })
    }
}

/// An instrument, or a person who is asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Access {
    /// `driver:target`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<String>,
    /// What a person is asked to do instead.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prompt: Option<String>,
}
