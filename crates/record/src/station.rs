//! `isolux-station/1`: the bench, its axes, its instruments and how to open them.

mod document;
mod luxmeter;
mod parts;
mod ratio;
mod traceability;
pub(crate) mod valid;

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};

pub use self::document::{
    Access, Axes, Axis, Bench, BenchType, DrivenRail, Lamp, PowerMeter, Rail, Spectroradiometer, Stable,
    StationDocument, Supply,
};
pub use self::luxmeter::{Cosine, Fatigue, Linearity, LuxMeter, Temperature};
pub use self::ratio::{NotARatio, Ratio};
pub use self::traceability::Traceability;
pub(crate) use self::traceability::is_day;
use crate::document::{DocumentError, Fault, SourceText, read_text};

/// Value of `format` in a station file.
pub const FORMAT: &str = "isolux-station/1";

/// A valid station.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StationDocument", into = "StationDocument")]
pub struct Station(StationDocument);

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
        let source = SourceText { file, text };
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
        (name != "device").then(|| beside(station_file, name))
    }

    /// The file of the lux meter's spectral responsivity, resolved likewise.
    pub fn responsivity(&self, station_file: &Utf8Path) -> Option<Utf8PathBuf> {
        let name = self.luxmeter().responsivity.as_ref()?;
        Some(beside(station_file, name))
    }

    /// The file of the light under which the lux meter was calibrated, resolved likewise; none for illuminant A.
    pub fn calibration_light(&self, station_file: &Utf8Path) -> Option<Utf8PathBuf> {
        let name = self.luxmeter().calibration_light.as_ref()?;
        Some(beside(station_file, name))
    }
}

/// A file that a station names, relative to the folder of its own.
fn beside(station_file: &Utf8Path, name: &str) -> Utf8PathBuf {
    station_file.parent().unwrap_or(Utf8Path::new(".")).join(name)
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
                "u_rel = 0.01",
                "u_rel = 0.01\nf1_prime_rel = 3.0",
                "s.toml:27:1: luxmeter.f1_prime_rel: is 3, expected 0 to 0.3 (a fraction: 0.03 is 3 %)",
            ),
            (
                "u_rel = 0.01",
                "u_rel = 0.01\nresponsivity = \" \"",
                "luxmeter.responsivity: is empty",
            ),
            (
                "u_rel = 0.01",
                "u_rel = 0.01\ncalibration_light = \"\"",
                "luxmeter.calibration_light: is empty",
            ),
            (
                "u_rel = 0.01",
                "u_rel = 0.01\nresponsivity = \"head.csv\"\nf1_prime_rel = 0.03",
                "luxmeter.f1_prime_rel: is that of `responsivity`",
            ),
            (
                "distance_mm = 10000.0",
                "distance_mm = 1e308",
                "expected 1 to 1000000 mm",
            ),
            ("u_distance_mm = 2.0", "u_distance_mm = 20000.0", "bench.u_distance_mm"),
            ("floor_mm = 1500.0", "floor_mm = 1e308", "bench.floor_mm"),
            (
                "floor_mm = 1500.0",
                "floor_mm = 1500.0\nu_gamma_deg = 90.0",
                "bench.u_gamma_deg: is 90",
            ),
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
