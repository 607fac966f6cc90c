//! γ through its half-plane at one speed, while C rests.

use isolux_device::{Motion, awake};
use isolux_units::AxisAngle;

use super::{Axes, DRIVER_GRACE, dead};
use crate::error::ScanError;

impl Axes<'_> {
    /// Sends γ to one absolute target at `speed_deg_s`. Where it stands is not known until [`swept`](Self::swept).
    ///
    /// # Errors
    /// What the drive reports, a target outside its travel among it: nothing moves then.
    pub async fn start_sweep(&mut self, gamma_deg: f64, speed_deg_s: f64) -> Result<Motion, ScanError> {
        let to = AxisAngle::new(gamma_deg).map_err(|_| ScanError::Device {
            role: "axis.gamma",
            source: self
                .gamma
                .settings()
                .out_of_travel(&self.gamma.identity().target, gamma_deg),
        })?;
        self.target = None;
        let started = self.gamma.start_move_at(to, speed_deg_s).await;
        let motion = started.map_err(ScanError::device("axis.gamma"))?;
        if motion.target_steps != motion.from_steps {
            let from = self.gamma.settings().scale().place(motion.from_steps).value();
            self.travel = if motion.target.value() > from { 1 } else { -1 };
        }
        Ok(motion)
    }

    /// Waits until the sweep has ended at its target; the driver stops the axis after a failure.
    ///
    /// # Errors
    /// What the drive reports.
    pub async fn follow(&self, motion: Motion) -> Result<(), ScanError> {
        let finished = awake::until(motion.deadline + DRIVER_GRACE, self.gamma.finish_move(motion)).await;
        finished
            .ok_or_else(|| dead("axis.gamma", self.gamma, "finish a sweep"))?
            .map(drop)
            .map_err(ScanError::device("axis.gamma"))
    }

    /// Both axes should rest at `target` now, (C, γ) in degrees.
    pub fn swept(&mut self, target: (f64, f64)) {
        self.target = Some(target);
    }
}
