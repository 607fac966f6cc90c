//! One drive as an axis.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{AxisPosition, AxisSettings, Coordinate, DeviceError, Identity};
use tokio::time::{Instant, sleep};

use super::drive::{Drive, Dynamics, Registers, STOP, ZHOME};
use crate::polled::{AxisDriver, AxisStatus, in_use, within_own_limits};

/// A drive acknowledges a command that it then ignores; one that it obeys shows within this time. A search for the
/// reference never rests for so long.
const START: Duration = Duration::from_millis(300);

/// Between two looks at whether it has obeyed.
const LOOK: Duration = Duration::from_millis(50);

pub(crate) struct AzAxis<P> {
    drive: Drive,
    settings: AxisSettings<P>,
    dynamics: Dynamics,
    tolerance_steps: u64,
}

impl<P: Coordinate> AzAxis<P> {
    /// Releases the inputs, checks the limits, sets speed and rates. Moves nothing.
    pub async fn open(drive: Drive, settings: AxisSettings<P>, tolerance_steps: u64) -> Result<Self, DeviceError> {
        // What an earlier program held: its STOP would make the drive ignore every move.
        drive.set_inputs(0, "release the inputs").await?;
        let own_limits = drive.limits().await?.unwrap_or_else(|| {
            tracing::warn!(device = drive.name(), "the drive's software limits are off");
            (i32::MIN.into(), i32::MAX.into())
        });
        within_own_limits(drive.name(), &settings, own_limits)?;
        let unsupported = |reason: String| DeviceError::unsupported(drive.name(), "set speed and rates", reason);
        let steps_per_unit = settings.scale().steps_per_unit();
        let dynamics = Dynamics::new(
            P::KEYS,
            settings.speed() * steps_per_unit,
            settings.acceleration() * steps_per_unit,
        )
        .map_err(|(key, least, most)| {
            let [least, most] = [least, most].map(|steps| f64::from(steps) / steps_per_unit);
            unsupported(format!("{key} must be {least} to {most} for this drive"))
        })?;
        drive.set_dynamics(dynamics).await?;
        let actual = [dynamics.speed_hz, dynamics.rate_hz_s].map(|hz| f64::from(hz) / steps_per_unit);
        Ok(Self {
            settings: in_use(drive.name(), &settings, actual)?,
            drive,
            dynamics,
            tolerance_steps,
        })
    }

    /// Why an axis at rest takes no target.
    fn not_ready(registers: &Registers, homed: bool) -> Option<String> {
        let outputs = registers.outputs;
        if !homed {
            let why = if outputs.coordinates_set() {
                "the drive has been without power"
            } else {
                "no reference"
            };
            return Some(format!("{why}: home the axis first"));
        }
        let held = !outputs.moving() && !outputs.ready();
        held.then(|| "not READY: STOP or FREE is held, or the motor has no power".to_owned())
    }
}

#[async_trait]
impl<P: Coordinate> AxisDriver<P> for AzAxis<P> {
    fn identity(&self) -> &Identity {
        self.drive.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    fn tolerance_steps(&self) -> u64 {
        self.tolerance_steps
    }

    async fn status(&self) -> Result<AxisStatus<P>, DeviceError> {
        let before = self.drive.unit().unsolicited();
        let registers = self.drive.registers().await?;
        let (steps, outputs) = (i64::from(registers.detected_steps), registers.outputs);
        // On its way an axis has power; at rest the rates tell whether it had it all the time.
        let powered = outputs.moving() || self.drive.rates().await? == [self.dynamics.rate_hz_s; 2];
        let homed = outputs.coordinates_set() && powered;
        let position = AxisPosition {
            place: self.settings.scale().place(steps),
            steps,
            moving: outputs.moving(),
            homed,
            at: registers.at,
        };
        let unsettled = !outputs.moving() && !outputs.in_position();
        let at_end = homed && outputs.home_end();
        Ok(AxisStatus {
            fault: registers.alarm(),
            not_ready: Self::not_ready(&registers, homed),
            displaced: registers.displaced(self.tolerance_steps),
            unsettled: unsettled.then(|| {
                let displaced = registers.displaced(0);
                displaced.unwrap_or_else(|| "at rest, and not in position".to_owned())
            }),
            obstacle: outputs.software_limit().then(|| "software limit reached".to_owned()),
            search_failed: (!at_end).then(|| {
                "it came to rest without a reference; set the home position once with the maker's software".to_owned()
            }),
            ..AxisStatus::new((before, self.drive.unit().unsolicited()), position, registers.frame)
        })
    }

    async fn go(&self, steps: i32) -> Result<(), DeviceError> {
        let action = format!("move to {steps}");
        let Dynamics { speed_hz, rate_hz_s } = self.dynamics;
        self.drive.go(steps, speed_hz, rate_hz_s, &action).await?;
        let began = Instant::now();
        loop {
            let registers = self.drive.registers().await?;
            let command_steps = registers.command_steps;
            if registers.outputs.moving() || command_steps == steps || registers.alarm.is_some() {
                return Ok(());
            }
            if began.elapsed() >= START {
                let reason =
                    format!("acknowledged and ignored: the drive does not move and still holds {command_steps}");
                return Err(self.drive.unit().fault(&action, reason, registers.frame));
            }
            sleep(LOOK).await;
        }
    }

    async fn go_home(&self) -> Result<(), DeviceError> {
        const ACTION: &str = "home (ZHOME)";
        if self.drive.registers().await?.alarm.is_some() {
            self.drive.reset_alarm().await?;
        }
        // After a cut of power the registers are those of power-on: from here on they tell of the next one.
        self.drive.set_dynamics(self.dynamics).await?;
        self.drive.set_inputs(0, ACTION).await?;
        self.drive.set_inputs(ZHOME, ACTION).await
    }

    fn home_rest(&self) -> Duration {
        START
    }

    async fn at_home(&self, steps: i64, moved: bool) -> Result<(), DeviceError> {
        if moved || steps.unsigned_abs() <= self.tolerance_steps {
            return Ok(());
        }
        let reason = format!("acknowledged and ignored: the axis stayed at {steps}");
        Err(self.drive.unit().fault("home", reason, Vec::new()))
    }

    async fn brake(&self) -> Result<(), DeviceError> {
        self.drive.set_inputs(STOP, "stop").await
    }

    /// R-IN5 may be assigned to something else than STOP: a move at speed 0 ends every motion, too.
    async fn cut(&self) -> Result<(), DeviceError> {
        self.drive.go(0, 0, self.dynamics.rate_hz_s, "stop by speed 0").await
    }

    async fn release(&self) -> Result<(), DeviceError> {
        self.drive.set_inputs(0, "release the inputs").await
    }
}
