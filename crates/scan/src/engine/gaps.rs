//! Sweeping once more where no sweep has light.
//!
//! An answer that is lost or damaged leaves a gap of some degrees. A sweep with gaps is kept: another one of the same
//! half-plane has its own gaps elsewhere.

use isolux_record::plan::{Block, Pass};
use isolux_record::{Event, Role};

use super::session::Session;
use crate::error::ScanError;
use crate::itinerary::Visit;

/// Further sweeps of a block with few C, at most, before the scan ends.
const MOST_AGAIN: u32 = 12;
/// The same of many, for each C of the plan: where every hundredth answer is lost each has a gap, and what fills it
/// may have another.
const MOST_AGAIN_EACH: u32 = 4;

impl Session<'_> {
    /// Sweeps the half-planes of `block` once more in which no sweep has light somewhere. `visits` are those of
    /// the block.
    ///
    /// # Errors
    /// [`ScanError::Gaps`] where there are gaps left; what a sweep fails with.
    pub(super) async fn fill_gaps(&mut self, block: &Block, visits: &[Visit]) -> Result<(), ScanError> {
        let most = MOST_AGAIN.max(MOST_AGAIN_EACH * block.c_deg.len() as u32);
        for again in 0..most {
            let Some(pass) = self.coverage.lacking(block) else {
                return Ok(());
            };
            let ((c_deg, from), (_, to)) = (pass.from_deg(), pass.to_deg());
            let message =
                format!("C {c_deg}° is swept once more from γ {from}° to {to}°: no sweep of it has light everywhere");
            let follows_drift = block.reference_every.is_some_and(|every| again % every == 0);
            if !self
                .beside_plan(block, visits, pass, Event::Note { message }, follows_drift)
                .await?
            {
                return Ok(());
            }
        }
        if !self.coverage.lacks(block) {
            return Ok(());
        }
        Err(ScanError::Gaps {
            block: block.name.clone(),
            again: most,
            planes: self.coverage.words(block),
        })
    }

    /// Makes a sweep beside those of the plan, of a half-plane that it has, and says so by `event`; with
    /// `follows_drift` after a visit to the reference point. False where the plan does not have it.
    pub(super) async fn beside_plan(
        &mut self,
        block: &Block,
        visits: &[Visit],
        pass: Pass,
        event: Event,
        follows_drift: bool,
    ) -> Result<bool, ScanError> {
        let plane = pass.way.half_plane_deg();
        let is_of_plane = |visit: &&Visit| visit.pass.is_some_and(|of| of.way.half_plane_deg() == plane);
        let Some(planned) = visits.iter().rev().find(is_of_plane).copied() else {
            return Ok(false);
        };
        self.look_at_wall_clock()?;
        self.awake(async |session| session.pause_if_asked().await).await?;
        self.event(event)?;
        let visit = Visit {
            pass: Some(pass),
            gamma_deg: pass.from_deg().1,
            again: true,
            ..planned
        };
        self.awake(async |session| {
            session.prove_lamp(block, &visit).await?;
            if follows_drift {
                session.visit(block, &visit.reference_before(), (0, &[])).await?;
            }
            session.visit(block, &visit, (0, &[])).await
        })
        .await?;
        Ok(true)
    }
}

impl Visit {
    /// Whether it counts among the points of the plan.
    pub(super) fn counts(&self) -> bool {
        self.role == Role::Point && !self.again
    }
}
