//! A motor axis.

use std::time::Duration;

use async_trait::async_trait;
use isolux_units::AxisAngle;
use tokio::time::Instant;

use crate::axis_scale::{AxisScale, Coordinate};
use crate::{DeviceError, Identity};

/// A motor axis that knows its position: an angle, or millimetres along a rail (`Axis<Millimetre>`).
#[async_trait]
pub trait Axis<P: Coordinate = AxisAngle>: Send + Sync {
    /// What the axis said of itself when it was opened.
    fn identity(&self) -> &Identity;

    /// Scale, limits and dynamics in use.
    fn settings(&self) -> &AxisSettings<P>;

    /// Where the axis is now, by its own count.
    ///
    /// # Errors
    /// Any link error; [`Fault`](DeviceError::Fault) when the axis reports one (stall, no power, critical flag). A
    /// missing reference is no error here: it is `homed == false`.
    async fn position(&self) -> Result<AxisPosition<P>, DeviceError>;

    /// Finds the reference, comes to rest, and makes the step count true. Moves the axis.
    ///
    /// # Errors
    /// [`Timeout`](DeviceError::Timeout) when the reference is not found by `deadline` (the axis is stopped first).
    async fn home(&self, deadline: Instant) -> Result<AxisPosition<P>, DeviceError>;

    /// Starts a move to the step nearest to `to` and returns at once.
    ///
    /// # Errors
    /// [`OutOfTravel`](DeviceError::OutOfTravel) outside [`AxisSettings::limit`]; [`Fault`](DeviceError::Fault) without
    /// a reference. Nothing moves then.
    async fn start_move(&self, to: P) -> Result<Motion<P>, DeviceError>;

    /// The same, cruising at `speed` (°/s or mm/s) instead of that of [`settings`](Self::settings), which no move
    /// exceeds. Moves that follow have the speed of the settings again.
    ///
    /// # Errors
    /// As [`start_move`](Self::start_move); [`Unsupported`](DeviceError::Unsupported) by a driver that cannot set a
    /// speed for one move, or not this one.
    async fn start_move_at(&self, to: P, speed: f64) -> Result<Motion<P>, DeviceError>;

    /// Waits until `motion` has ended *at its target*, watching that the axis makes progress.
    ///
    /// # Errors
    /// [`Fault`](DeviceError::Fault) when it stalls, hits a limit or ends elsewhere; [`Timeout`](DeviceError::Timeout)
    /// past [`Motion::deadline`]. The axis is stopped before the error is returned.
    async fn finish_move(&self, motion: Motion<P>) -> Result<AxisPosition<P>, DeviceError>;

    /// Stops the axis from any state and verifies by two equal positions that it stands still.
    ///
    /// # Errors
    /// Any error means: *not verified at rest*.
    async fn stop(&self) -> Result<AxisPosition<P>, DeviceError>;

    /// Moves to the step nearest to `to` and waits: [`start_move`](Self::start_move), then
    /// [`finish_move`](Self::finish_move).
    ///
    /// # Errors
    /// Those of both.
    async fn move_to(&self, to: P) -> Result<AxisPosition<P>, DeviceError> {
        let motion = self.start_move(to).await?;
        self.finish_move(motion).await
    }
}

/// Where an axis is, read back from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPosition<P = AxisAngle> {
    /// The position, by the station's scale.
    pub place: P,
    /// The axis' own count.
    pub steps: i64,
    /// The axis says that it is moving.
    pub moving: bool,
    /// The axis has a reference since power-on: the position is true.
    pub homed: bool,
    /// When the answer arrived.
    pub at: Instant,
}

/// A move that was started.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<P = AxisAngle> {
    /// Count at the start.
    pub from_steps: i64,
    /// Count at the end.
    pub target_steps: i64,
    /// The position at `target_steps`: what will be read back, not what was asked.
    pub target: P,
    /// Cruising speed in °/s or mm/s, as the drive has taken it.
    pub speed: f64,
    /// How long distance, speed and acceleration say that it takes.
    pub expected: Duration,
    /// When to give up: twice the expected time and two seconds (cf. ophyd-async, distance/velocity + 2·acceleration +
    /// 10 s).
    pub deadline: Instant,
}

/// Scale, limits and dynamics of an axis, from the station file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisSettings<P = AxisAngle> {
    scale: AxisScale<P>,
    limit: (P, P),
    speed: f64,
    acceleration: f64,
}

/// Why the settings of an axis were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvalidSettings {
    /// Limits the wrong way round.
    #[error("{key} = [{from}, {to}]: the first must be below the second")]
    Limit {
        /// Key of the station file.
        key: &'static str,
        /// First limit.
        from: f64,
        /// Second limit.
        to: f64,
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

impl<P: Coordinate> AxisSettings<P> {
    /// Checked settings: `limit` rising, speed and acceleration in units of `P` per s and s² above zero.
    ///
    /// # Errors
    /// [`InvalidSettings`] names the key.
    pub fn new(scale: AxisScale<P>, limit: (P, P), speed: f64, acceleration: f64) -> Result<Self, InvalidSettings> {
        let [_, limit_key, speed_key, acceleration_key] = P::KEYS;
        if limit.0 >= limit.1 {
            return Err(InvalidSettings::Limit {
                key: limit_key,
                from: limit.0.number(),
                to: limit.1.number(),
            });
        }
        for (key, value) in [(speed_key, speed), (acceleration_key, acceleration)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InvalidSettings::NotPositive { key, value });
            }
        }
        Ok(Self {
            scale,
            limit,
            speed,
            acceleration,
        })
    }

    /// Steps ⇄ positions.
    pub const fn scale(&self) -> &AxisScale<P> {
        &self.scale
    }

    /// Lower and upper limit of travel.
    pub const fn limit(&self) -> (P, P) {
        self.limit
    }

    /// Cruising speed in °/s or mm/s.
    pub const fn speed(&self) -> f64 {
        self.speed
    }

    /// Acceleration in °/s² or mm/s².
    pub const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Whether `place` lies within the travel. A limit itself is inside, and half a step of rounding is forgiven.
    pub fn allows(&self, place: P) -> bool {
        let slack = self.scale.step() / 2.0;
        place.number() >= self.limit.0.number() - slack && place.number() <= self.limit.1.number() + slack
    }

    /// Time of a move over `distance`: trapezoidal, or triangular when the cruising speed is not reached.
    pub fn duration(&self, distance: f64) -> Duration {
        self.duration_at(distance, self.speed)
    }

    /// The same at another cruising speed.
    pub fn duration_at(&self, distance: f64, speed: f64) -> Duration {
        let distance = distance.abs();
        let ramp = speed * speed / self.acceleration;
        let seconds = if distance < ramp {
            2.0 * (distance / self.acceleration).sqrt()
        } else {
            distance / speed + speed / self.acceleration
        };
        // A move of millennia is a typing error in the station; a day is already an alarm.
        Duration::try_from_secs_f64(seconds).unwrap_or(Duration::from_hours(24))
    }

    /// The refusal of a position outside the limits of `device`.
    pub fn out_of_travel(&self, device: &str, wanted: f64) -> DeviceError {
        DeviceError::OutOfTravel {
            device: device.to_owned(),
            wanted,
            from: self.limit.0.number(),
            to: self.limit.1.number(),
            unit: P::UNIT,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sense;
    use isolux_units::Millimetre;

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

    #[test]
    fn a_rail_is_no_angle_in_any_message() {
        let mm = |value: f64| Millimetre::new(value).unwrap();
        let ratio = AxisScale::new(0, 1, mm(0.0), Sense::Positive).unwrap_err();
        let scale = AxisScale::new(2000, 1, mm(0.0), Sense::Positive).unwrap();
        let limit = AxisSettings::new(scale, (mm(9.0), mm(1.0)), 1.0, 1.0).unwrap_err();
        let speed = AxisSettings::new(scale, (mm(1.0), mm(9.0)), 0.0, 1.0).unwrap_err();
        let rail = AxisSettings::new(scale, (mm(100.0), mm(12_000.0)), 400.0, 800.0).unwrap();
        let travel = rail.out_of_travel("zaber:x?axis=3", 50.0).to_string();
        assert_eq!(
            travel,
            "zaber:x?axis=3: 50 mm is outside its travel of 100 mm to 12000 mm; nothing moved"
        );
        for (stated, key) in [
            (ratio.to_string(), "counts_per_mm"),
            (limit.to_string(), "limit_mm"),
            (speed.to_string(), "speed_mm_s"),
            (scale.place(3000).to_string(), "1.5 mm"),
        ] {
            assert!(
                stated.contains(key) && !stated.contains("deg") && !stated.contains('°'),
                "{stated}"
            );
        }
        let turn = settings(1.0, 1.0).unwrap().out_of_travel("zaber:x", 200.0).to_string();
        assert!(turn.contains("200° is outside its travel of -180° to 180°"), "{turn}");
    }
}
