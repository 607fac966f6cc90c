//! One axis through its way at one speed, while the other rests.

use isolux_device::{Axis, Motion, awake};
use isolux_record::plan::Way;
use isolux_units::AxisAngle;

use super::{Axes, DRIVER_GRACE, dead};
use crate::error::ScanError;

impl<'a> Axes<'a> {
    /// The axis that moves along `way`, and its role.
    pub fn moving(&self, way: &Way) -> (&'static str, &'a dyn Axis) {
        match way {
            Way::HalfPlane { .. } => ("axis.gamma", self.gamma),
            Way::Ring { .. } => ("axis.c", self.c),
        }
    }

    /// Sends the axis that moves along `way` to one absolute target at `speed_deg_s`. Where it stands is not known
    /// until [`swept`](Self::swept).
    ///
    /// # Errors
    /// What the drive reports, a target outside its travel among it: nothing moves then.
    pub async fn start_sweep(&mut self, way: &Way, to_deg: f64, speed_deg_s: f64) -> Result<Motion, ScanError> {
        let (role, axis) = self.moving(way);
        let to = AxisAngle::new(to_deg).map_err(|_| ScanError::Device {
            role,
            source: axis.settings().out_of_travel(&axis.identity().target, to_deg),
        })?;
        self.target = None;
        let started = axis.start_move_at(to, speed_deg_s).await;
        let motion = started.map_err(ScanError::device(role))?;
        if role == "axis.gamma" && motion.target_steps != motion.from_steps {
            let from = axis.settings().scale().place(motion.from_steps).value();
            self.travel = if motion.target.value() > from { 1 } else { -1 };
        }
        Ok(motion)
    }

    /// Waits until the sweep along `way` has ended at its target; the driver stops the axis after a failure.
    ///
    /// # Errors
    /// What the drive reports.
    pub async fn follow(&self, way: &Way, motion: Motion) -> Result<(), ScanError> {
        let (role, axis) = self.moving(way);
        let finished = awake::until(motion.deadline + DRIVER_GRACE, axis.finish_move(motion)).await;
        finished
            .ok_or_else(|| dead(role, axis, "finish a sweep"))?
            .map(drop)
            .map_err(ScanError::device(role))
    }

    /// Both axes should rest at `target` now, (C, γ) in degrees.
    pub fn swept(&mut self, target: (f64, f64)) {
        self.target = Some(target);
    }
}
