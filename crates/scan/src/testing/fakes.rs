//! Instruments of the fake bench.

use std::sync::Mutex;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{
    Axis, AxisPosition, AxisSettings, DeviceError, Identity, LuxMeter, LuxMeterProperties, LuxOutcome, LuxRange,
    LuxReading, LuxSample, Motion, RawSpectrum, Spectroradiometer, SpectroradiometerProperties, Switch,
};
use isolux_units::{AxisAngle, Lux};
use tokio::time::{Instant, sleep_until};

use super::room::{AxisDrive, Shared, Truth};

pub fn identity(target: &str) -> Identity {
    Identity {
        driver: "fake",
        target: target.to_owned(),
        model: target.to_owned(),
        serial: Some(format!("{target}-1")),
        firmware: None,
    }
}

pub struct FakeAxis {
    pub identity: Identity,
    pub settings: AxisSettings,
    pub index: usize,
    pub room: Shared,
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
        self.room.lock().unwrap().axes[self.index] = AxisDrive {
            homed: true,
            ..AxisDrive::default()
        };
        Ok(self.now())
    }
    async fn start_move(&self, to: AxisAngle) -> Result<Motion, DeviceError> {
        self.start_move_at(to, self.settings.speed()).await
    }
    async fn start_move_at(&self, to: AxisAngle, speed: f64) -> Result<Motion, DeviceError> {
        let now = Instant::now();
        let mut room = self.room.lock().unwrap();
        let from = room.axes[self.index].steps(now);
        let target_steps = self.settings.scale().steps(to);
        let target = self.settings.scale().place(target_steps);
        let expected = self.settings.duration_at((target_steps - from) as f64 / 1000.0, speed);
        let stalls = room.stall_at_deg == Some(target.value()) && self.index == 1;
        let ends = now
            + if stalls {
                Duration::from_secs(1_000_000)
            } else {
                expected
            };
        let drive = &mut room.axes[self.index];
        *drive = AxisDrive {
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
            speed,
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
            return Err(DeviceError::fault(
                &self.identity.target,
                "move",
                format!("at {} and not at {}", now.steps, motion.target_steps),
                Vec::new(),
            ));
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
            *drive = AxisDrive {
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

pub struct FakeMeter {
    pub identity: Identity,
    pub properties: LuxMeterProperties,
    pub room: Shared,
}

#[async_trait]
impl LuxMeter for FakeMeter {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }
    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let began = Instant::now().max(not_before);
        sleep_until(began + Duration::from_millis(500)).await;
        let ended = Instant::now();
        if ended > deadline {
            return Err(DeviceError::Timeout {
                device: self.identity.target.clone(),
                action: "read".to_owned(),
                waited: ended.duration_since(began),
                received: Vec::new(),
            });
        }
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
    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError> {
        let reading = self.read(Instant::now(), deadline).await?;
        Ok(LuxSample {
            outcome: reading.outcome,
            range: reading.range,
            digit: reading.digit,
            requested: reading.began,
            answered: reading.ended,
            evidence: reading.evidence,
        })
    }
    async fn set_range(&self, _: LuxRange) -> Result<(), DeviceError> {
        Ok(())
    }
    async fn take_dark(&self, _: Instant) -> Result<Option<String>, DeviceError> {
        if !self.properties.needs_dark {
            return Ok(None);
        }
        let mut room = self.room.lock().unwrap();
        let (reads, open) = (room.reads, room.shutter_open);
        room.log.push(format!("dark after {reads} readings, open: {open}"));
        Ok(Some("its dark was taken".to_owned()))
    }
}

pub enum Part {
    Lamp,
    Shutter,
    Baffle,
}

pub struct FakeSwitch {
    pub identity: Identity,
    pub part: Part,
    pub room: Shared,
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

pub struct FakeSpectro {
    pub identity: Identity,
    pub properties: SpectroradiometerProperties,
    pub time: Mutex<Duration>,
    pub room: Shared,
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
        let illuminated = room.shutter_open && room.lamp_on.is_some();
        let counts = (0..8)
            .map(|pixel| {
                let light = if illuminated && pixel > 0 {
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
    async fn sample(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        self.acquire(deadline).await
    }
}
