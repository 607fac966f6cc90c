//! `isolux-station/1`: the bench, its axes, its instruments and how to open them.

use std::fmt;
use std::str::FromStr;

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};

use crate::document::{DocumentError, Fault, Source, read_text};

/// Value of `format` in a station file.
pub const FORMAT: &str = "isolux-station/1";

/// A valid station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StationDocument", into = "StationDocument")]
pub struct Station(StationDocument);

/// A station file as written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationDocument {
    /// [`FORMAT`].
    pub format: String,
    /// A name for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// A `darkroom.toml` beside this file: the room behind links that begin with `memory:`. Without it the built-in one.
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
    /// Height of the axes above the floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub floor_mm: Option<f64>,
    /// Bound of the light of the lamp that does not come straight from it: the largest illuminance of it at `distance_mm`,
    /// over all directions of the lamp, ÷ the largest illuminance of the direct light there. For readings without a
    /// baffled block.
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
}

impl Axis {
    /// How far from its target the axis at rest may stand, in degrees.
    pub fn tolerance_deg(&self) -> f64 {
        self.tolerance_deg
            .unwrap_or_else(|| (1.5 / self.counts_per_deg.as_f64()).max(0.01))
    }
}

/// The lux meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LuxMeter {
    /// `driver:target`.
    pub open: String,
    /// Certificate's factor: true illuminance ÷ shown illuminance.
    pub calibration_factor: f64,
    /// Relative standard uncertainty of the calibration (k = 1).
    pub u_rel: f64,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
}

/// The spectroradiometer, fixed on the axis at its own distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spectroradiometer {
    /// `driver:target`.
    pub open: String,
    /// Intersection of the axes to its reference plane.
    pub distance_mm: f64,
    /// Standard uncertainty of that distance (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_distance_mm: Option<f64>,
    /// `device` for the factors stored in the instrument, or a CSV of `wavelength_nm,factor` beside the station.
    pub calibration: String,
    /// Relative standard uncertainty of the irradiance calibration (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rel: Option<f64>,
    /// Relative standard uncertainty of the ratio of the calibration at 700 nm to that at 400 nm (k = 1): its spectral shape.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_shape_rel: Option<f64>,
    /// Standard uncertainty of the wavelength scale (k = 1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_wavelength_nm: Option<f64>,
    /// Bound of the light that reaches it otherwise than straight from the lamp, ÷ the direct light on the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stray_max_rel: Option<f64>,
}

/// The lamp's switch and size.
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
    /// When the lamp counts as stable; without it EN 13032-4: 30 min on, then 0.5 % over 15 min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stable: Option<Stable>,
}

/// Stabilisation of the lamp: on for at least `least_s`, and (max − min)/mean over the last `window_s` below `spread_rel`.
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

/// The detector's carriage: a linear axis, or a person who is asked. Distance = zero_mm + sense × counts ÷ counts_per_mm.
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

impl Station {
    /// Reads and validates a station file.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn load(file: &Utf8Path) -> Result<Self, DocumentError> {
        Self::parse(file, &read_text(file)?)
    }

    /// Validates the text of a station file; `file` is for messages.
    ///
    /// # Errors
    /// [`DocumentError`] with file and line.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, DocumentError> {
        let source = Source { file, text };
        Self::try_from(source.parse::<StationDocument>(FORMAT)?).map_err(|fault| source.locate(&fault))
    }

    /// The `darkroom.toml` of a virtual station, as written: relative to the station file.
    pub fn darkroom(&self) -> Option<&Utf8Path> {
        self.0.darkroom.as_deref()
    }

    /// Geometry of the bench.
    pub fn bench(&self) -> &Bench {
        &self.0.bench
    }

    /// The C axis.
    pub fn axis_c(&self) -> &Axis {
        &self.0.axis.c
    }

    /// The γ axis.
    pub fn axis_gamma(&self) -> &Axis {
        &self.0.axis.gamma
    }

    /// The lux meter.
    pub fn luxmeter(&self) -> &LuxMeter {
        &self.0.luxmeter
    }

    /// The spectroradiometer, if the bench has one.
    pub fn spectroradiometer(&self) -> Option<&Spectroradiometer> {
        self.0.spectroradiometer.as_ref()
    }

    /// The lamp's switch.
    pub fn lamp(&self) -> Option<&Lamp> {
        self.0.lamp.as_ref()
    }

    /// The detector's cap.
    pub fn shutter(&self) -> Option<&Access> {
        self.0.shutter.as_ref()
    }

    /// The baffle in the direct path.
    pub fn baffle(&self) -> Option<&Access> {
        self.0.baffle.as_ref()
    }

    /// The detector's rail.
    pub fn rail(&self) -> Option<&Rail> {
        self.0.rail.as_ref()
    }

    /// The room's thermometer.
    pub fn ambient(&self) -> Option<&Access> {
        self.0.ambient.as_ref()
    }

    /// The file's content, for a copy of it.
    pub fn document(&self) -> &StationDocument {
        &self.0
    }

    /// The spectroradiometer's calibration file, resolved against the folder of the station file; none for `device`.
    pub fn spectral_calibration(&self, station_file: &Utf8Path) -> Option<Utf8PathBuf> {
        let name = &self.0.spectroradiometer.as_ref()?.calibration;
        (name != "device").then(|| station_file.parent().unwrap_or(Utf8Path::new(".")).join(name))
    }
}

impl TryFrom<StationDocument> for Station {
    type Error = Fault;

    fn try_from(station: StationDocument) -> Result<Self, Fault> {
        positive("bench.distance_mm", station.bench.distance_mm)?;
        optional_positive("bench.u_distance_mm", station.bench.u_distance_mm)?;
        optional_positive("bench.floor_mm", station.bench.floor_mm)?;
        bound("bench.stray_max_rel", station.bench.stray_max_rel)?;
        bound("bench.ambient_max_lx", station.bench.ambient_max_lx)?;
        bound("bench.dark_max_lx", station.bench.dark_max_lx)?;
        for (name, axis) in [("axis.c", &station.axis.c), ("axis.gamma", &station.axis.gamma)] {
            validate_axis(name, axis)?;
        }
        let meter = &station.luxmeter;
        driver_and_target("luxmeter.open", &meter.open)?;
        positive("luxmeter.calibration_factor", meter.calibration_factor)?;
        if !(meter.u_rel.is_finite() && (0.0..1.0).contains(&meter.u_rel)) {
            return Err(Fault::new(
                "luxmeter.u_rel",
                "is a fraction in [0, 1), for instance 0.015 for 1.5 %",
            ));
        }
        if let Some(due) = &meter.due
            && !is_day(due)
        {
            return Err(Fault::new(
                "luxmeter.due",
                format!("`{due}` is no day, write YYYY-MM-DD"),
            ));
        }
        if let Some(spectro) = &station.spectroradiometer {
            driver_and_target("spectroradiometer.open", &spectro.open)?;
            positive("spectroradiometer.distance_mm", spectro.distance_mm)?;
            optional_positive("spectroradiometer.u_distance_mm", spectro.u_distance_mm)?;
            optional_positive("spectroradiometer.u_rel", spectro.u_rel)?;
            bound("spectroradiometer.u_shape_rel", spectro.u_shape_rel)?;
            bound("spectroradiometer.u_wavelength_nm", spectro.u_wavelength_nm)?;
            bound("spectroradiometer.stray_max_rel", spectro.stray_max_rel)?;
        }
        if let Some(lamp) = &station.lamp {
            one_of("lamp", lamp.open.as_deref(), lamp.prompt.as_deref())?;
            optional_positive("lamp.diameter_mm", lamp.diameter_mm)?;
            if let Some(stable) = &lamp.stable {
                positive("lamp.stable.least_s", stable.least_s)?;
                positive("lamp.stable.window_s", stable.window_s)?;
                positive("lamp.stable.spread_rel", stable.spread_rel)?;
            }
        }
        for (name, access) in [
            ("shutter", &station.shutter),
            ("baffle", &station.baffle),
            ("ambient", &station.ambient),
        ] {
            if let Some(access) = access {
                one_of(name, access.open.as_deref(), access.prompt.as_deref())?;
            }
        }
        if let Some(rail) = &station.rail {
            validate_rail(rail)?;
        }
        Ok(Self(station))
    }
}

impl From<Station> for StationDocument {
    fn from(station: Station) -> Self {
        station.0
    }
}

fn validate_axis(name: &str, axis: &Axis) -> Result<(), Fault> {
    driver_and_target(&format!("{name}.open"), &axis.open)?;
    if !matches!(axis.sense, 1 | -1) {
        return Err(Fault::new(format!("{name}.sense"), "is 1 or -1"));
    }
    if !axis.zero_deg.is_finite() {
        return Err(Fault::new(format!("{name}.zero_deg"), "is not a finite angle"));
    }
    let [low, high] = axis.limit_deg;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(Fault::new(
            format!("{name}.limit_deg"),
            "is [smallest, largest] in degrees, the first below the second",
        ));
    }
    positive(&format!("{name}.speed_deg_s"), axis.speed_deg_s)?;
    positive(&format!("{name}.accel_deg_s2"), axis.accel_deg_s2)?;
    optional_positive(&format!("{name}.tolerance_deg"), axis.tolerance_deg)
}

fn validate_rail(rail: &Rail) -> Result<(), Fault> {
    one_of("rail", rail.open.as_deref(), rail.prompt.as_deref())?;
    if rail.open.is_none() {
        return Ok(());
    }
    let Some(driven) = rail.driven() else {
        return Err(Fault::new(
            "rail",
            "a driven rail needs counts_per_mm, zero_mm, limit_mm, speed_mm_s and accel_mm_s2",
        ));
    };
    if !matches!(driven.sense, 1 | -1) {
        return Err(Fault::new("rail.sense", "is 1 or -1"));
    }
    if !driven.zero_mm.is_finite() {
        return Err(Fault::new("rail.zero_mm", "is not a finite distance"));
    }
    let [low, high] = driven.limit_mm;
    if !(low.is_finite() && high.is_finite() && 0.0 < low && low < high) {
        return Err(Fault::new(
            "rail.limit_mm",
            "is [smallest, largest] in mm, above 0, the first below the second",
        ));
    }
    positive("rail.speed_mm_s", driven.speed_mm_s)?;
    positive("rail.accel_mm_s2", driven.accel_mm_s2)
}

fn one_of(name: &str, open: Option<&str>, prompt: Option<&str>) -> Result<(), Fault> {
    match (open, prompt) {
        (Some(open), None) => driver_and_target(&format!("{name}.open"), open),
        (None, Some(prompt)) if !prompt.trim().is_empty() => Ok(()),
        (None, Some(_)) => Err(Fault::new(
            format!("{name}.prompt"),
            "is empty; write what the person is to do",
        )),
        _ => Err(Fault::new(
            name,
            "needs either `open = \"driver:target\"` or `prompt = \"…\"`, one of the two",
        )),
    }
}

fn driver_and_target(path: &str, open: &str) -> Result<(), Fault> {
    match open.split_once(':') {
        Some((driver, target)) if !driver.is_empty() && !target.is_empty() => Ok(()),
        _ => Err(Fault::new(
            path,
            format!("`{open}` is not `driver:target`, for instance zaber:/dev/ttyUSB0?axis=1"),
        )),
    }
}

fn positive(path: &str, value: f64) -> Result<(), Fault> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Fault::new(path, format!("is {value}, expected above 0")))
    }
}

/// A bound may be zero: where it is known that there is nothing.
fn bound(path: &str, value: Option<f64>) -> Result<(), Fault> {
    match value {
        Some(value) if !(value.is_finite() && value >= 0.0) => {
            Err(Fault::new(path, format!("is {value}, expected 0 or more")))
        }
        _ => Ok(()),
    }
}

fn optional_positive(path: &str, value: Option<f64>) -> Result<(), Fault> {
    value.map_or(Ok(()), |value| positive(path, value))
}

fn is_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |part: &str, digits: usize, range: std::ops::RangeInclusive<u32>| {
        part.len() == digits && part.parse().is_ok_and(|value: u32| range.contains(&value))
    };
    parts.len() == 3 && number(parts[0], 4, 1..=9999) && number(parts[1], 2, 1..=12) && number(parts[2], 2, 1..=31)
}

/// A ratio of two whole numbers, `"n/d"` in files, both above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Ratio {
    numerator: i64,
    denominator: i64,
}

/// A text that is no ratio of two positive whole numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a ratio \"n/d\" of two whole numbers above zero, for instance \"6400/9\"")]
pub struct NotARatio(String);

impl Ratio {
    /// n.
    pub const fn numerator(self) -> i64 {
        self.numerator
    }

    /// d.
    pub const fn denominator(self) -> i64 {
        self.denominator
    }

    /// n ÷ d, rounded to an f64.
    pub fn as_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }
}

impl FromStr for Ratio {
    type Err = NotARatio;
    fn from_str(text: &str) -> Result<Self, NotARatio> {
        let fail = || NotARatio(text.to_owned());
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        let whole = |part: &str| {
            part.trim()
                .parse::<i64>()
                .ok()
                .filter(|&value| value > 0)
                .ok_or_else(fail)
        };
        Ok(Self {
            numerator: whole(numerator)?,
            denominator: whole(denominator)?,
        })
    }
}

impl TryFrom<String> for Ratio {
    type Error = NotARatio;
    fn try_from(text: String) -> Result<Self, NotARatio> {
        text.parse()
    }
}

impl From<Ratio> for String {
    fn from(ratio: Ratio) -> String {
        ratio.to_string()
    }
}

impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.numerator, self.denominator)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) const STATION: &str = r#"format = "isolux-station/1"
[bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 2.0
floor_mm = 1500.0
[axis.c]
open = "zaber:/dev/ttyUSB0?axis=1"
counts_per_deg = "6400/9"
zero_deg = 0.0
sense = 1
limit_deg = [-5.0, 365.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[axis.gamma]
open = "zaber:/dev/ttyUSB0?axis=2"
counts_per_deg = "6400/9"
zero_deg = 0.0
sense = -1
limit_deg = [-185, 185]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[luxmeter]
open = "t10a:/dev/ttyUSB1"
calibration_factor = 1.0
u_rel = 0.01
[lamp]
prompt = "switch the lamp"
"#;

    fn complaint(from: &str, to: &str) -> String {
        assert!(STATION.contains(from));
        Station::parse(Utf8Path::new("s.toml"), &STATION.replace(from, to))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn reads_and_writes_the_same_station() {
        let station = Station::parse(Utf8Path::new("s.toml"), STATION).unwrap();
        assert_eq!(station.axis_c().counts_per_deg.numerator(), 6400);
        assert_eq!(station.axis_gamma().limit_deg, [-185.0, 185.0]);
        let written = toml::to_string(&station).unwrap();
        assert_eq!(Station::parse(Utf8Path::new("again.toml"), &written).unwrap(), station);
    }

    #[test]
    fn refuses_with_line_and_remedy() {
        assert!(complaint("turning_luminaire", "turning_mirror").starts_with("s.toml:3:8:"));
        assert!(complaint("floor_mm", "flor_mm").starts_with("s.toml:6:1: unknown field `flor_mm`"));
        assert!(complaint("distance_mm = 10000.0", "distance_mm = -1").starts_with("s.toml:4:1: bench.distance_mm"));
        assert!(complaint("distance_mm = 10000.0", "distance_mm = nan").starts_with("s.toml:4:1:"));
        assert!(complaint("[-5.0, 365.0]", "[365.0, -5.0]").starts_with("s.toml:12:1: axis.c.limit_deg"));
        assert!(complaint("sense = -1", "sense = 2").starts_with("s.toml:19:1: axis.gamma.sense"));
        assert!(complaint("\"6400/9\"", "\"6400/0\"").contains("not a ratio"));
        assert!(complaint("t10a:/dev/ttyUSB1", "t10a").contains("driver:target"));
        assert!(complaint("prompt = \"switch the lamp\"", "").starts_with("s.toml:27:2: lamp: needs either"));
    }
}
