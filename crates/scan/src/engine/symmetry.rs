//! Rings before the half-planes of a block that assumes a symmetry: whether it holds.

use isolux_photometry::Asymmetry;
use isolux_record::Event;
use isolux_record::plan::{Block, Pass, RINGS, Way, ring};

use super::session::Session;
use crate::error::ScanError;
use crate::itinerary::Visit;

impl Session<'_> {
    /// Before a half-plane of `block` is swept and once its rings are: whether the light has the symmetry that its
    /// half-planes assume.
    ///
    /// # Errors
    /// [`ScanError::NotSymmetric`].
    pub(super) fn judge_symmetry(&mut self, block: &Block, visit: &Visit) -> Result<(), ScanError> {
        let is_half_plane = visit.pass.is_some_and(|pass| pass.way.half_plane_deg().is_some());
        let Some(most_rel) = block.symmetry_max_rel.filter(|_| is_half_plane) else {
            return Ok(());
        };
        if self.symmetric.contains(&block.name) {
            return Ok(());
        }
        let Some((symmetry, found)) = self.chosen.get(&block.name).and_then(|chosen| chosen.asymmetry(block)) else {
            return Ok(());
        };
        self.event(Event::Symmetry {
            block: block.name.clone(),
            symmetry: symmetry.words().to_owned(),
            largest_rel: found.largest_rel,
            c_deg: found.c_deg,
            gamma_deg: found.gamma_deg,
            most_rel,
            narrowest_deg: Asymmetry::narrowest_deg(most_rel),
        })?;
        if found.largest_rel > most_rel {
            return Err(ScanError::NotSymmetric {
                block: block.name.clone(),
                symmetry: symmetry.words(),
                found_rel: found.largest_rel,
                c_deg: found.c_deg,
                gamma_deg: found.gamma_deg,
                most_rel,
            });
        }
        self.symmetric.insert(block.name.clone());
        Ok(())
    }

    /// The visit with the γ that the light before it gives its ring; as it is where it is none.
    pub(super) fn with_its_gamma(&self, block: &Block, visit: &Visit) -> Visit {
        let is_ring = |pass: &Pass| matches!(pass.way, Way::Ring { .. });
        let (Some(pass), Some(chosen)) = (visit.pass.filter(is_ring), self.chosen.get(&block.name)) else {
            return *visit;
        };
        let place = chosen.rings().min(RINGS - 1);
        let pass = ring(
            chosen.ring_gammas(block)[place],
            pass.way.sign() > 0.0,
            pass.speed_deg_s,
        );
        let (c_deg, gamma_deg) = pass.from_deg();
        Visit {
            pass: Some(pass),
            c_deg,
            gamma_deg,
            ..*visit
        }
    }
}
