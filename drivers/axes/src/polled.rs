//! An axis that is polled: its moves are followed to their end, whatever language its drive speaks.
//!
//! The languages here have no request numbers, or repeat them: a position is given when two answers in a row show the
//! axis at rest in one place, or when the one between two others lies between them, and no byte arrived in between that
//! nothing had asked for.

use std::marker::PhantomData;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{Axis, AxisPosition, AxisSettings, Coordinate, DeviceError, Identity, Motion};
use isolux_transport::BusError;
use tokio::sync::Mutex;
use tokio::time::{Instant, sleep};

/// A moving axis whose count stays the same for this long has stalled.
const NO_PROGRESS: Duration = Duration::from_secs(1);

/// The longest that a drive takes to show that it has obeyed, where it says so no sooner.
const START: Duration = Duration::from_millis(300);

/// Positions within which two or three in a row must fit together.
const MOST_POSITIONS: usize = 8;

/// Between the two equal positions that prove standstill.
const STANDSTILL: Duration = Duration::from_millis(50);

/// What a drive says of itself at one moment.
pub(crate) struct AxisStatus<P> {
    /// Answers in excess when this was asked, and when it was answered.
    pub unsolicited: (u64, u64),
    pub position: AxisPosition<P>,
    pub frame: Vec<u8>,
    /// What forbids to rely on the axis, a missing reference aside.
    pub fault: Option<String>,
    /// Why an axis at rest takes no target: in the drive's own words where it has no reference, or is not READY.
    pub not_ready: Option<String>,
    /// That the axis rests where nothing has sent it.
    pub displaced: Option<String>,
    /// Why a move is not over although the axis rests, by a drive that says when it is in position.
    pub unsettled: Option<String>,
    /// What ended the last move short of its target.
    pub obstacle: Option<String>,
    /// Why the last search has no reference although the axis rests, by a drive that says when it has found it.
    pub search_failed: Option<String>,
}

impl<P> AxisStatus<P> {
    /// A drive that has nothing to say against itself.
    pub const fn new(unsolicited: (u64, u64), position: AxisPosition<P>, frame: Vec<u8>) -> Self {
        Self {
            unsolicited,
            position,
            frame,
            fault: None,
            not_ready: None,
            displaced: None,
            unsettled: None,
            obstacle: None,
            search_failed: None,
        }
    }
}

/// A drive in its own language.
#[async_trait]
pub(crate) trait AxisDriver<P: Coordinate>: Send + Sync {
    fn identity(&self) -> &Identity;

    fn settings(&self) -> &AxisSettings<P>;

    /// How far from its target a move may end.
    fn tolerance_steps(&self) -> u64;

    async fn status(&self) -> Result<AxisStatus<P>, DeviceError>;

    /// A drive that was sent somewhere and is still where it was after this long has not obeyed.
    fn start_time(&self) -> Duration {
        START
    }

    /// Sets the cruising speed of the moves that follow, at most that of the settings, in °/s or mm/s; the one taken.
    async fn cruise(&self, speed: f64) -> Result<f64, DeviceError> {
        Err(DeviceError::unsupported(
            &self.identity().target,
            format!("move at {speed} {}/s", P::UNIT),
            "this driver sets no speed for one move; sweeps need a drive of the driver zaber",
        ))
    }

    /// Starts a move to `steps`.
    async fn go(&self, steps: i32) -> Result<(), DeviceError>;

    /// Starts the search for the reference. What is remembered of an earlier stall must not fail it.
    async fn go_home(&self) -> Result<(), DeviceError>;

    /// How long an axis rests in the middle of a search at most.
    fn home_rest(&self) -> Duration {
        Duration::ZERO
    }

    /// The search has come to rest at `steps`, after a motion that was seen or without one: proves that it found the
    /// reference.
    async fn at_home(&self, _steps: i64, _moved: bool) -> Result<(), DeviceError> {
        Ok(())
    }

    /// Ends every motion on its ramp.
    async fn brake(&self) -> Result<(), DeviceError>;

    /// Ends every motion where [`brake`](Self::brake) did not.
    async fn cut(&self) -> Result<(), DeviceError>;

    /// At rest after a search or a stop: gives up what holds the axis there.
    async fn release(&self) -> Result<(), DeviceError> {
        Ok(())
    }
}

/// A drive as an axis.
pub(crate) struct PolledAxis<P, D> {
    drive: D,
    /// The cruising speed that the drive has, where it is not that of the settings.
    slowed: Mutex<Option<f64>>,
    place: PhantomData<fn() -> P>,
}

/// The failure of `action` on the drive with this name.
pub(crate) fn fault(name: &str, action: &str, reason: impl Into<String>, evidence: Vec<u8>) -> DeviceError {
    DeviceError::fault(name, action, reason, evidence)
}

/// Refuses limits of the station beyond those that the drive keeps itself, in steps.
pub(crate) fn within_own_limits<P: Coordinate>(
    name: &str,
    settings: &AxisSettings<P>,
    (own_min, own_max): (i64, i64),
) -> Result<(), DeviceError> {
    let scale = settings.scale();
    let (lower, upper) = settings.limit();
    let [a, b] = [own_min, own_max].map(|steps| scale.place(steps).number());
    match [lower, upper]
        .into_iter()
        .find(|wanted| !(own_min..=own_max).contains(&scale.steps(*wanted)))
    {
        None => Ok(()),
        Some(wanted) => Err(DeviceError::OutOfTravel {
            device: format!("{name} ({})", P::KEYS[1]),
            wanted: wanted.number(),
            from: a.min(b),
            to: a.max(b),
            unit: P::UNIT,
        }),
    }
}

/// The settings with the speed and the acceleration that the drive has taken.
pub(crate) fn in_use<P: Coordinate>(
    name: &str,
    settings: &AxisSettings<P>,
    [speed, acceleration]: [f64; 2],
) -> Result<AxisSettings<P>, DeviceError> {
    let used = AxisSettings::new(*settings.scale(), settings.limit(), speed, acceleration);
    used.map_err(|error| DeviceError::unsupported(name, "use these settings", error.to_string()))
}

/// Whether two positions in a row are those of an axis at rest in one place.
fn at_rest<P>(before: &AxisPosition<P>, now: &AxisPosition<P>, tolerance_steps: u64) -> bool {
    let same = before.homed == now.homed && before.steps.abs_diff(now.steps) <= tolerance_steps;
    !before.moving && !now.moving && same
}

/// Whether three positions in a row are those of an axis on its way. If one of the three was an old answer, the axis
/// has still been where the middle one says.
fn on_its_way<P>([a, b, c]: [&AxisPosition<P>; 3]) -> bool {
    let way = a.steps.min(c.steps)..=a.steps.max(c.steps);
    let moving = a.moving && b.moving && c.moving && a.homed == b.homed && b.homed == c.homed;
    moving && way.contains(&b.steps)
}

/// The failure `error`, after which the axis was stopped: with `second` where that could not be verified.
fn and_not_stopped(error: DeviceError, second: DeviceError) -> DeviceError {
    match error {
        DeviceError::Fault {
            device,
            action,
            reason,
            evidence,
        } => DeviceError::fault(
            &device,
            action,
            format!("{reason}; and standstill could not be verified: {second}"),
            evidence,
        ),
        // A lost or silent link: that standstill is unknown follows from the second failure, which is the worse one.
        _ => second,
    }
}

impl<P: Coordinate, D: AxisDriver<P>> PolledAxis<P, D> {
    pub const fn new(drive: D) -> Self {
        Self {
            drive,
            slowed: Mutex::const_new(None),
            place: PhantomData,
        }
    }

    fn name(&self) -> &str {
        &self.drive.identity().target
    }

    fn fault(&self, action: &str, reason: impl Into<String>, status: &AxisStatus<P>) -> DeviceError {
        fault(self.name(), action, reason, status.frame.clone())
    }

    fn timeout(&self, action: &str, waited: Duration, status: &AxisStatus<P>) -> DeviceError {
        let received = status.frame.clone();
        BusError::Timeout { waited, received }.during(self.name(), action)
    }

    /// Whether two answers in a row are those of an axis at rest in one place.
    fn rests(&self, before: &AxisStatus<P>, now: &AxisStatus<P>) -> bool {
        before.unsolicited.0 == now.unsolicited.1
            && at_rest(&before.position, &now.position, self.drive.tolerance_steps())
    }

    /// Whether three answers in a row are those of an axis on its way.
    fn passes(before: &AxisStatus<P>, between: &AxisStatus<P>, now: &AxisStatus<P>) -> bool {
        before.unsolicited.0 == now.unsolicited.1 && on_its_way([before, between, now].map(|status| &status.position))
    }

    /// Stops after a failure, and says in `error` when even that could not be verified.
    async fn stopped_because(&self, error: DeviceError) -> DeviceError {
        match self.stop().await {
            Ok(_) => error,
            Err(second) => and_not_stopped(error, second),
        }
    }

    /// The end of a search that came to rest.
    async fn homed(&self, action: &str, steps: i64, moved: bool) -> Result<AxisPosition<P>, DeviceError> {
        self.drive.at_home(steps, moved).await?;
        let rest = self.standstill(action, NO_PROGRESS).await?;
        if !rest.position.homed {
            return Err(self.fault(action, "it came to rest without a reference", &rest));
        }
        self.drive.release().await.map(|()| rest.position)
    }

    /// Brings the drive to the cruising speed `wanted`, or to that of the settings; the one that it has.
    async fn at_speed(&self, wanted: Option<f64>) -> Result<f64, DeviceError> {
        let full = self.drive.settings().speed();
        let wanted = wanted.filter(|speed| *speed < full);
        let mut slowed = self.slowed.lock().await;
        match (wanted, *slowed) {
            (None, None) => Ok(full),
            (None, Some(_)) => {
                self.drive.cruise(full).await?;
                *slowed = None;
                Ok(full)
            }
            (Some(speed), _) => {
                // Said before it is done: a failure leaves the drive at a speed that nobody knows.
                *slowed = Some(f64::NAN);
                let taken = self.drive.cruise(speed).await?;
                *slowed = Some(taken);
                Ok(taken)
            }
        }
    }

    async fn start(&self, to: P, speed: Option<f64>) -> Result<Motion<P>, DeviceError> {
        let settings = self.drive.settings();
        let scale = settings.scale();
        let target_steps = scale.steps(to);
        let (true, Ok(target)) = (settings.allows(to), i32::try_from(target_steps)) else {
            return Err(settings.out_of_travel(self.name(), to.number()));
        };
        let action = format!("move to {target_steps}");
        let status = self.drive.status().await?;
        let unknown = || {
            let reason = "no reference, or it was without power: home the axis first";
            (!status.position.homed).then(|| reason.to_owned())
        };
        let hindrance = status.fault.clone().or_else(|| status.not_ready.clone());
        if let Some(reason) = hindrance.or_else(unknown).or_else(|| status.displaced.clone()) {
            return Err(self.fault(&action, reason, &status));
        }
        // While the axis rests: a drive may take a speed in the middle of a move.
        let speed = self.at_speed(speed).await?;
        let from_steps = status.position.steps;
        if let Err(error) = self.drive.go(target).await {
            return Err(self.stopped_because(error).await);
        }
        // A move begun in motion may have to brake and come back: a second ramp covers it.
        let distance = (target_steps - from_steps) as f64 * scale.step();
        let expected = settings.duration_at(distance, speed);
        Ok(Motion {
            from_steps,
            target_steps,
            target: scale.place(target_steps),
            speed,
            expected,
            deadline: Instant::now() + 2 * expected + Duration::from_secs(2),
        })
    }

    /// Waits until two answers in a row show the axis at rest in one place.
    async fn standstill(&self, action: &str, limit: Duration) -> Result<AxisStatus<P>, DeviceError> {
        let began = Instant::now();
        let mut before = self.drive.status().await?;
        loop {
            sleep(STANDSTILL).await;
            let now = self.drive.status().await?;
            if self.rests(&before, &now) {
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
impl<P: Coordinate, D: AxisDriver<P>> Axis<P> for PolledAxis<P, D> {
    fn identity(&self) -> &Identity {
        self.drive.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        self.drive.settings()
    }

    async fn position(&self) -> Result<AxisPosition<P>, DeviceError> {
        const ACTION: &str = "read the position";
        let mut earlier: Option<AxisStatus<P>> = None;
        let mut before = self.drive.status().await?;
        for _ in 1..MOST_POSITIONS {
            let now = self.drive.status().await?;
            let found = if self.rests(&before, &now) {
                now
            } else if earlier.is_some_and(|earlier| Self::passes(&earlier, &before, &now)) {
                before
            } else {
                earlier = Some(std::mem::replace(&mut before, now));
                continue;
            };
            return match found.fault.as_ref().or(found.displaced.as_ref()) {
                Some(reason) => Err(self.fault(ACTION, reason.clone(), &found)),
                None => Ok(found.position),
            };
        }
        let reason =
            "no positions in a row fit together: another program moves the axis, or the link is bad".to_owned();
        let frame = before.frame;
        Err(BusError::Malformed { reason, frame }.during(self.name(), ACTION))
    }

    async fn home(&self, deadline: Instant) -> Result<AxisPosition<P>, DeviceError> {
        const ACTION: &str = "home";
        let began = Instant::now();
        self.at_speed(None).await?;
        if let Err(error) = self.drive.go_home().await {
            return Err(self.stopped_because(error).await);
        }
        let (mut moved, mut resting) = (false, None);
        loop {
            sleep(2 * STANDSTILL).await;
            let status = match self.drive.status().await {
                Ok(status) => status,
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let AxisPosition { moving, steps, .. } = status.position;
            moved |= moving;
            resting = resting.filter(|_| !moving).or_else(|| (!moving).then(Instant::now));
            let rests = resting.is_some_and(|since: Instant| since.elapsed() >= self.drive.home_rest());
            let error = if let Some(reason) = &status.fault {
                self.fault(ACTION, reason.clone(), &status)
            } else if Instant::now() >= deadline {
                self.timeout(ACTION, began.elapsed(), &status)
            } else if !rests || began.elapsed() < self.drive.start_time() {
                continue;
            } else if let Some(reason) = &status.search_failed {
                self.fault(ACTION, reason.clone(), &status)
            } else {
                match self.homed(ACTION, steps, moved).await {
                    Ok(position) => return Ok(position),
                    Err(error) => error,
                }
            };
            return Err(self.stopped_because(error).await);
        }
    }

    async fn start_move(&self, to: P) -> Result<Motion<P>, DeviceError> {
        self.start(to, None).await
    }

    async fn start_move_at(&self, to: P, speed: f64) -> Result<Motion<P>, DeviceError> {
        self.start(to, Some(speed)).await
    }

    async fn finish_move(&self, motion: Motion<P>) -> Result<AxisPosition<P>, DeviceError> {
        let action = format!("move to {}", motion.target_steps);
        let pause = (motion.expected / 16).clamp(Duration::from_millis(10), Duration::from_millis(200));
        let began = Instant::now();
        let mut last = (motion.from_steps, began);
        loop {
            sleep(pause).await;
            let looked = match self.drive.status().await {
                // An axis that has come to rest is asked again: one old answer must not end the move.
                Ok(first) if !first.position.moving && first.fault.is_none() => match self.drive.status().await {
                    Ok(now) => Ok((self.rests(&first, &now), now)),
                    Err(error) => Err(error),
                },
                other => other.map(|status| (false, status)),
            };
            let (rests, status) = match looked {
                Ok(looked) => looked,
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let position = status.position;
            let off = position.steps.abs_diff(motion.target_steps);
            let ended = rests && status.unsettled.is_none();
            let error = if let Some(reason) = &status.fault {
                self.fault(&action, reason.clone(), &status)
            } else if !position.homed {
                self.fault(&action, "the reference was lost on the way", &status)
            } else if ended && off <= self.drive.tolerance_steps() {
                return Ok(position);
            } else if let (true, Some(obstacle)) = (ended, &status.obstacle) {
                self.fault(&action, format!("{obstacle}: at rest at {}", position.steps), &status)
            } else if ended && (position.steps != motion.from_steps || began.elapsed() >= self.drive.start_time()) {
                let reason = format!(
                    "it came to rest at {} and not at {}",
                    position.steps, motion.target_steps
                );
                self.fault(&action, reason, &status)
            } else if position.steps == last.0 && last.1.elapsed() >= NO_PROGRESS {
                let waited = last.1.elapsed();
                let stalled = || format!("no progress from {} for {waited:?}: stalled", position.steps);
                let unsettled = status.unsettled.clone().filter(|_| !position.moving);
                self.fault(&action, unsettled.unwrap_or_else(stalled), &status)
            } else if Instant::now() >= motion.deadline {
                self.timeout(&action, began.elapsed(), &status)
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
        self.drive.brake().await?;
        let settings = self.drive.settings();
        let ramp = Duration::try_from_secs_f64(settings.speed() / settings.acceleration());
        let limit = 2 * ramp.unwrap_or_default() + Duration::from_secs(1);
        let rest = match self.standstill("stop", limit).await {
            // It does not slow down as it should.
            Err(DeviceError::Timeout { .. }) => {
                self.drive.cut().await?;
                self.standstill("stop without ramp", limit).await?
            }
            rest => rest?,
        };
        // An axis at rest may stay held; it would only refuse the next move, which says so.
        if let Err(error) = self.drive.release().await {
            tracing::warn!(%error, "the axis stays held after its stop");
        }
        Ok(rest.position)
    }
}
