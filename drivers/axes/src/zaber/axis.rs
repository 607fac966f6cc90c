//! One axis of a controller.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{Axis, AxisPosition, AxisSettings, Coordinate, DeviceError, Identity, Motion};
use isolux_protocol_zaber::{Severity, WarningFlag};
use tokio::time::{Instant, sleep};

use super::controller::{Controller, Reported};
use crate::watched::{and_not_stopped, at_rest, on_its_way};

/// Speed in device units per (microstep/s), and per 10000 (microstep/s²) of acceleration (Zaber: "maxspeed", "accel").
const UNITS: f64 = 1.6384;

/// A moving axis whose count stays the same for this long has stalled.
const NO_PROGRESS: Duration = Duration::from_secs(1);

/// How far from its target a move may end, in microsteps: an encoder's dither.
const TOLERANCE_STEPS: u64 = 2;

/// Positions within which two or three in a row must fit together.
const MOST_POSITIONS: usize = 8;

/// Between the two equal positions that prove standstill.
const STANDSTILL: Duration = Duration::from_millis(50);

pub(crate) struct ZaberAxis<P> {
    controller: Controller,
    axis: u8,
    settings: AxisSettings<P>,
}

/// A position and what the axis says of itself.
struct State<P> {
    /// Answers in excess when this was asked, and when it was answered.
    surplus: (u64, u64),
    position: AxisPosition<P>,
    flags: Vec<WarningFlag>,
    said: Reported,
}

impl<P> State<P> {
    /// The first flag that forbids to trust the axis, missing reference aside.
    fn fault(&self) -> Option<WarningFlag> {
        self.flags
            .iter()
            .copied()
            .find(|flag| flag.severity() == Severity::Fault && !flag.is_unreferenced())
    }
}

impl<P: Coordinate> ZaberAxis<P> {
    /// Checks the limits and sets speed and acceleration. Moves nothing.
    pub async fn open(controller: Controller, axis: u8, settings: AxisSettings<P>) -> Result<Self, DeviceError> {
        let scale = settings.scale();
        let (own_min, _) = controller.number::<i64>(axis, "get limit.min").await?;
        let (own_max, _) = controller.number::<i64>(axis, "get limit.max").await?;
        let ends = [scale.place(own_min).number(), scale.place(own_max).number()];
        let (from, to) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let (lower, upper) = settings.limit();
        for wanted in [lower, upper] {
            let steps = scale.steps(wanted);
            if steps < own_min || steps > own_max {
                return Err(DeviceError::OutOfTravel {
                    device: format!("{} ({})", controller.name(), P::KEYS[1]),
                    wanted: wanted.number(),
                    from,
                    to,
                    unit: P::UNIT,
                });
            }
        }

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
                return Err(DeviceError::Unsupported {
                    device: controller.name().to_owned(),
                    action: format!("set {name}"),
                    reason: format!(
                        "{key} is below the smallest this axis can do, {}",
                        smallest[i] / scale.steps_per_unit()
                    ),
                });
            }
            controller.ask(axis, &format!("set {name} {units}")).await?;
            let (read, said) = controller.number::<f64>(axis, &format!("get {name}")).await?;
            if read != units {
                return Err(controller.fault(&format!("set {name} {units}"), "it reads back otherwise", said.frame));
            }
            actual[i] = read * smallest[i] / scale.steps_per_unit();
        }
        let settings = AxisSettings::new(*scale, settings.limit(), actual[0], actual[1]);
        let settings = settings.map_err(|error| DeviceError::Unsupported {
            device: controller.name().to_owned(),
            action: "use these settings".to_owned(),
            reason: error.to_string(),
        })?;
        Ok(Self {
            controller,
            axis,
            settings,
        })
    }

    async fn ask(&self, text: &str) -> Result<Reported, DeviceError> {
        self.controller.ask(self.axis, text).await
    }

    /// Count, motion and all flags. The reply carries one flag; only when there is one are all of them asked for.
    async fn state(&self) -> Result<State<P>, DeviceError> {
        let surplus = self.controller.surplus();
        let said = self.ask("get pos").await?;
        let (steps, said) = self.controller.parsed::<i64>("get pos", said)?;
        let at = Instant::now();
        let mut flags: Vec<WarningFlag> = said.flag.into_iter().collect();
        if said.flag.is_some() {
            let all = self.ask("warnings").await?;
            flags.extend(all.data.split(' ').skip(1).filter_map(WarningFlag::parse));
        }
        let homed = !flags.iter().any(WarningFlag::is_unreferenced);
        let position = AxisPosition {
            place: self.settings.scale().place(steps),
            steps,
            moving: said.busy,
            homed,
            at,
        };
        Ok(State {
            surplus: (surplus, self.controller.surplus()),
            position,
            flags,
            said,
        })
    }

    /// Whether two states in a row are those of an axis at rest in one place, with no answer in between that nothing
    /// had asked for.
    fn rests(before: &State<P>, now: &State<P>) -> bool {
        before.surplus.0 == now.surplus.1 && at_rest(&before.position, &now.position, TOLERANCE_STEPS)
    }

    /// Whether three states in a row are those of an axis on its way.
    fn passes(before: &State<P>, between: &State<P>, now: &State<P>) -> bool {
        before.surplus.0 == now.surplus.1 && on_its_way([before, between, now].map(|state| &state.position))
    }

    /// Stops after a failure, and says in `error` when even that could not be verified.
    async fn stopped_because(&self, error: DeviceError) -> DeviceError {
        match self.stop().await {
            Ok(_) => error,
            Err(second) => and_not_stopped(error, second),
        }
    }

    fn refused_by(&self, flag: WarningFlag, action: &str, said: &Reported) -> DeviceError {
        self.controller.fault(
            action,
            format!("{} ({})", flag.letters(), flag.meaning()),
            said.frame.clone(),
        )
    }

    fn timeout(&self, action: &str, waited: Duration, state: &State<P>) -> DeviceError {
        let (device, received) = (self.controller.name().to_owned(), state.said.frame.clone());
        DeviceError::Timeout {
            device,
            action: action.to_owned(),
            waited,
            received,
        }
    }

    /// Waits until two positions in a row are equal and the axis says that it is idle.
    async fn standstill(&self, action: &str, limit: Duration) -> Result<State<P>, DeviceError> {
        let began = Instant::now();
        let mut before = self.state().await?;
        loop {
            sleep(STANDSTILL).await;
            let now = self.state().await?;
            let at_rest = !now.position.moving && !before.position.moving;
            if at_rest && now.position.steps == before.position.steps && before.surplus.0 == now.surplus.1 {
                return Ok(now);
            }
            if began.elapsed() >= limit {
                return Err(self.timeout(action, began.elapsed(), &now));
            }
            before = now;
        }
    }
}

#[async_trait]
impl<P: Coordinate> Axis<P> for ZaberAxis<P> {
    fn identity(&self) -> &Identity {
        self.controller.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        &self.settings
    }

    async fn position(&self) -> Result<AxisPosition<P>, DeviceError> {
        let mut earlier: Option<State<P>> = None;
        let mut before = self.state().await?;
        for _ in 1..MOST_POSITIONS {
            let now = self.state().await?;
            let found = if Self::rests(&before, &now) {
                now
            } else if earlier.is_some_and(|earlier| Self::passes(&earlier, &before, &now)) {
                before
            } else {
                earlier = Some(std::mem::replace(&mut before, now));
                continue;
            };
            return match found.fault() {
                Some(flag) => Err(self.refused_by(flag, "get pos", &found.said)),
                None => Ok(found.position),
            };
        }
        let reason = "no positions in a row fit together: another program moves the axis, or the link is bad";
        Err(self.controller.malformed("get pos", reason, before.said.frame))
    }

    async fn home(&self, deadline: Instant) -> Result<AxisPosition<P>, DeviceError> {
        let began = Instant::now();
        // What is remembered of an earlier stall must not fail this homing; what comes up during it must.
        self.ask("warnings clear").await?;
        self.ask("home").await?;
        loop {
            sleep(Duration::from_millis(100)).await;
            let state = self.state().await?;
            if let Some(flag) = state.fault() {
                let error = self.refused_by(flag, "home", &state.said);
                return Err(self.stopped_because(error).await);
            }
            if !state.position.moving {
                let rest = match self.standstill("home", Duration::from_secs(1)).await {
                    Ok(state) => state.position,
                    Err(error) => return Err(self.stopped_because(error).await),
                };
                if rest.homed {
                    return Ok(rest);
                }
                let reason = "it came to rest without a reference";
                return Err(self.controller.fault("home", reason, state.said.frame));
            }
            if Instant::now() >= deadline {
                let error = self.timeout("home", began.elapsed(), &state);
                return Err(self.stopped_because(error).await);
            }
        }
    }

    async fn start_move(&self, to: P) -> Result<Motion<P>, DeviceError> {
        if !self.settings.allows(to) {
            return Err(self.settings.out_of_travel(self.controller.name(), to.number()));
        }
        let scale = self.settings.scale();
        let target_steps = scale.steps(to);
        let action = format!("move abs {target_steps}");
        let state = self.state().await?;
        if let Some(flag) = state.fault() {
            return Err(self.refused_by(flag, &action, &state.said));
        }
        if !state.position.homed {
            return Err(self
                .controller
                .fault(&action, "no reference: home the axis first", state.said.frame));
        }
        let from_steps = state.position.steps;
        self.ask(&action).await?;
        // A move begun in motion may have to brake and come back: a second ramp covers it.
        let distance = (target_steps - from_steps) as f64 * scale.step();
        let expected = self.settings.duration(distance);
        let deadline = Instant::now() + 2 * expected + Duration::from_secs(2);
        Ok(Motion {
            from_steps,
            target_steps,
            target: scale.place(target_steps),
            expected,
            deadline,
        })
    }

    async fn finish_move(&self, motion: Motion<P>) -> Result<AxisPosition<P>, DeviceError> {
        let action = format!("move abs {}", motion.target_steps);
        let pause = (motion.expected / 16).clamp(Duration::from_millis(10), Duration::from_millis(200));
        let began = Instant::now();
        let mut last = (motion.from_steps, began);
        loop {
            sleep(pause).await;
            let looked = match self.state().await {
                // An axis that has come to rest is asked again: one old reply must not end the move.
                Ok(first) if !first.position.moving && first.fault().is_none() => {
                    self.state().await.map(|now| Self::rests(&first, &now).then_some(now))
                }
                look => look.map(Some),
            };
            let state = match looked {
                Ok(Some(state)) => state,
                Ok(None) if Instant::now() < motion.deadline => continue,
                Ok(None) => {
                    let reason = "no two positions in a row fit together";
                    let error = self.controller.malformed(&action, reason, Vec::new());
                    return Err(self.stopped_because(error).await);
                }
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let position = state.position;
            let error = if let Some(flag) = state.fault() {
                self.refused_by(flag, &action, &state.said)
            } else if !position.homed {
                self.controller
                    .fault(&action, "the reference was lost on the way", state.said.frame)
            } else if !position.moving {
                if position.steps.abs_diff(motion.target_steps) <= TOLERANCE_STEPS {
                    return Ok(position);
                }
                let reason = format!(
                    "it came to rest at {} and not at {}",
                    position.steps, motion.target_steps
                );
                self.controller.fault(&action, reason, state.said.frame)
            } else if position.steps == last.0 && last.1.elapsed() >= NO_PROGRESS {
                let reason = format!(
                    "no progress from {} for {:?}: stalled",
                    position.steps,
                    last.1.elapsed()
                );
                self.controller.fault(&action, reason, state.said.frame)
            } else if Instant::now() >= motion.deadline {
                self.timeout(&action, began.elapsed(), &state)
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
        self.ask("stop").await?;
        let ramp = Duration::try_from_secs_f64(self.settings.speed() / self.settings.acceleration());
        let limit = 2 * ramp.unwrap_or_default() + Duration::from_secs(1);
        match self.standstill("stop", limit).await {
            Ok(state) => Ok(state.position),
            // It does not slow down as it should: cut the ramp.
            Err(DeviceError::Timeout { .. }) => {
                self.ask("estop").await?;
                Ok(self.standstill("estop", Duration::from_secs(1)).await?.position)
            }
            Err(error) => Err(error),
        }
    }
}
