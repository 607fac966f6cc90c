//! A bench of fakes for the tests of this crate: axes that take their time, a lamp that warms up, a meter that rounds.

pub mod fakes;
mod room;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_device::{
    Axis, AxisScale, AxisSettings, Conversions, LuxMeterProperties, Sense, SpectroradiometerProperties,
};
use isolux_record::run::{RunDir, RunHeader};
use isolux_record::spectra::{SpectralCalibration, SpectralCorrections};
use isolux_record::{Plan, Station};
use isolux_units::{AxisAngle, Lux};

use self::fakes::{FakeAxis, FakeMeter, FakeSpectro, FakeSwitch, Part, identity};
pub use self::room::{AMBIENT_LX, AxisDrive, OFFSET_LX, PEAK_CD, Room, STRAY_LX, Shared};
use crate::awake::Awake;
use crate::devices::{CalibratedSpectro, Devices, Nobody, TwoState};
use crate::engine::Engine;
use crate::observe::Silent;
use crate::pause::Pause;

pub const PLAN_HEAD: &str = "format = \"isolux-plan/1\"\n";

pub const STATION: &str = r#"format = "isolux-station/1"
[bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 2.0
u_gamma_deg = 0.05
[axis.c]
open = "fake:c"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = 1
limit_deg = [-5.0, 365.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[axis.gamma]
open = "fake:gamma"
counts_per_deg = "1000/1"
zero_deg = 0.0
sense = 1
limit_deg = [-185.0, 185.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[luxmeter]
open = "fake:lux"
calibration_factor = 1.0
u_rel = 0.01
[spectroradiometer]
open = "fake:spectro"
distance_mm = 500.0
calibration = "cal.csv"
[lamp]
open = "fake:lamp"
diameter_mm = 70.0
[shutter]
open = "fake:shutter"
[baffle]
open = "fake:baffle"
"#;

pub fn station() -> Station {
    station_with("")
}

/// The same, with these lines more of its lamp.
pub fn station_with(lamp: &str) -> Station {
    let text = STATION.replace("diameter_mm = 70.0", &format!("diameter_mm = 70.0\n{lamp}"));
    Station::parse(Utf8Path::new("s.toml"), &text).unwrap()
}

/// What is around a scan that nobody operates or observes.
pub fn unobserved<'a>(station: &'a Station, pause: &'a Pause, awake: &'a Awake) -> Engine<'a> {
    Engine {
        station,
        operator: &Nobody,
        pause,
        observer: &Silent,
        awake,
        now_utc: "2026-01-01T00:00:00Z".parse().unwrap(),
        wall_clock: None,
    }
}

pub fn plan(blocks: &str) -> Plan {
    Plan::parse(Utf8Path::new("p.toml"), &format!("{PLAN_HEAD}{blocks}")).unwrap()
}

/// A fresh bench, its lamp off, cap on.
pub fn bench() -> (Devices, Shared) {
    let room: Shared = Arc::new(Mutex::new(Room::default()));
    let axis = |index: usize, name: &str, limit: [f64; 2]| -> Box<dyn Axis> {
        let angle = |degrees| AxisAngle::new(degrees).unwrap();
        let scale = AxisScale::new(1000, 1, angle(0.0), Sense::Positive).unwrap();
        let settings = AxisSettings::new(scale, (angle(limit[0]), angle(limit[1])), 20.0, 40.0).unwrap();
        Box::new(FakeAxis {
            identity: identity(name),
            settings,
            index,
            room: room.clone(),
        })
    };
    let switch = |part: Part, name: &str| {
        Some(TwoState::Device(Box::new(FakeSwitch {
            identity: identity(name),
            part,
            room: room.clone(),
        })))
    };
    let wavelength_nm: Vec<f64> = (0..8).map(|pixel| 400.0 + 50.0 * f64::from(pixel)).collect();
    let spectro = CalibratedSpectro {
        factor_w_m2_nm: vec![1e-6; wavelength_nm.len()],
        calibration: SpectralCalibration {
            file: "cal.csv".to_owned(),
            sha256: "00".to_owned(),
            saturation_counts: 65_535.0,
            full_scale_counts: 65_535.0,
            nonlinearity: Vec::new(),
            dark_pixels: [0, 1],
            corrections: SpectralCorrections::default(),
            factors_corrected_by: None,
        },
        device: Box::new(FakeSpectro {
            identity: identity("spectro"),
            properties: SpectroradiometerProperties {
                wavelength_nm,
                dark_pixels: 0..1,
                integration_limits: (Duration::from_millis(1), Duration::from_mins(1)),
                saturation_counts: 65_535,
                full_scale_counts: 65_535,
                nonlinearity: Vec::new(),
                irradiance_factor: None,
            },
            time: Mutex::new(Duration::from_millis(1)),
            room: room.clone(),
        }),
    };
    let devices = Devices {
        axis_c: axis(0, "c", [-5.0, 365.0]),
        axis_gamma: axis(1, "gamma", [-185.0, 185.0]),
        meter: Box::new(FakeMeter {
            identity: identity("lux"),
            properties: LuxMeterProperties {
                range_full_scale: vec![Lux::new(299_900.0).unwrap()],
                update_interval: Duration::from_millis(500),
                integration: Duration::from_millis(500),
                range_integration: Vec::new(),
                needs_dark: false,
                converts: Conversions::OnRequest,
            },
            room: room.clone(),
        }),
        spectro: Some(spectro),
        power: None,
        lamp: switch(Part::Lamp, "lamp"),
        shutter: switch(Part::Shutter, "shutter"),
        baffle: switch(Part::Baffle, "baffle"),
        rail: None,
        ambient: None,
    };
    (devices, room)
}

pub fn header(devices: &Devices, plan: &Plan) -> RunHeader {
    let station = station();
    RunHeader::new(
        "test".to_owned(),
        "2026-01-01T00:00:00Z".to_owned(),
        devices.records(&station),
        devices.spectro.as_ref().map(|spectro| spectro.calibration.clone()),
        station,
        plan.clone(),
    )
}

pub fn run_dir(devices: &Devices, plan: &Plan) -> (tempfile::TempDir, Utf8PathBuf, RunDir) {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let run = RunDir::create(&path, header(devices, plan)).unwrap();
    (keep, path, run)
}
