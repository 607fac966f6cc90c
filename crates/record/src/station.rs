//! `isolux-station/1`: the bench, its axes, its instruments and how to open them.

use std::fmt;
use std::str::FromStr;

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};

use crate::document::{DocumentError, Fault, Source, read_text};

pub(crate) mod valid;

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
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Certificate's factor: true illuminance ÷ shown illuminance.
    pub calibration_factor: f64,
    /// Relative standard uncertainty of the calibration (k = 1).
    pub u_rel: f64,
    /// Relative standard deviation of one reading, of the meter and of the lamp together: what `isolux plan` counts as
    /// noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_rel: Option<f64>,
    /// Standard deviation of one reading without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_lx: Option<f64>,
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

    /// The power meter in the lamp's supply line, if the bench has one.
    pub fn powermeter(&self) -> Option<&PowerMeter> {
        self.0.powermeter.as_ref()
    }

    /// The supply that feeds the lamp, if the bench has one.
    pub fn supply(&self) -> Option<&Supply> {
        self.0.supply.as_ref()
    }

    /// What switches the lamp: the supply, or else what `[lamp]` names.
    pub fn lamp_switch(&self) -> Option<Access> {
        let supply = self.supply().map(|supply| Access {
            open: Some(supply.open.clone()),
            prompt: None,
        });
        supply.or_else(|| {
            self.lamp().map(|lamp| Access {
                open: lamp.open.clone(),
                prompt: lamp.prompt.clone(),
            })
        })
    }

    /// What is known of the lamp.
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
        valid::check(&station)?;
        Ok(Self(station))
    }
}

impl From<Station> for StationDocument {
    fn from(station: Station) -> Self {
        station.0
    }
}

/// A ratio of two whole numbers, `"n/d"` in files, both above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(into = "String")]
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

impl<'de> Deserialize<'de> for Ratio {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;
        impl serde::de::Visitor<'_> for Text {
            type Value = Ratio;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a ratio")
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Ratio, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Text)
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

    #[test]
    fn what_cannot_be_meant_is_refused_with_its_line_and_what_would_be() {
        let lamp = "prompt = \"switch the lamp\"";
        for (from, to, expected) in [
            (
                "calibration_factor = 1.0",
                "calibration_factor = 1e308",
                "s.toml:25:1: luxmeter.calibration_factor: is 1e308, expected 0.001 to 1000",
            ),
            ("u_rel = 0.01", "u_rel = 1.5", "s.toml:26:1: luxmeter.u_rel"),
            ("u_rel = 0.01", "u_rel = nan", "luxmeter.u_rel: is NaN"),
            (
                "distance_mm = 10000.0",
                "distance_mm = 1e308",
                "expected 1 to 1000000 mm",
            ),
            ("u_distance_mm = 2.0", "u_distance_mm = 20000.0", "bench.u_distance_mm"),
            ("floor_mm = 1500.0", "floor_mm = 1e308", "bench.floor_mm"),
            (
                "sense = 1\n",
                "sense = 1\ntolerance_deg = 90.0\n",
                "axis.c.tolerance_deg: is 90, expected",
            ),
            ("[-5.0, 365.0]", "[-1e308, 365.0]", "axis.c.limit_deg"),
            (
                "[-185, 185]\nspeed_deg_s = 20.0",
                "[-185, 185]\nspeed_deg_s = 1e-300",
                "axis.gamma.speed_deg_s",
            ),
            (
                "accel_deg_s2 = 40.0\n[axis",
                "accel_deg_s2 = 1e308\n[axis",
                "axis.c.accel_deg_s2",
            ),
            (
                "zero_deg = 0.0\nsense = -1",
                "zero_deg = 1e308\nsense = -1",
                "axis.gamma.zero_deg",
            ),
            (
                "\"6400/9\"\nzero_deg = 0.0\nsense = 1",
                "\"9000000000/9\"\nzero_deg = 0.0\nsense = 1",
                "axis.c.counts_per_deg",
            ),
            (lamp, "prompt = \"switch it\"\ndiameter_mm = 1e308", "lamp.diameter_mm"),
            (
                lamp,
                "prompt = \"switch it\"\n[lamp.stable]\nleast_s = 1e308\nwindow_s = 900.0\nspread_rel = 0.005",
                "s.toml:30:1: lamp.stable.least_s: is 1e308, expected 0.1 to 86400 s",
            ),
            (
                lamp,
                "prompt = \"switch it\"\n[lamp.stable]\nleast_s = 10.0\nwindow_s = 1e308\nspread_rel = 0.005",
                "lamp.stable.window_s",
            ),
            (
                lamp,
                "prompt = \"switch it\"\n[lamp.stable]\nleast_s = 10.0\nwindow_s = 9.0\nspread_rel = 5.0",
                "lamp.stable.spread_rel",
            ),
            (
                lamp,
                "prompt = \"switch it\"\n[rail]\nopen = \"zaber:x\"\ncounts_per_mm = \"2000/1\"\nzero_mm = 0.0\n\
                 limit_mm = [100.0, 1e308]\nspeed_mm_s = 10.0\naccel_mm_s2 = 10.0",
                "rail.limit_mm",
            ),
        ] {
            let message = complaint(from, to);
            assert!(
                message.starts_with("s.toml:") && message.contains(expected),
                "{to}: {message}"
            );
        }
    }
}
