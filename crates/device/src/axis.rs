//! A motor axis.

use std::time::Duration;

use async_trait::async_trait;
use isolux_units::AxisAngle;
use tokio::time::Instant;

use crate::axis_scale::AxisScale;
use crate::{DeviceError, Identity};

/// A motor axis that knows its angle.
#[async_trait]
pub trait Axis: Send + Sync {
    /// What the axis said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// Scale, limits and dynamics in use.
    fn settings(&self) -> &AxisSettings;

    /// Where the axis is now, by its own count.
    ///
    /// # Errors
    /// Any link error; [`Fault`](DeviceError::Fault) when the axis reports one (stall, no power, critical flag). A missing
    /// reference is no error here: it is `homed == false`.
    async fn position(&self) -> Result<AxisPosition, DeviceError>;

    /// Finds the reference, comes to rest, and makes the step count true. Moves the axis.
    ///
    /// # Errors
    /// [`Timeout`](DeviceError::Timeout) when the reference is not found by `deadline` (the axis is stopped first).
    async fn home(&self, deadline: Instant) -> Result<AxisPosition, DeviceError>;

    /// Starts a move to the step nearest to `to` and returns at once.
    ///
    /// # Errors
    /// [`OutOfTravel`](DeviceError::OutOfTravel) outside [`AxisSettings::limit`]; [`Fault`](DeviceError::Fault) without a
    /// reference. Nothing moves then.
    async fn start_move(&self, to: AxisAngle) -> Result<Motion, DeviceError>;

    /// Waits until `motion` has ended *at its target*, watching that the axis makes progress.
    ///
    /// # Errors
    /// [`Fault`](DeviceError::Fault) when it stalls, hits a limit or ends elsewhere; [`Timeout`](DeviceError::Timeout) past
    /// [`Motion::deadline`]. The axis is stopped before the error is returned.
    async fn finish_move(&self, motion: Motion) -> Result<AxisPosition, DeviceError>;

    /// Stops the axis from any state and verifies by two equal positions that it stands still.
    ///
    /// # Errors
    /// Any error means: *not verified at rest*.
    async fn stop(&self) -> Result<AxisPosition, DeviceError>;

    /// Moves to the step nearest to `to` and waits: [`start_move`](Self::start_move), then [`finish_move`](Self::finish_move).
    ///
    /// # Errors
    /// Those of both.
    async fn move_to(&self, to: AxisAngle) -> Result<AxisPosition, DeviceError> {
        let motion = self.start_move(to).await?;
        self.finish_move(motion).await
    }
}

/// Where an axis is, read back from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPosition {
    /// The angle, by the station's scale.
    pub angle: AxisAngle,
    /// The axis' own count.
    pub steps: i64,
    /// The axis says that it is moving.
    pub moving: bool,
    /// The axis has a reference since power-on: the angle is true.
    pub homed: bool,
    /// When the answer arrived.
    pub at: Instant,
}

/// A move that was started.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Count at the start.
    pub from_steps: i64,
    /// Count at the end.
    pub target_steps: i64,
    /// The angle at `target_steps`: what will be read back, not what was asked.
    pub target: AxisAngle,
    /// How long distance, speed and acceleration say that it takes.
    pub expected: Duration,
    /// When to give up: twice the expected time and two seconds (cf. ophyd-async, distance/velocity + 2·acceleration + 10 s).
    pub deadline: Instant,
}

/// Scale, limits and dynamics of an axis, from the station file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisSettings {
    scale: AxisScale,
    limit: (AxisAngle, AxisAngle),
    speed_deg_s: f64,
    accel_deg_s2: f64,
}

/// Why the settings of an axis were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvalidSettings {
    /// Limits the wrong way round.
    #[error("limit_deg = [{from_deg}, {to_deg}]: the first must be below the second")]
    Limit {
        /// First limit.
        from_deg: f64,
        /// Second limit.
        to_deg: f64,
    },
    /// A speed or an acceleration that is not a positive number.
    #[error("{key} = {value}: must be above zero")]
    NotPositive {
        /// Key of the station file.
        key: &'static str,
        /// Its value.
        value: f64,
    },
}

impl AxisSettings {
    /// Checked settings: `limit` rising, speed in °/s and acceleration in °/s² above zero.
    ///
    /// # Errors
    /// [`InvalidSettings`] names the key.
    pub fn new(
        scale: AxisScale,
        limit: (AxisAngle, AxisAngle),
        speed_deg_s: f64,
        accel_deg_s2: f64,
    ) -> Result<Self, InvalidSettings> {
        if limit.0 >= limit.1 {
            return Err(InvalidSettings::Limit {
                from_deg: limit.0.value(),
                to_deg: limit.1.value(),
            });
        }
        for (key, value) in [("speed_deg_s", speed_deg_s), ("accel_deg_s2", accel_deg_s2)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InvalidSettings::NotPositive { key, value });
            }
        }
        Ok(Self {
            scale,
            limit,
            speed_deg_s,
            accel_deg_s2,
        })
    }

    /// Steps ⇄ degrees.
    pub const fn scale(&self) -> &AxisScale {
        &self.scale
    }

    /// Lower and upper limit of travel.
    pub const fn limit(&self) -> (AxisAngle, AxisAngle) {
        self.limit
    }

    /// Cruising speed in °/s.
    pub const fn speed_deg_s(&self) -> f64 {
        self.speed_deg_s
    }

    /// Acceleration in °/s².
    pub const fn accel_deg_s2(&self) -> f64 {
        self.accel_deg_s2
    }

    /// Whether `angle` lies within the travel. A limit itself is inside, and half a step of rounding is forgiven.
    pub fn allows(&self, angle: AxisAngle) -> bool {
        let slack = self.scale.step_deg() / 2.0;
        angle.value() >= self.limit.0.value() - slack && angle.value() <= self.limit.1.value() + slack
    }

    /// Time of a move over `distance_deg`: trapezoidal, or triangular when the cruising speed is not reached.
    pub fn duration(&self, distance_deg: f64) -> Duration {
        let distance = distance_deg.abs();
        let ramp = self.speed_deg_s * self.speed_deg_s / self.accel_deg_s2;
        let seconds = if distance < ramp {
            2.0 * (distance / self.accel_deg_s2).sqrt()
        } else {
            distance / self.speed_deg_s + self.speed_deg_s / self.accel_deg_s2
        };
        // A move of millennia is a typing error in the station; a day is already an alarm.
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::from_secs(24 * 3600))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sense;

    fn angle(degrees: f64) -> AxisAngle {
        AxisAngle::new(degrees).unwrap()
    }

    fn settings(speed: f64, accel: f64) -> Result<AxisSettings, InvalidSettings> {
        let scale = AxisScale::new(100, 1, angle(0.0), Sense::Positive).unwrap();
        AxisSettings::new(scale, (angle(-180.0), angle(180.0)), speed, accel)
    }

    #[test]
    fn a_move_takes_what_mechanics_says() {
        let axis = settings(10.0, 20.0).unwrap();
        // 10 °/s reached after 0.5 s and 2.5°: 100° = 5° of ramps + 95° of cruise.
        assert_eq!(axis.duration(100.0), Duration::from_secs_f64(10.5));
        // 5° is just both ramps, 1.25° a triangle.
        assert_eq!(axis.duration(5.0), Duration::from_secs(1));
        assert_eq!(axis.duration(-1.25), Duration::from_millis(500));
        assert_eq!(axis.duration(0.0), Duration::ZERO);
    }

    #[test]
    fn refuses_what_cannot_be() {
        assert!(matches!(
            settings(0.0, 1.0),
            Err(InvalidSettings::NotPositive { key: "speed_deg_s", .. })
        ));
        assert!(matches!(
            settings(1.0, f64::NAN),
            Err(InvalidSettings::NotPositive {
                key: "accel_deg_s2",
                ..
            })
        ));
        let axis = settings(1.0, 1.0).unwrap();
        assert!(axis.allows(angle(180.0)) && axis.allows(angle(-180.004)));
        assert!(!axis.allows(angle(180.006)));
    }
}
