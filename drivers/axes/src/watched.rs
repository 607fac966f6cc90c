//! An axis whose moves are watched to their end, whatever language its drive speaks.
//!
//! The languages here have no request numbers: a position is given when two looks in a row show the axis at rest in one
//! place, or when the one between two others lies between them, and no byte arrived in between that nothing had asked
//! for.

use std::marker::PhantomData;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{Axis, AxisPosition, AxisSettings, Coordinate, DeviceError, Identity, Motion};
use isolux_transport::BusError;
use tokio::time::{Instant, sleep};

/// A moving axis whose count stays the same for this long has stalled.
const NO_PROGRESS: Duration = Duration::from_secs(1);

/// A drive that was sent somewhere and is still where it was after this long has not obeyed.
const START: Duration = Duration::from_millis(300);

/// Positions within which two or three in a row must fit together.
const MOST_POSITIONS: usize = 8;

/// Between the two equal positions that prove standstill.
const STANDSTILL: Duration = Duration::from_millis(50);

/// What a drive says of itself at one moment.
pub(crate) struct Look<P> {
    /// Answers in excess when this was asked, and when it was answered.
    pub unsolicited: (u64, u64),
    pub position: AxisPosition<P>,
    /// What forbids to trust the axis, a missing reference aside.
    pub fault: Option<String>,
    /// What ended the last move short of its target.
    pub obstacle: Option<String>,
    pub frame: Vec<u8>,
}

/// A drive in its own language.
#[async_trait]
pub(crate) trait Drive<P: Coordinate>: Send + Sync {
    fn identity(&self) -> &Identity;

    fn settings(&self) -> &AxisSettings<P>;

    /// How far from its target a move may end.
    fn tolerance_steps(&self) -> u64;

    async fn look(&self) -> Result<Look<P>, DeviceError>;

    /// Starts a move to `steps`.
    async fn go(&self, steps: i64) -> Result<(), DeviceError>;

    /// Starts the search for the reference.
    async fn go_home(&self) -> Result<(), DeviceError>;

    /// The search has come to rest: proves that it found the reference.
    async fn at_home(&self) -> Result<(), DeviceError>;

    /// Ends every motion on its ramp.
    async fn brake(&self) -> Result<(), DeviceError>;

    /// Ends every motion at once.
    async fn cut(&self) -> Result<(), DeviceError>;
}

/// A drive as an axis.
pub(crate) struct Watched<P, D>(D, PhantomData<fn() -> P>);

/// The failure of `action` on the drive with this name.
pub(crate) fn fault(name: &str, action: &str, reason: impl Into<String>, evidence: Vec<u8>) -> DeviceError {
    DeviceError::Fault {
        device: name.to_owned(),
        action: action.to_owned(),
        reason: reason.into(),
        evidence,
    }
}

/// Whether two positions in a row are those of an axis at rest in one place.
pub(crate) fn at_rest<P>(before: &AxisPosition<P>, now: &AxisPosition<P>, tolerance_steps: u64) -> bool {
    let same = before.homed == now.homed && before.steps.abs_diff(now.steps) <= tolerance_steps;
    !before.moving && !now.moving && same
}

/// Whether three positions in a row are those of an axis on its way. If one of the three was an old answer, the axis
/// has still been where the middle one says.
pub(crate) fn on_its_way<P>([a, b, c]: [&AxisPosition<P>; 3]) -> bool {
    let way = a.steps.min(c.steps)..=a.steps.max(c.steps);
    let moving = a.moving && b.moving && c.moving && a.homed == b.homed && b.homed == c.homed;
    moving && way.contains(&b.steps)
}

/// The failure `error`, after which the axis was stopped: with `second` where that could not be verified.
pub(crate) fn and_not_stopped(error: DeviceError, second: DeviceError) -> DeviceError {
    match error {
        DeviceError::Fault {
            device,
            action,
            reason,
            evidence,
        } => DeviceError::Fault {
            device,
            action,
            reason: format!("{reason}; and standstill could not be verified: {second}"),
            evidence,
        },
        // A lost or silent link: that standstill is unknown follows from the second failure, which is the worse one.
        _ => second,
    }
}

impl<P: Coordinate, D: Drive<P>> Watched<P, D> {
    pub const fn new(drive: D) -> Self {
        Self(drive, PhantomData)
    }

    fn name(&self) -> &str {
        &self.0.identity().target
    }

    fn fault(&self, action: &str, reason: impl Into<String>, look: &Look<P>) -> DeviceError {
        fault(self.name(), action, reason, look.frame.clone())
    }

    fn timeout(&self, action: &str, waited: Duration, look: &Look<P>) -> DeviceError {
        let received = look.frame.clone();
        BusError::Timeout { waited, received }.during(self.name(), action)
    }

    /// Whether two looks in a row are those of an axis at rest in one place.
    fn rests(&self, before: &Look<P>, now: &Look<P>) -> bool {
        before.unsolicited.0 == now.unsolicited.1 && at_rest(&before.position, &now.position, self.0.tolerance_steps())
    }

    /// Whether three looks in a row are those of an axis on its way.
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
        let mut before = self.0.look().await?;
        loop {
            sleep(STANDSTILL).await;
            let now = self.0.look().await?;
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
impl<P: Coordinate, D: Drive<P>> Axis<P> for Watched<P, D> {
    fn identity(&self) -> &Identity {
        self.0.identity()
    }

    fn settings(&self) -> &AxisSettings<P> {
        self.0.settings()
    }

    async fn position(&self) -> Result<AxisPosition<P>, DeviceError> {
        const ACTION: &str = "read the position";
        let mut earlier: Option<Look<P>> = None;
        let mut before = self.0.look().await?;
        for _ in 1..MOST_POSITIONS {
            let now = self.0.look().await?;
            let found = if self.rests(&before, &now) {
                now
            } else if earlier.is_some_and(|earlier| Self::passes(&earlier, &before, &now)) {
                before
            } else {
                earlier = Some(std::mem::replace(&mut before, now));
                continue;
            };
            return match &found.fault {
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
        if let Err(error) = self.0.go_home().await {
            return Err(self.stopped_because(error).await);
        }
        loop {
            sleep(2 * STANDSTILL).await;
            let look = match self.0.look().await {
                Ok(look) => look,
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let error = if let Some(reason) = &look.fault {
                self.fault(ACTION, reason.clone(), &look)
            } else if Instant::now() >= deadline {
                self.timeout(ACTION, began.elapsed(), &look)
            } else if look.position.moving || began.elapsed() < START {
                continue;
            } else {
                match self.0.at_home().await {
                    Ok(()) => match self.standstill(ACTION, NO_PROGRESS).await {
                        Ok(rest) if rest.position.homed => return Ok(rest.position),
                        Ok(rest) => self.fault(ACTION, "it came to rest without a reference", &rest),
                        Err(error) => error,
                    },
                    Err(error) => error,
                }
            };
            return Err(self.stopped_because(error).await);
        }
    }

    async fn start_move(&self, to: P) -> Result<Motion<P>, DeviceError> {
        let settings = self.0.settings();
        let scale = settings.scale();
        let target_steps = scale.steps(to);
        if !settings.allows(to) || i32::try_from(target_steps).is_err() {
            return Err(settings.out_of_travel(self.name(), to.number()));
        }
        let action = format!("move to {target_steps}");
        let look = self.0.look().await?;
        if let Some(reason) = &look.fault {
            return Err(self.fault(&action, reason.clone(), &look));
        }
        if !look.position.homed {
            return Err(self.fault(
                &action,
                "no reference, or it was without power: home the axis first",
                &look,
            ));
        }
        let from_steps = look.position.steps;
        if let Err(error) = self.0.go(target_steps).await {
            return Err(self.stopped_because(error).await);
        }
        // A move begun in motion may have to brake and come back: a second ramp covers it.
        let distance = (target_steps - from_steps) as f64 * scale.step();
        let expected = settings.duration(distance);
        Ok(Motion {
            from_steps,
            target_steps,
            target: scale.place(target_steps),
            expected,
            deadline: Instant::now() + 2 * expected + Duration::from_secs(2),
        })
    }

    async fn finish_move(&self, motion: Motion<P>) -> Result<AxisPosition<P>, DeviceError> {
        let action = format!("move to {}", motion.target_steps);
        let pause = (motion.expected / 16).clamp(Duration::from_millis(10), Duration::from_millis(200));
        let began = Instant::now();
        let mut last = (motion.from_steps, began);
        loop {
            sleep(pause).await;
            let looked = match self.0.look().await {
                // An axis that has come to rest is looked at again: one old answer must not end the move.
                Ok(first) if !first.position.moving && first.fault.is_none() => match self.0.look().await {
                    Ok(now) => Ok((self.rests(&first, &now), now)),
                    Err(error) => Err(error),
                },
                other => other.map(|look| (false, look)),
            };
            let (rests, look) = match looked {
                Ok(looked) => looked,
                Err(error) => return Err(self.stopped_because(error).await),
            };
            let position = look.position;
            let off = position.steps.abs_diff(motion.target_steps);
            let error = if let Some(reason) = &look.fault {
                self.fault(&action, reason.clone(), &look)
            } else if !position.homed {
                self.fault(&action, "the reference was lost on the way", &look)
            } else if rests && off <= self.0.tolerance_steps() {
                return Ok(position);
            } else if let (true, Some(obstacle)) = (rests, &look.obstacle) {
                self.fault(&action, format!("{obstacle}: at rest at {}", position.steps), &look)
            } else if rests && (position.steps != motion.from_steps || began.elapsed() >= START) {
                let reason = format!(
                    "it came to rest at {} and not at {}",
                    position.steps, motion.target_steps
                );
                self.fault(&action, reason, &look)
            } else if position.steps == last.0 && last.1.elapsed() >= NO_PROGRESS {
                let reason = format!(
                    "no progress from {} for {:?}: stalled",
                    position.steps,
                    last.1.elapsed()
                );
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
        self.0.brake().await?;
        let settings = self.0.settings();
        let ramp = Duration::try_from_secs_f64(settings.speed() / settings.acceleration());
        let limit = 2 * ramp.unwrap_or_default() + Duration::from_secs(1);
        match self.standstill("stop", limit).await {
            Ok(look) => Ok(look.position),
            // It does not slow down as it should: cut the ramp.
            Err(DeviceError::Timeout { .. }) => {
                self.0.cut().await?;
                Ok(self
                    .standstill("stop without ramp", Duration::from_secs(1))
                    .await?
                    .position)
            }
            Err(error) => Err(error),
        }
    }
}
