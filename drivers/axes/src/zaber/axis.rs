//! One axis of a controller.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{AxisPosition, AxisSettings, Coordinate, DeviceError, Identity};
use isolux_protocol_zaber::{Severity, WarningFlag};
use tokio::time::Instant;

use super::controller::{Controller, Reported};
use crate::polled::{AxisDriver, AxisStatus, in_use, within_own_limits};

/// Speed in device units per (microstep/s), and per 10000 (microstep/s²) of acceleration (Zaber: "maxspeed", "accel").
const UNITS: f64 = 1.6384;

/// How far from its target a move may end, in microsteps: an encoder's dither.
const TOLERANCE_STEPS: u64 = 2;

pub(crate) struct ZaberAxis<P> {
    controller: Controller,
    axis: u8,
    settings: AxisSettings<P>,
}

impl<P: Coordinate> ZaberAxis<P> {
    /// Checks the limits and sets speed and acceleration. Moves nothing.
    pub async fn open(controller: Controller, axis: u8, settings: AxisSettings<P>) -> Result<Self, DeviceError> {
        let scale = settings.scale();
        let (own_min, _) = controller.number::<i64>(axis, "get limit.min").await?;
        let (own_max, _) = controller.number::<i64>(axis, "get limit.max").await?;
        within_own_limits(controller.name(), &settings, (own_min, own_max))?;

        let speed = (settings.speed() * scale.steps_per_unit() * UNITS).floor();
        let accel = (settings.acceleration() * scale.steps_per_unit() * UNITS / 10_000.0).floor();
        let mut actual = [0.0; 2];
        let smallest = [1.0 / UNITS, 10_000.0 / UNITS];
        for (i, (name, key, units)) in [("maxspeed", P::KEYS[2], speed), ("accel", P::KEYS[3], accel)]
            .into_iter()
            .enumerate()
        {
            // Zero would mean "no ramp at all", and rounding up more than the station allows.
            if units < 1.0 {
                return Err(DeviceError::unsupported(
                    controller.name(),
                    format!("set {name}"),
                    format!(
                        "{key} is below the smallest this axis can do, {}",
                        smallest[i] / scale.steps_per_unit()
                    ),
                ));
            }
            controller.ask(axis, &format!("set {name} {units}")).await?;
            let (read, stated) = controller.number::<f64>(axis, &format!("get {name}")).await?;
            if read != units {
                return Err(controller.fault(&format!("set {name} {units}"), "it reads back otherwise", stated.frame));
            }
            actual[i] = read * smallest[i] / scale.steps_per_unit();
        }
        Ok(Self {
            settings: in_use(controller.name(), &settings, actual)?,
            controller,
            axis,
        })
    }

    async fn ask(&self, text: &str) -> Result<Reported, DeviceError> {
        self.controller.ask(self.axis, text).await
    }
}

#[async_trait]
impl<P: Coordinate> AxisDriver<P> for ZaberAxis<P> {
    fn identity(&self) -> &Identity {
        self.controller.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    fn tolerance_steps(&self) -> u64 {
        TOLERANCE_STEPS
    }

    /// Count, motion and all flags. The reply carries one flag; only when there is one are all of them asked for.
    async fn status(&self) -> Result<AxisStatus<P>, DeviceError> {
        let before = self.controller.surplus();
        let stated = self.ask("get pos").await?;
        let (steps, stated) = self.controller.parsed::<i64>("get pos", stated)?;
        let at = Instant::now();
        let mut flags: Vec<WarningFlag> = stated.flag.into_iter().collect();
        if stated.flag.is_some() {
            let all = self.ask("warnings").await?;
            flags.extend(all.data.split(' ').skip(1).filter_map(WarningFlag::parse));
        }
        let position = AxisPosition {
            place: self.settings.scale().place(steps),
            steps,
            moving: stated.busy,
            homed: !flags.iter().any(WarningFlag::is_unreferenced),
            at,
        };
        let forbids = |flag: &&WarningFlag| flag.severity() == Severity::Fault && !flag.is_unreferenced();
        let fault = flags.iter().find(forbids);
        Ok(AxisStatus {
            fault: fault.map(|flag| format!("{} ({})", flag.letters(), flag.meaning())),
            ..AxisStatus::new((before, self.controller.surplus()), position, stated.frame)
        })
    }

    /// The reply to the command says already that the axis moves.
    fn start_time(&self) -> Duration {
        Duration::ZERO
    }

    /// `set maxspeed`, which firmware 6 and 7 take: a speed as a parameter of `move` is of firmware 7 alone.
    async fn cruise(&self, speed: f64) -> Result<f64, DeviceError> {
        let per_unit = self.settings.scale().steps_per_unit() * UNITS;
        let units = (speed * per_unit).round();
        if units < 1.0 {
            return Err(DeviceError::unsupported(
                self.controller.name(),
                format!("move at {speed}"),
                format!("the slowest speed of this axis is {}", 1.0 / per_unit),
            ));
        }
        let set = format!("set maxspeed {units}");
        self.ask(&set).await?;
        let (read, stated) = self.controller.number::<f64>(self.axis, "get maxspeed").await?;
        if read != units {
            return Err(self.controller.fault(&set, "it reads back otherwise", stated.frame));
        }
        Ok(read / per_unit)
    }

    async fn go(&self, steps: i32) -> Result<(), DeviceError> {
        self.ask(&format!("move abs {steps}")).await.map(|_| ())
    }

    async fn go_home(&self) -> Result<(), DeviceError> {
        self.ask("warnings clear").await?;
        self.ask("home").await.map(|_| ())
    }

    async fn brake(&self) -> Result<(), DeviceError> {
        self.ask("stop").await.map(|_| ())
    }

    async fn cut(&self) -> Result<(), DeviceError> {
        self.ask("estop").await.map(|_| ())
    }
}
