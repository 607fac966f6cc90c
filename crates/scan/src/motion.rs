//! Moving both axes, waiting until they rest where they were sent, and stopping them.

mod sweep;

use std::time::Duration;

use isolux_device::{Axis, AxisPosition, Coordinate, DeviceError, ErrorKind, awake};
use isolux_record::Station;
use isolux_units::{AxisAngle, Millimetre};
use tokio::time::{Instant, sleep};

use crate::devices::Devices;
use crate::error::ScanError;

/// Consecutive positions within tolerance, at rest, before a move counts as done.
const POSITIONS_IN_TOLERANCE: u32 = 3;
const BETWEEN_POSITIONS: Duration = Duration::from_millis(50);
/// A driver ends a move by its own deadline; this much later it is taken for dead.
const DRIVER_GRACE: Duration = Duration::from_secs(5);
/// How long a stop may take to be verified before it counts as failed.
const STOP_WITHIN: Duration = Duration::from_secs(30);

/// Both axes at rest, read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// C in degrees.
    pub c_deg: f64,
    /// γ in degrees, signed.
    pub gamma_deg: f64,
    /// Since when they rest: light after this moment is light of this pose.
    pub rest_at: Instant,
}

/// Both axes, moved together.
pub struct Axes<'a> {
    c: &'a dyn Axis,
    gamma: &'a dyn Axis,
    tolerance_c_deg: f64,
    tolerance_gamma_deg: f64,
    travel: i8,
    target: Option<(f64, f64)>,
    homed: bool,
}

impl<'a> Axes<'a> {
    /// The axes of `devices`, with the tolerances of `station`. Their last direction of travel is not known.
    pub fn new(devices: &'a Devices, station: &Station) -> Self {
        Self {
            c: devices.axis_c.as_ref(),
            gamma: devices.axis_gamma.as_ref(),
            tolerance_c_deg: station.axis_c().tolerance_deg(),
            tolerance_gamma_deg: station.axis_gamma().tolerance_deg(),
            travel: 0,
            target: None,
            homed: false,
        }
    }

    /// Where the axes were last sent, (C, γ) in degrees; none after homing and while a move has not ended well.
    pub fn target(&self) -> Option<(f64, f64)> {
        self.target
    }

    /// Verifies that both axes still rest where they were sent.
    ///
    /// # Errors
    /// [`ScanError::Disturbed`] for an axis that moves, stands elsewhere or has lost its reference; what the drives
    /// report.
    pub async fn hold(&self) -> Result<(), ScanError> {
        if let Some((c_deg, gamma_deg)) = self.target {
            holds("axis.c", self.c, (c_deg, self.tolerance_c_deg)).await?;
            holds("axis.gamma", self.gamma, (gamma_deg, self.tolerance_gamma_deg)).await?;
        }
        Ok(())
    }

    /// Sign of the last non-zero γ motion, held through C moves and repeats; 0 before the first and after homing.
    pub fn travel(&self) -> i8 {
        self.travel
    }

    /// Homes both axes, γ first: the luminaire then hangs as the mount expects it before it is turned.
    ///
    /// # Errors
    /// What the drives report.
    pub async fn home(&mut self) -> Result<Pose, ScanError> {
        (self.travel, self.target) = (0, None);
        for (role, axis) in [("axis.gamma", self.gamma), ("axis.c", self.c)] {
            let settings = axis.settings();
            let way = settings.limit().1.value() - settings.limit().0.value();
            // Out to the switch and back slowly: several times the whole travel, and a minute for the search itself.
            let deadline = Instant::now() + 5 * settings.duration(way) + Duration::from_mins(1);
            let homed = awake::until(deadline + DRIVER_GRACE, axis.home(deadline)).await;
            let position = homed
                .ok_or_else(|| dead(role, axis, "home"))?
                .map_err(ScanError::device(role))?;
            if !position.homed {
                let source = DeviceError::fault(
                    &axis.identity().target,
                    "home",
                    "the axis says that it has no reference after homing",
                    Vec::new(),
                );
                return Err(ScanError::Device { role, source });
            }
        }
        self.homed = true;
        self.pose().await
    }

    /// Homes both axes where one of them had its reference and has lost it; whether that was so.
    ///
    /// # Errors
    /// What the drives report.
    pub async fn home_if_lost(&mut self) -> Result<bool, ScanError> {
        let c = self.c.position().await.map_err(ScanError::device("axis.c"))?;
        let gamma = self.gamma.position().await.map_err(ScanError::device("axis.gamma"))?;
        let lost = self.homed && !(c.homed && gamma.homed);
        if lost {
            self.home().await?;
        }
        Ok(lost)
    }

    /// Where the axes are now.
    ///
    /// # Errors
    /// What the drives report.
    pub async fn pose(&self) -> Result<Pose, ScanError> {
        let c = self.c.position().await.map_err(ScanError::device("axis.c"))?;
        let gamma = self.gamma.position().await.map_err(ScanError::device("axis.gamma"))?;
        Ok(Pose {
            c_deg: c.place.value(),
            gamma_deg: gamma.place.value(),
            rest_at: c.at.max(gamma.at),
        })
    }

    /// Moves both axes at once and returns when both have rested within tolerance of their targets for
    /// several consecutive positions.
    ///
    /// # Errors
    /// What the drives report; [`ScanError::Position`] when an axis rests elsewhere.
    pub async fn go_to(&mut self, c_deg: f64, gamma_deg: f64) -> Result<Pose, ScanError> {
        let angle = |role: &'static str, axis: &dyn Axis, degrees: f64| {
            AxisAngle::new(degrees).map_err(|_| ScanError::Device {
                role,
                source: axis.settings().out_of_travel(&axis.identity().target, degrees),
            })
        };
        let to_c = angle("axis.c", self.c, c_deg)?;
        let to_gamma = angle("axis.gamma", self.gamma, gamma_deg)?;
        self.target = None;
        let motion_c = self.c.start_move(to_c).await.map_err(ScanError::device("axis.c"))?;
        let motion_gamma = self
            .gamma
            .start_move(to_gamma)
            .await
            .map_err(ScanError::device("axis.gamma"))?;
        let scale = self.gamma.settings().scale();
        let way = motion_gamma.target.value() - scale.place(motion_gamma.from_steps).value();
        if motion_gamma.target_steps != motion_gamma.from_steps {
            self.travel = if way > 0.0 { 1 } else { -1 };
        }
        let finish_c = awake::until(motion_c.deadline + DRIVER_GRACE, self.c.finish_move(motion_c));
        let finish_gamma = awake::until(
            motion_gamma.deadline + DRIVER_GRACE,
            self.gamma.finish_move(motion_gamma),
        );
        let (done_c, done_gamma) = tokio::join!(finish_c, finish_gamma);
        done_c
            .ok_or_else(|| dead("axis.c", self.c, "finish a move"))?
            .map_err(ScanError::device("axis.c"))?;
        done_gamma
            .ok_or_else(|| dead("axis.gamma", self.gamma, "finish a move"))?
            .map_err(ScanError::device("axis.gamma"))?;
        let deadline = motion_c.deadline.max(motion_gamma.deadline) + DRIVER_GRACE;
        let target = (motion_c.target.value(), motion_gamma.target.value());
        let pose = self.rest_at(target, deadline).await?;
        self.target = Some(target);
        Ok(pose)
    }

    async fn rest_at(&self, target: (f64, f64), deadline: Instant) -> Result<Pose, ScanError> {
        let mut since: Option<Instant> = None;
        let mut in_tolerance = 0;
        loop {
            let c = self.c.position().await.map_err(ScanError::device("axis.c"))?;
            let gamma = self.gamma.position().await.map_err(ScanError::device("axis.gamma"))?;
            let near = |position: &AxisPosition, target: f64, tolerance: f64| {
                !position.moving && (position.place.value() - target).abs() <= tolerance
            };
            let at_rest = near(&c, target.0, self.tolerance_c_deg) && near(&gamma, target.1, self.tolerance_gamma_deg);
            if at_rest {
                in_tolerance += 1;
                let rest_at = *since.get_or_insert(c.at.max(gamma.at));
                if in_tolerance == POSITIONS_IN_TOLERANCE {
                    return Ok(Pose {
                        c_deg: c.place.value(),
                        gamma_deg: gamma.place.value(),
                        rest_at,
                    });
                }
            } else {
                (since, in_tolerance) = (None, 0);
                if Instant::now() > deadline {
                    let (role, target, found, tolerance) = if near(&c, target.0, self.tolerance_c_deg) {
                        ("axis.gamma", target.1, gamma.place.value(), self.tolerance_gamma_deg)
                    } else {
                        ("axis.c", target.0, c.place.value(), self.tolerance_c_deg)
                    };
                    return Err(ScanError::Position {
                        role,
                        target,
                        found,
                        tolerance,
                        unit: <AxisAngle as Coordinate>::UNIT,
                    });
                }
            }
            sleep(BETWEEN_POSITIONS).await;
        }
    }
}

/// Stops everything that can move, from any state, and verifies that it stands still. All are told at once: one that
/// does not answer must not keep another running.
///
/// # Errors
/// The axes that could not be verified at rest, and why.
pub async fn stop_all(devices: &Devices) -> Result<(), Vec<(&'static str, DeviceError)>> {
    let rail = async {
        match devices.rail.as_deref() {
            Some(rail) => stop("rail", rail).await.map(drop),
            None => Ok(()),
        }
    };
    let (c, gamma, rail) = tokio::join!(
        stop("axis.c", devices.axis_c.as_ref()),
        stop("axis.gamma", devices.axis_gamma.as_ref()),
        rail
    );
    let failed: Vec<_> = c.err().into_iter().chain(gamma.err()).chain(rail.err()).collect();
    if failed.is_empty() { Ok(()) } else { Err(failed) }
}

/// Drives the detector's carriage and verifies where it rests; the distance that was read back, in mm.
///
/// # Errors
/// What the drive reports; [`ScanError::Position`] when it rests elsewhere.
pub async fn drive_rail(rail: &dyn Axis<Millimetre>, distance_mm: f64) -> Result<f64, ScanError> {
    let tolerance = rail_tolerance_mm(rail);
    let elsewhere = |found: f64| ScanError::Position {
        role: "rail",
        target: distance_mm,
        found,
        tolerance,
        unit: <Millimetre as Coordinate>::UNIT,
    };
    let to = Millimetre::new(distance_mm).map_err(|_| elsewhere(f64::NAN))?;
    let motion = rail.start_move(to).await.map_err(ScanError::device("rail"))?;
    let finished = awake::until(motion.deadline + DRIVER_GRACE, rail.finish_move(motion)).await;
    finished
        .ok_or_else(|| dead("rail", rail, "finish a move"))?
        .map_err(ScanError::device("rail"))?;
    let position = rail.position().await.map_err(ScanError::device("rail"))?;
    let found = position.place.value();
    if position.moving || (found - distance_mm).abs() > tolerance {
        return Err(elsewhere(found));
    }
    Ok(found)
}

/// Verifies that the detector's carriage still rests where it was sent.
///
/// # Errors
/// [`ScanError::Disturbed`] if it moves or stands elsewhere; what the drive reports.
pub async fn rail_holds(rail: &dyn Axis<Millimetre>, distance_mm: f64) -> Result<(), ScanError> {
    holds("rail", rail, (distance_mm, rail_tolerance_mm(rail))).await
}

fn rail_tolerance_mm(rail: &dyn Axis<Millimetre>) -> f64 {
    0.05_f64.max(1.5 * rail.settings().scale().step())
}

async fn holds<P: Coordinate>(
    role: &'static str,
    axis: &dyn Axis<P>,
    (target, tolerance): (f64, f64),
) -> Result<(), ScanError> {
    let unit = <P as Coordinate>::UNIT;
    let mut looks = 0;
    loop {
        let position = axis.position().await.map_err(ScanError::device(role))?;
        let found = position.place.number();
        let state = if position.moving {
            "moving at"
        } else if !position.homed {
            "without its reference at"
        } else if (found - target).abs() <= tolerance {
            return Ok(());
        } else {
            "at"
        };
        looks += 1;
        // An encoder may flicker out of tolerance for one look; what moves, and what stays outside, was moved.
        if position.moving || !position.homed || looks == POSITIONS_IN_TOLERANCE {
            return Err(ScanError::Disturbed {
                role,
                expected: format!("at {target:.3}{unit}"),
                found: format!("{state} {found:.3}{unit}"),
            });
        }
        sleep(BETWEEN_POSITIONS).await;
    }
}

/// Stops one axis from any state and verifies that it stands still; where.
///
/// # Errors
/// Its role, and why it could not be verified at rest.
pub async fn stop<P: Coordinate>(
    role: &'static str,
    axis: &dyn Axis<P>,
) -> Result<AxisPosition<P>, (&'static str, DeviceError)> {
    let mut deadline = Instant::now() + STOP_WITHIN;
    loop {
        if awake::missed(deadline) {
            // Nobody waited for the axis meanwhile.
            deadline = Instant::now() + STOP_WITHIN;
        }
        let error = match awake::until(deadline, axis.stop()).await {
            Some(Ok(position)) if !position.moving => return Ok(position),
            Some(Ok(_)) => DeviceError::fault(
                &axis.identity().target,
                "stop",
                "the axis says that it still moves",
                Vec::new(),
            ),
            Some(Err(error)) => error,
            None => {
                let device = axis.identity().target.clone();
                return Err((
                    role,
                    DeviceError::Timeout {
                        device,
                        action: "stop".to_owned(),
                        waited: STOP_WITHIN,
                        received: Vec::new(),
                    },
                ));
            }
        };
        // A damaged or late answer may hide a good stop: ask again while there is time. A lost link is never opened
        // again: report it at once, because only a person can still stop the axis.
        let again = matches!(
            error.kind(),
            ErrorKind::Timeout | ErrorKind::Malformed | ErrorKind::Fault
        );
        let over = Instant::now() + Duration::from_secs(1) > deadline && !awake::missed(deadline);
        if !again || over {
            return Err((role, error));
        }
        sleep(Duration::from_secs(1)).await;
    }
}

fn dead<P: Coordinate>(role: &'static str, axis: &dyn Axis<P>, action: &str) -> ScanError {
    let device = axis.identity().target.clone();
    let source = DeviceError::Timeout {
        device,
        action: action.to_owned(),
        waited: DRIVER_GRACE,
        received: Vec::new(),
    };
    ScanError::Device { role, source }
}
