//! A bench of fakes for the tests of this crate: axes that take their time, a lamp that warms up, a meter that rounds.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use async_trait::async_trait;
use camino::{Utf8Path, Utf8PathBuf};
use isolux_device::{
    Axis, AxisPosition, AxisScale, AxisSettings, DeviceError, Identity, LuxMeter, LuxMeterProperties, LuxOutcome,
    LuxRange, LuxReading, Motion, RawSpectrum, Sense, Spectroradiometer, SpectroradiometerProperties, Switch,
};
use isolux_record::run::{RunDir, RunHeader};
use isolux_record::spectra::SpectralCalibration;
use isolux_record::{Plan, Station};
use isolux_units::{AxisAngle, Lux};
use tokio::time::{Instant, sleep_until};

use crate::devices::{CalibratedSpectro, Devices, TwoState};

pub const PLAN_HEAD: &str = "format = \"isolux-plan/1\"\n";

pub const STATION: &str = r#"format = "isolux-station/1"
[bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 2.0
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
    Station::parse(Utf8Path::new("s.toml"), STATION).unwrap()
}

pub fn plan(blocks: &str) -> Plan {
    Plan::parse(Utf8Path::new("p.toml"), &format!("{PLAN_HEAD}{blocks}")).unwrap()
}

/// The truth of the fake bench, shared by its instruments.
#[derive(Debug, Default)]
pub struct Room {
    pub axes: [Drive; 2],
    pub lamp_on: Option<Instant>,
    pub shutter_open: bool,
    pub baffle_in: bool,
    /// Faults.
    pub meter_lost_after: Option<u64>,
    pub meter_garbles_every: Option<u64>,
    pub meter_silent_after: Option<u64>,
    pub reads: u64,
    pub stop_fails: bool,
    pub panic_after: Option<u64>,
    pub stall_at_deg: Option<f64>,
    /// Time constant with which the light of a new pose appears.
    pub lag_s: f64,
    pub warm_up_amplitude: f64,
    pub drift_per_h: f64,
    /// Light when each motion ended.
    pub last_rest: Option<Instant>,
    pub log: Vec<String>,
    /// Share of the lamp's light that is lost.
    pub dimmed: f64,
    /// The shutter's blade does not follow its output.
    pub stuck_shut: bool,
    /// The truth of each reading of the meter; its number is the reading's evidence.
    pub looks: Vec<Truth>,
}

/// How the bench was when the meter took a reading.
#[derive(Debug, Clone)]
pub struct Truth {
    pub axes: [i64; 2],
    pub lamp_on: bool,
    pub shutter_open: bool,
    pub baffle_in: bool,
}

#[derive(Debug, Default, Clone, Copy)]
pub struct Drive {
    pub from: i64,
    pub to: i64,
    pub began: Option<Instant>,
    pub ends: Option<Instant>,
    pub homed: bool,
    pub stops: u32,
}

impl Drive {
    pub fn steps(&self, now: Instant) -> i64 {
        match (self.began, self.ends) {
            (Some(began), Some(ends)) if now < ends => {
                let share = now.duration_since(began).as_secs_f64() / ends.duration_since(began).as_secs_f64();
                self.from + ((self.to - self.from) as f64 * share).round() as i64
            }
            _ => self.to,
        }
    }

    pub fn moving(&self, now: Instant) -> bool {
        self.ends.is_some_and(|ends| now < ends)
    }
}

pub type Shared = Arc<Mutex<Room>>;

pub const PEAK_CD: f64 = 1000.0;
pub const OFFSET_LX: f64 = 0.05;
pub const AMBIENT_LX: f64 = 0.02;
pub const STRAY_LX: f64 = 0.03;

impl Room {
    /// Illuminance at the meter's head, its own offset included.
    fn light(&self, now: Instant) -> f64 {
        let mut lux = OFFSET_LX;
        if self.shutter_open && !self.stuck_shut {
            lux += AMBIENT_LX;
            if let Some(on) = self.lamp_on {
                let age = now.duration_since(on).as_secs_f64();
                let level = (1.0 - self.dimmed)
                    * (1.0 + self.warm_up_amplitude * (-age / 300.0).exp())
                    * (1.0 + self.drift_per_h * age / 3600.0);
                lux += STRAY_LX * level;
                if !self.baffle_in {
                    let gamma = (self.axes[1].steps(now) as f64 / 1000.0).to_radians();
                    let settled = self.last_rest.map_or(1.0, |rest| {
                        if self.lag_s > 0.0 {
                            1.0 - (-now.saturating_duration_since(rest).as_secs_f64() / self.lag_s).exp()
                        } else {
                            1.0
                        }
                    });
                    lux += level * settled * PEAK_CD * gamma.cos().max(0.0) / 100.0;
                }
            }
        }
        lux
    }
}

fn identity(target: &str) -> Identity {
    Identity {
        driver: "fake",
        target: target.to_owned(),
        model: target.to_owned(),
        serial: Some(format!("{target}-1")),
        firmware: None,
    }
}

struct FakeAxis {
    identity: Identity,
    settings: AxisSettings,
    index: usize,
    room: Shared,
}

impl FakeAxis {
    fn now(&self) -> AxisPosition {
        let now = Instant::now();
        let drive = self.room.lock().unwrap().axes[self.index];
        AxisPosition {
            place: self.settings.scale().place(drive.steps(now)),
            steps: drive.steps(now),
            moving: drive.moving(now),
            homed: drive.homed,
            at: now,
        }
    }
}

#[async_trait]
impl Axis for FakeAxis {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    fn settings(&self) -> &AxisSettings {
        &self.settings
    }
    async fn position(&self) -> Result<AxisPosition, DeviceError> {
        Ok(self.now())
    }
    async fn home(&self, _: Instant) -> Result<AxisPosition, DeviceError> {
        sleep_until(Instant::now() + Duration::from_secs(10)).await;
        self.room.lock().unwrap().axes[self.index] = Drive {
            homed: true,
            ..Drive::default()
        };
        Ok(self.now())
    }
    async fn start_move(&self, to: AxisAngle) -> Result<Motion, DeviceError> {
        let now = Instant::now();
        let mut room = self.room.lock().unwrap();
        let from = room.axes[self.index].steps(now);
        let target_steps = self.settings.scale().steps(to);
        let target = self.settings.scale().place(target_steps);
        let expected = self.settings.duration((target_steps - from) as f64 / 1000.0);
        let stalls = room.stall_at_deg == Some(target.value()) && self.index == 1;
        let ends = now
            + if stalls {
                Duration::from_secs(1_000_000)
            } else {
                expected
            };
        let drive = &mut room.axes[self.index];
        *drive = Drive {
            from,
            to: target_steps,
            began: Some(now),
            ends: Some(ends),
            ..*drive
        };
        if target_steps != from {
            room.last_rest = room.last_rest.max(Some(ends));
        }
        Ok(Motion {
            from_steps: from,
            target_steps,
            target,
            expected,
            deadline: now + 2 * expected + Duration::from_secs(2),
        })
    }
    async fn finish_move(&self, motion: Motion) -> Result<AxisPosition, DeviceError> {
        let ends = self.room.lock().unwrap().axes[self.index].ends.unwrap();
        // A driver that has no watchdog of its own: the engine must have one.
        sleep_until(ends).await;
        let now = self.now();
        if now.moving || now.steps != motion.target_steps {
            return Err(DeviceError::Fault {
                device: self.identity.target.clone(),
                action: "move".to_owned(),
                reason: format!("at {} and not at {}", now.steps, motion.target_steps),
                evidence: Vec::new(),
            });
        }
        Ok(now)
    }
    async fn stop(&self) -> Result<AxisPosition, DeviceError> {
        let now = Instant::now();
        {
            let mut room = self.room.lock().unwrap();
            if room.stop_fails && self.index == 0 {
                return Err(DeviceError::Disconnected {
                    device: self.identity.target.clone(),
                    action: "stop".to_owned(),
                    reason: "unplugged".to_owned(),
                });
            }
            let drive = &mut room.axes[self.index];
            let at = drive.steps(now);
            *drive = Drive {
                from: at,
                to: at,
                began: None,
                ends: None,
                stops: drive.stops + 1,
                ..*drive
            };
        }
        Ok(self.now())
    }
}

struct FakeMeter {
    identity: Identity,
    properties: LuxMeterProperties,
    room: Shared,
}

#[async_trait]
impl LuxMeter for FakeMeter {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }
    async fn read(&self, not_before: Instant, _: Instant) -> Result<LuxReading, DeviceError> {
        let began = Instant::now().max(not_before);
        let ended = began + Duration::from_millis(500);
        sleep_until(ended).await;
        let mut room = self.room.lock().unwrap();
        room.reads += 1;
        let panics = room.panic_after.is_some_and(|after| room.reads > after);
        if panics {
            drop(room);
            panic!("a defect");
        }
        let (device, action) = (self.identity.target.clone(), "read".to_owned());
        if room.meter_lost_after.is_some_and(|after| room.reads > after) {
            return Err(DeviceError::Disconnected {
                device,
                action,
                reason: "unplugged".to_owned(),
            });
        }
        if room.meter_silent_after.is_some_and(|after| room.reads > after) {
            return Err(DeviceError::Timeout {
                device,
                action,
                waited: Duration::from_secs(3),
                received: Vec::new(),
            });
        }
        // As a driver does: the answer is asked for again, and the reading says so.
        let garbled = room
            .meter_garbles_every
            .is_some_and(|every| room.reads.is_multiple_of(every));
        let lux = (room.light(ended) / 0.01).round() * 0.01;
        let truth = Truth {
            axes: room.axes.map(|axis| axis.steps(ended)),
            lamp_on: room.lamp_on.is_some(),
            shutter_open: room.shutter_open,
            baffle_in: room.baffle_in,
        };
        let number = room.looks.len() as u32;
        room.looks.push(truth);
        Ok(LuxReading {
            outcome: LuxOutcome::Measured(Lux::new(lux).unwrap()),
            range: 1,
            confirmed_by: None,
            digit: Lux::new(0.01).unwrap(),
            began,
            ended,
            caution: None,
            retries: u32::from(garbled),
            evidence: number.to_be_bytes().to_vec(),
        })
    }
    async fn set_range(&self, _: LuxRange) -> Result<(), DeviceError> {
        Ok(())
    }
}

enum Part {
    Lamp,
    Shutter,
    Baffle,
}

struct FakeSwitch {
    identity: Identity,
    part: Part,
    room: Shared,
}

#[async_trait]
impl Switch for FakeSwitch {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    async fn set(&self, on: bool) -> Result<(), DeviceError> {
        let mut room = self.room.lock().unwrap();
        room.log.push(format!("{} {on}", self.identity.target));
        match self.part {
            Part::Lamp => room.lamp_on = on.then(Instant::now),
            Part::Shutter => room.shutter_open = on,
            Part::Baffle => room.baffle_in = on,
        }
        Ok(())
    }
    async fn state(&self) -> Result<bool, DeviceError> {
        let room = self.room.lock().unwrap();
        Ok(match self.part {
            Part::Lamp => room.lamp_on.is_some(),
            Part::Shutter => room.shutter_open,
            Part::Baffle => room.baffle_in,
        })
    }
}

struct FakeSpectro {
    identity: Identity,
    properties: SpectroradiometerProperties,
    time: Mutex<Duration>,
    room: Shared,
}

#[async_trait]
impl Spectroradiometer for FakeSpectro {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    fn properties(&self) -> &SpectroradiometerProperties {
        &self.properties
    }
    async fn set_integration_time(&self, time: Duration) -> Result<Duration, DeviceError> {
        *self.time.lock().unwrap() = time;
        Ok(time)
    }
    async fn acquire(&self, _: Instant) -> Result<RawSpectrum, DeviceError> {
        let time = *self.time.lock().unwrap();
        let began = Instant::now();
        sleep_until(began + time).await;
        let room = self.room.lock().unwrap();
        let lit = room.shutter_open && room.lamp_on.is_some();
        let counts = (0..8)
            .map(|pixel| {
                let light = if lit && pixel > 0 {
                    f64::from(pixel) * 40_000.0 * time.as_secs_f64()
                } else {
                    0.0
                };
                (1500.0 + light).min(65_535.0) as u16
            })
            .collect();
        Ok(RawSpectrum {
            counts,
            integration_time: time,
            detector_c: Some(20.0),
            began,
            ended: began + time,
        })
    }
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
