//! The engine: a plan becomes a run, and the axes are at rest when it ends, however it ends.

use std::future::poll_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::task::Poll;

use isolux_record::plan::Plan;
use isolux_record::run::{Run, RunDir, StopHow, Stopped};
use isolux_record::{Event, Logged};

use crate::bench_state;
use crate::cancel::Cancel;
use crate::clock::RunClock;
use crate::devices::Devices;
use crate::dry_run::dry_run;
use crate::error::ScanError;
use crate::motion::stop_all;
use crate::sweeps;
use session::Session;

pub use around::{Engine, ScanSummary};

mod around;
mod asleep;
mod at_rest;
mod coverage;
mod dark;
mod gaps;
mod half_planes;
mod limit;
mod outputs;
mod paused;
mod progress;
mod reference;
mod repeats;
mod second_sweeps;
mod session;
mod spectra;
mod sweep;
mod symmetry;
mod taken;
mod verify;
mod visit;
mod wall_clock;

impl Engine<'_> {
    /// Runs `plan` on `devices` into `run`. With `resumed`, the points that it holds are not read again.
    ///
    /// Whatever happens, both axes are stopped and verified at rest before this returns, and run.toml says how it
    /// ended.
    ///
    /// # Errors
    /// [`ScanError`]; [`ScanError::NotAtRest`] wins over everything else.
    pub async fn run(
        &self,
        devices: &mut Devices,
        plan: &Plan,
        run: &mut RunDir,
        cancel: &Cancel,
        resumed: Option<&Run>,
    ) -> Result<ScanSummary, ScanError> {
        dry_run(self.station, plan)?;
        sweeps::check_meter(self.station, devices, plan)?;
        let clock = RunClock::starting(self.now_utc, run.start_s(), self.awake);
        let before = run.len();
        let devices: &Devices = devices;
        let mut session = Session::new(self, devices, run, clock.clone(), *plan.limits());
        let outcome = tokio::select! {
            biased;
            reason = cancel.cancelled() => Err(ScanError::Interrupted { reason, readings: 0 }),
            outcome = panic_as_error(session.day(plan, resumed)) => outcome,
            () = self.awake.keep_looking() => unreachable!("it looks for ever"),
        };
        let summary = session.summary(before);
        let outcome = self.stop(devices, run, &clock, outcome).await;
        outcome.map(|()| summary)
    }

    /// Stops the axes, verifies it, and records how the run ended.
    async fn stop(
        &self,
        devices: &Devices,
        run: &mut RunDir,
        clock: &RunClock,
        outcome: Result<(), ScanError>,
    ) -> Result<(), ScanError> {
        let rest = stop_all(devices).await;
        let left = bench_state::ask(devices, rest.is_ok()).await;
        let readings = run.len();
        let outcome = match outcome {
            Err(ScanError::Interrupted { reason, .. }) => Err(ScanError::Interrupted { reason, readings }),
            other => other,
        };
        let (how, message) = match &outcome {
            Ok(()) => (StopHow::Completed, "every point of the plan was read".to_owned()),
            Err(ScanError::Interrupted { reason, .. }) => (StopHow::Interrupted, reason.clone()),
            Err(error) => (StopHow::Failed, error.to_string()),
        };
        let axes_at_rest = rest.is_ok();
        let utc = clock.utc_now();
        let event = Event::Stopped {
            how,
            message: message.clone(),
            axes_at_rest,
            left: Some(left),
        };
        let time_utc = utc.clone();
        let ended = Logged { time_utc, event };
        let event = run.event(&ended);
        // The end is recorded where the events cannot be written, too.
        let recorded = run
            .stop(Stopped::new(utc, how, message.clone(), axes_at_rest))
            .and(event);
        self.observer.event(&ended);
        match rest {
            Err(axes) => {
                let before = if outcome.is_ok() {
                    String::new()
                } else {
                    format!("; before that: {message}")
                };
                Err(ScanError::NotAtRest { axes, before })
            }
            // What ended the scan says more than a disk that could not record it.
            Ok(()) => outcome.and_then(|()| recorded.map_err(ScanError::from)),
        }
    }
}

/// Turns a panic inside `work` into an error: the axes must be stopped then too.
async fn panic_as_error(work: impl Future<Output = Result<(), ScanError>>) -> Result<(), ScanError> {
    let mut work = Box::pin(work);
    poll_fn(
        |context| match catch_unwind(AssertUnwindSafe(|| work.as_mut().poll(context))) {
            Ok(poll) => poll,
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                let message = text
                    .or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string))
                    .unwrap_or_default();
                Poll::Ready(Err(ScanError::Panicked { message }))
            }
        },
    )
    .await
}

#[cfg(test)]
mod darks;
#[cfg(test)]
mod drifts;
#[cfg(test)]
mod in_motion;
#[cfg(test)]
mod interference;
#[cfg(test)]
mod pauses;
#[cfg(test)]
mod power;
#[cfg(test)]
mod sleeps;
#[cfg(test)]
mod tests;
