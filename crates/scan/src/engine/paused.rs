//! Pause and what follows it: the axes are stopped and verified, the lamp stays on, and after it the lamp is judged
//! again.

use isolux_record::plan::Block;
use isolux_record::{Event, Reading, ReadingKind};
use tokio::time::Instant;

use super::session::Session;
use super::taken::Taken;
use super::visit::TRIES;
use crate::clock::microseconds;
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::motion::stop_all;

impl Session<'_> {
    /// Pauses here if that was asked for, and returns when it has ended; whether there was a pause. Nothing may be half
    /// done where this is called: both axes are stopped and verified at rest, lamp, shutter and baffle stay as they
    /// are.
    pub async fn pause_if_asked(&mut self) -> Result<bool, ScanError> {
        let Some(by) = self.engine.pause.requested() else {
            return Ok(false);
        };
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        let pose = self.axes.pose().await?;
        self.event(Event::Paused {
            by,
            c_deg: pose.c_deg,
            gamma_deg: pose.gamma_deg,
            lamp_is_on: self.lamp_is_on,
            points_done: self.done,
        })?;
        let began_s = self.clock.seconds(Instant::now());
        let by = self.engine.pause.wait_ended().await;
        let paused_s = microseconds(self.clock.seconds(Instant::now()) - began_s);
        self.event(Event::Resumed { by, paused_s })?;
        self.lamp_unproven = self.lamp_is_on && self.warm;
        Ok(true)
    }

    /// After a pause, before the next visit of a lit block: whether the reference point still gives what it gave. A
    /// visit within the plan's limit is recorded; otherwise the lamp is warmed up again, and the visit after that
    /// decides.
    pub async fn prove_lamp(&mut self, block: &Block, next: &Visit) -> Result<(), ScanError> {
        if !self.lamp_unproven || block.kind != ReadingKind::Lit {
            return Ok(());
        }
        let reference = next.reference_before();
        let readings = self.at_reference(block, &reference).await?;
        self.awake_until_now()?;
        // The lamp may have been found off, and be on and warm again since.
        if !self.lamp_unproven {
            return self.visit(block, &reference, (0, &[])).await;
        }
        self.lamp_unproven = false;
        let Some(reading) = readings.first() else { return Ok(()) };
        let expected_lx = self.references.expected(self.distance_mm);
        let judged = self.references.judge(reading, expected_lx, &self.limits);
        let why = match (judged, expected_lx) {
            (Ok(()), Some(_)) => return self.keep(Taken::Readings(readings)),
            (Ok(()), None) => "there is nothing at this distance to compare the reference point with".to_owned(),
            (Err(error), _) if error.is_limit_of_lamp() => error.to_string(),
            (Err(error), _) => return Err(error),
        };
        let waiting = self.wait_for_lamp(&why)?;
        self.outputs(block).await?;
        self.visit_after(block, &reference, (0, &[]), Some(waiting)).await
    }

    /// The reference point as it is now, not recorded: a reading outside the limits belongs to no drift of a warm lamp.
    async fn at_reference(&mut self, block: &Block, reference: &Visit) -> Result<Vec<Reading>, ScanError> {
        let mut tries = 1;
        loop {
            self.outputs(block).await?;
            match self.readings(block, reference, (0, &[])).await {
                Err(error) if error.can_be_measured_again() && tries < TRIES => {
                    tries += 1;
                    self.again(&error, None).await?;
                }
                outcome => return outcome,
            }
        }
    }
}
