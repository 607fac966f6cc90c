//! Sweeping the half-planes of a block that chooses them.

use isolux_record::Event;
use isolux_record::plan::Block;

use super::session::Session;
use crate::chosen::{Chosen, Next};
use crate::error::ScanError;
use crate::itinerary::Visit;

impl Session<'_> {
    /// The sweep that follows in a block that chooses its half-planes, once the first one is swept.
    pub(super) fn next_sweep(&self, block: &Block) -> Option<Next> {
        block.target?;
        match self.chosen.get(&block.name) {
            Some(chosen) => chosen.next(block),
            None => Chosen::default().next(block),
        }
    }

    /// Sweeps rings and half-planes until the target of `block` is reached; nothing where it has none. `visits` are
    /// those of the block.
    ///
    /// # Errors
    /// What a sweep fails with.
    pub(super) async fn sweep_chosen(&mut self, block: &Block, visits: &[Visit]) -> Result<(), ScanError> {
        let (mut since_reference, mut said) = (0, String::new());
        while let Some(next) = self.next_sweep(block) {
            let Some(planned) = self.planned(block, visits, &next) else {
                break;
            };
            self.look_at_wall_clock()?;
            self.awake(async |session| session.pause_if_asked().await).await?;
            if !next.c_deg.is_empty() && said != next.reason {
                said.clone_from(&next.reason);
                self.event(Event::HalfPlanes {
                    block: block.name.clone(),
                    c_deg: next.c_deg.clone(),
                    reason: next.reason.clone(),
                })?;
            }
            let (c_deg, gamma_deg) = next.pass.from_deg();
            let visit = Visit {
                pass: Some(next.pass),
                c_deg,
                gamma_deg,
                ..planned
            };
            let reference = block.reference_every.is_some_and(|every| since_reference == every);
            self.awake(async |session| {
                session.prove_lamp(block, &visit).await?;
                if reference {
                    session.visit(block, &visit.reference_before(), (0, &[])).await?;
                }
                session.visit(block, &visit, (0, &[])).await
            })
            .await?;
            since_reference = if reference { 1 } else { since_reference + 1 };
        }
        // What was not chosen is no point of this scan.
        let may_be = to_be_chosen(block, visits);
        let not_chosen = may_be.filter(|visit| self.is_left_out(block, visit)).count() as u64;
        self.total = self.total.saturating_sub(not_chosen);
        Ok(())
    }

    /// The visit of the plan that a chosen sweep stands for.
    fn planned(&self, block: &Block, visits: &[Visit], next: &Next) -> Option<Visit> {
        let plane = next.pass.way.half_plane_deg();
        let of_block = to_be_chosen(block, visits);
        let mut same = of_block.filter(|visit| visit.pass.is_some_and(|pass| pass.way.half_plane_deg() == plane));
        let place = match plane {
            Some(_) => 0,
            None => self.chosen.get(&block.name).map_or(0, Chosen::rings),
        };
        same.nth(place).copied()
    }

    fn is_left_out(&self, block: &Block, visit: &Visit) -> bool {
        let plane = visit.pass.and_then(|pass| pass.way.half_plane_deg());
        plane.is_some_and(|plane| !self.chosen.get(&block.name).is_some_and(|chosen| chosen.has(plane)))
    }
}

/// Those of `visits`, of one block, that are made only where they are chosen.
fn to_be_chosen<'v>(block: &'v Block, visits: &'v [Visit]) -> impl Iterator<Item = &'v Visit> {
    visits.iter().filter(|visit| visit.is_to_be_chosen(block))
}
