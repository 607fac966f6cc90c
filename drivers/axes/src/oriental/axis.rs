//! One drive as an axis.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{Axis, AxisPosition, AxisSettings, Coordinate, DeviceError, Identity, Motion};
use tokio::time::{Instant, sleep};

use super::drive::{Drive, Dynamics, Look, STOP, ZHOME};
use crate::watched::{and_not_stopped, at_rest, on_its_way};

/// A drive acknowledges a command that it then ignores; one that it obeys shows within this time.
const START: Duration = Duration::from_millis(300);

/// A moving axis whose count stays the same for this long has stalled; one at rest is in position by then.
const NO_PROGRESS: Duration = Duration::from_secs(1);

/// Positions within which two or three in a row must fit together.
const MOST_POSITIONS: usize = 8;

/// Between the two equal positions that prove standstill.
const STANDSTILL: Duration = Duration::from_millis(50);

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
        let scale = settings.scale();
        let whole = (i64::from(i32::MIN), i64::from(i32::MAX));
        let (own_min, own_max) = drive.limits().await?.unwrap_or_else(|| {
            tracing::warn!(device = drive.name(), "the drive's software limits are off");
            whole
        });
        let ends = [scale.place(own_min).number(), scale.place(own_max).number()];
        let (lower, upper) = settings.limit();
        for wanted in [lower, upper] {
            if !(own_min..=own_max).contains(&scale.steps(wanted)) {
                return Err(DeviceError::OutOfTravel {
                    device: format!("{} ({})", drive.name(), P::KEYS[1]),
                    wanted: wanted.number(),
                    from: ends[0].min(ends[1]),
                    to: ends[0].max(ends[1]),
                    unit: P::UNIT,
                });
            }
        }
        let unsupported = |reason: String| DeviceError::Unsupported {
            device: drive.name().to_owned(),
            action: "set speed and rates".to_owned(),
            reason,
        };
        let steps_per_unit = scale.steps_per_unit();
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
        let (speed, rate) = (f64::from(dynamics.speed_hz), f64::from(dynamics.rate_hz_s));
        let settings = AxisSettings::new(*scale, settings.limit(), speed / steps_per_unit, rate / steps_per_unit);
        let settings = settings.map_err(|error| unsupported(error.to_string()))?;
        Ok(Self {
            drive,
            settings,
            dynamics,
            tolerance_steps,
        })
    }

    async fn look(&self) -> Result<Look<P>, DeviceError> {
        self.drive.look(self.settings.scale(), self.dynamics).await
    }

    fn fault(&self, action: &str, reason: impl Into<String>, look: &Look<P>) -> DeviceError {
        self.drive.unit().fault(action, reason, look.frame.clone())
    }

    fn timeout(&self, action: &str, waited: Duration, look: &Look<P>) -> DeviceError {
        DeviceError::Timeout {
            device: self.drive.name().to_owned(),
            action: action.to_owned(),
            waited,
            received: look.frame.clone(),
        }
    }

    /// Whether two looks in a row are those of an axis at rest in one place, with no byte in between that nothing had
    /// asked for.
    fn rests(&self, before: &Look<P>, now: &Look<P>) -> bool {
        before.unsolicited.0 == now.unsolicited.1 && at_rest(&before.position, &now.position, self.tolerance_steps)
    }

    /// Whether three looks in a row are those of an axis on its way: the one between lies between the others.
    fn passes(before: &Look<P>, between: &Look<P>, now: &Look<P>) -> bool {
        before.unsolicited.0 == now.unsolicited.1 && on_its_way([before, between, now].map(|look| &look.position))
    }

    /// Stops after a failure, and says in `error` when even that could not be verified.
    async fn stopped_because(&self, error: DeviceError) -> DeviceError {
        match self.stop().await {
            Ok(_) => error,
            Err(second) => and_not_stopped(error, second),
        }
    }

    /// Waits until two looks in a row show the axis at rest in one place.
    async fn standstill(&self, action: &str, limit: Duration) -> Result<Look<P>, DeviceError> {
        let began = Instant::now();
        let mut before = self.look().await?;
        loop {
            sleep(STANDSTILL).await;
            let now = self.look().await?;
            if self.rests(&before, &now) {
                return Ok(now);
            }
            if began.elapsed() >= limit {
                return Err(self.timeout(action, began.elapsed(), &now));
            }
            before = now;
        }
    }

    /// Why an axis at rest cannot be sent anywhere.
    fn unfit(&self, look: &Look<P>) -> Option<String> {
        let lost = || {
            let why = if look.outputs.coordinates_set() {
                "the drive has been without power"
            } else {
                "no reference"
            };
            (!look.position.homed).then(|| format!("{why}: home the axis first"))
        };
        let held = || {
            let held = !look.position.moving && !look.outputs.ready();
            held.then(|| "not READY: STOP or FREE is held, or the motor has no power".to_owned())
        };
        look.fault()
            .or_else(lost)
            .or_else(|| look.displaced(self.tolerance_steps))
            .or_else(held)
    }

    /// Whether the drive has taken up the move to `target_steps`.
    async fn has_started(&self, target_steps: i64, action: &str) -> Result<(), DeviceError> {
        let began = Instant::now();
        loop {
            let look = self.look().await?;
            if look.position.moving || look.command_steps == target_steps || look.alarm.is_some() {
                return Ok(());
            }
            if began.elapsed() >= START {
                let reason = format!(
                    "acknowledged and ignored: the drive does not move and still holds {}",
                    look.command_steps
                );
                return Err(self.fault(action, reason, &look));
            }
            sleep(STANDSTILL).await;
        }
    }
}

#[async_trait]
impl<P: Coordinate> Axis<P> for AzAxis<P> {
    fn identity(&self) -> &Identity {
        self.drive.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    async fn position(&self) -> Result<AxisPosition<P>, DeviceError> {
        const ACTION: &str = "read the position";
        let mut earlier: Option<Look<P>> = None;
        let mut before = self.look().await?;
        for _ in 1..MOST_POSITIONS {
            let now = self.look().await?;
            let found = if self.rests(&before, &now) {
                now
            } else if earlier.is_some_and(|earlier| Self::passes(&earlier, &before, &now)) {
                before
            } else {
                earlier = Some(std::mem::replace(&mut before, now));
                continue;
            };
            return match found.fault().or_else(|| found.displaced(self.tolerance_steps)) {
                Some(reason) => Err(self.fault(ACTION, reason, &found)),
                None => Ok(found.position),
            };
        }
        let reason = "no positions in a row fit together: another program moves the axis, or the link is bad";
        Err(self.drive.unit().malformed(ACTION, reason, before.frame))
    }

    async fn home(&self, deadline: Instant) -> Result<AxisPosition<P>, DeviceError> {
        const ACTION: &str = "home (ZHOME)";
        let began = Instant::now();
        // What is remembered of an earlier stall must not fail this homing; what comes up during it must.
        if self.look().await?.alarm.is_some() {
            self.drive.reset_alarm().await?;
        }
        // After a cut of power the registers are those of power-on: from here on they tell of the next one.
        self.drive.set_dynamics(self.dynamics).await?;
        self.drive.set_inputs(0, ACTION).await?;
        self.drive.set_inputs(ZHOME, ACTION).await?;
        let (mut moved, mut idle_since) = (false, None);
        loop {
            sleep(STANDSTILL).await;
            let look = match self.look().await {
                Ok(look) => look,
                Err(error) => return Err(self.stopped_because(error).await),
            };
            moved |= look.position.moving;
            let error = if let Some(reason) = look.fault() {
                self.fault(ACTION, reason, &look)
            } else if Instant::now() >= deadline {
                self.timeout(ACTION, began.elapsed(), &look)
            } else if look.position.moving {
                idle_since = None;
                continue;
            } else if idle_since.get_or_insert_with(Instant::now).elapsed() < START {
                continue;
            } else if !look.position.homed || !look.outputs.home_end() {
                let reason =
                    "it came to rest without a reference; set the home position once with the maker's software";
                self.fault(ACTION, reason, &look)
            } else if !moved && look.position.steps.unsigned_abs() > self.tolerance_steps {
                let reason = format!("acknowledged and ignored: the axis stayed at {}", look.position.steps);
                self.fault(ACTION, reason, &look)
            } else {
                return match self.standstill(ACTION, NO_PROGRESS).await {
                    Ok(rest) => self.drive.set_inputs(0, ACTION).await.map(|()| rest.position),
                    Err(error) => Err(self.stopped_because(error).await),
                };
            };
            return Err(self.stopped_because(error).await);
        }
    }

    async fn start_move(&self, to: P) -> Result<Motion<P>, DeviceError> {
        let scale = self.settings.scale();
        let target_steps = scale.steps(to);
        let (true, Ok(steps)) = (self.settings.allows(to), i32::try_from(target_steps)) else {
            return Err(self.settings.out_of_travel(self.drive.name(), to.number()));
        };
        let action = format!("move to {target_steps}");
        let look = self.look().await?;
        if let Some(reason) = self.unfit(&look) {
            return Err(self.fault(&action, reason, &look));
        }
        let from_steps = look.position.steps;
        let Dynamics { speed_hz, rate_hz_s } = self.dynamics;
        self.drive.go(steps, speed_hz, rate_hz_s, &action).await?;
        // A move begun in motion may have to brake and come back: a second ramp covers it.
        let distance = (target_steps - from_steps) as f64 * scale.step();
        let expected = self.settings.duration(distance);
        let deadline = Instant::now() + 2 * expected + Duration::from_secs(2);
        if let Err(error) = self.has_started(target_steps, &action).await {
            return Err(self.stopped_because(error).await);
        }
        Ok(Motion {
            from_steps,
            target_steps,
            target: scale.place(target_steps),
            expected,
            deadline,
        })
    }

    async fn finish_move(&self, motion: Motion<P>) -> Result<AxisPosition<P>, DeviceError> {
        let action = format!("move to {}", motion.target_steps);
        let pause = (motion.expected / 16).clamp(Duration::from_millis(10), Duration::from_millis(200));
        let began = Instant::now();
        let mut last = (motion.from_steps, began);
        loop {
            sleep(pause).await;
            let looked = match self.look().await {
                // An axis that has come to rest is asked again: one old answer must not end the move.
                Ok(first) if !first.position.moving && first.alarm.is_none() => {
                    self.look().await.map(|now| self.rests(&first, &now).then_some(now))
                }
                look => look.map(Some),
            };
            let look = match looked {
                Ok(Some(look)) => look,
                Ok(None) if Instant::now() < motion.deadline => continue,
                Ok(None) => {
                    let reason = "no two positions in a row fit together";
                    let error = self.drive.unit().malformed(&action, reason, Vec::new());
                    return Err(self.stopped_because(error).await);
                }
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let (position, waited) = (look.position, last.1.elapsed());
            let there = position.steps.abs_diff(motion.target_steps) <= self.tolerance_steps;
            let error = if let Some(reason) = look.fault() {
                self.fault(&action, reason, &look)
            } else if !position.homed {
                self.fault(&action, "the reference was lost on the way", &look)
            } else if !position.moving && there && look.outputs.in_position() {
                return Ok(position);
            } else if !position.moving && !there && look.outputs.in_position() {
                let why = if look.outputs.software_limit() {
                    ", at a software limit"
                } else {
                    ""
                };
                let reason = format!(
                    "it came to rest at {} and not at {}{why}",
                    position.steps, motion.target_steps
                );
                self.fault(&action, reason, &look)
            } else if position.steps == last.0 && waited >= NO_PROGRESS {
                let reason = if position.moving {
                    format!("no progress from {} for {waited:?}: stalled", position.steps)
                } else {
                    look.displaced(0)
                        .unwrap_or_else(|| "at rest, and not in position".to_owned())
                };
                self.fault(&action, reason, &look)
            } else if Instant::now() >= motion.deadline {
                self.timeout(&action, began.elapsed(), &look)
            } else {
                if position.steps != last.0 {
                    last = (position.steps, Instant::now());
                }
                continue;
            };
            return Err(self.stopped_because(error).await);
        }
    }

    async fn stop(&self) -> Result<AxisPosition<P>, DeviceError> {
        self.drive.set_inputs(STOP, "stop").await?;
        let ramp = Duration::try_from_secs_f64(self.settings.speed() / self.settings.acceleration());
        let limit = 2 * ramp.unwrap_or_default() + Duration::from_secs(1);
        let rest = match self.standstill("stop", limit).await {
            // R-IN5 may be assigned to something else: a move at speed 0 ends every motion, too.
            Err(DeviceError::Timeout { .. }) => {
                self.drive.go(0, 0, self.dynamics.rate_hz_s, "stop by speed 0").await?;
                self.standstill("stop by speed 0", limit).await?
            }
            rest => rest?,
        };
        // An axis at rest may keep the input; it would only refuse the next move, which says so.
        if let Err(error) = self.drive.set_inputs(0, "release STOP").await {
            tracing::warn!(%error, "STOP stays on");
        }
        Ok(rest.position)
    }
}
