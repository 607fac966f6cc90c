//! After a time in which the program did not run: it is said and recorded, the bench is asked where it is, the lamp has to
//! be proved again, and what was being done is done once more.

use isolux_record::Event;

use super::session::Session;
use crate::awake::Sleep;
use crate::clock::microseconds;
use crate::error::ScanError;
use crate::motion::stop_all;

/// Sleeps during one step before the scan ends: a computer that never stays awake long enough measures nothing.
const MOST_SLEEPS: u32 = 30;

impl Session<'_> {
    /// Carries out a step of the scan. Where it failed and the program did not run meanwhile, no instrument is to blame:
    /// the bench is asked where it is, and the step begins anew. A step that must not have been interrupted asks for
    /// itself ([`awake_until_now`](Self::awake_until_now)).
    pub async fn awake<T>(
        &mut self,
        mut step: impl AsyncFnMut(&mut Self) -> Result<T, ScanError>,
    ) -> Result<T, ScanError> {
        let mut sleeps = 0;
        loop {
            let outcome = step(self).await;
            if outcome.as_ref().is_err_and(|error| !error.may_come_of_a_sleep()) {
                return outcome;
            }
            let Some(mut sleep) = self.engine.awake.take() else {
                return outcome;
            };
            while let Err(error) = self.find_bench(&sleep).await {
                sleeps += 1;
                sleep = match self.engine.awake.take() {
                    Some(another) if sleeps < MOST_SLEEPS => another,
                    _ => return Err(error),
                };
            }
            sleeps += 1;
            if outcome.is_ok() || sleeps >= MOST_SLEEPS {
                return outcome;
            }
        }
    }

    /// That the program ran all the time since the bench was last asked where it is.
    ///
    /// # Errors
    /// [`ScanError::Slept`] if not: what was read is not recorded.
    pub fn awake_until_now(&self) -> Result<(), ScanError> {
        if self.engine.awake.slept() {
            return Err(ScanError::Slept { most: MOST_SLEEPS });
        }
        Ok(())
    }

    async fn find_bench(&mut self, sleep: &Sleep) -> Result<(), ScanError> {
        self.event(Event::Slept {
            from_utc: self.clock.utc(sleep.from),
            time_s: self.time_s(sleep.from),
            slept_s: microseconds(sleep.length().as_secs_f64()),
            suspended_s: microseconds(sleep.suspended.as_secs_f64()),
        })?;
        // What was under way went on without anybody who looked.
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        let homed_again = self.axes.home_if_lost().await?;
        let pose = self.axes.pose().await?;
        self.event(Event::BenchFound {
            c_deg: pose.c_deg,
            gamma_deg: pose.gamma_deg,
            homed_again,
        })?;
        self.restore().await?;
        self.lamp_unproven = self.lamp_is_on && self.warm;
        Ok(())
    }
}
