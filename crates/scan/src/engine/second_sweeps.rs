//! Sweeping parts of half-planes a second time: slowly within the beam, more sensitively where the light is dim.

use isolux_record::Event;
use isolux_record::plan::{Block, Way};

use super::session::Session;
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::second::{self, Bench, Second};

impl Session<'_> {
    /// The second sweep that follows once the half-planes of `block` are swept.
    pub(super) fn next_second(&self, block: &Block) -> Option<Second> {
        let station = self.engine.station;
        let factor = station.luxmeter().calibration_factor;
        let tops = &self.devices.meter.properties().range_full_scale;
        let bench = Bench {
            accel_deg_s2: station.axis_gamma().accel_deg_s2,
            tops_lx: tops.iter().map(|top| top.value() * factor).collect(),
        };
        second::next(block, self.chosen.get(&block.name)?, &bench)
    }

    /// Makes the second sweeps that `block` asks for. `visits` are those of the block.
    ///
    /// # Errors
    /// What a sweep fails with.
    pub(super) async fn sweep_again_in_part(&mut self, block: &Block, visits: &[Visit]) -> Result<(), ScanError> {
        let (mut count, mut before) = (0, None);
        while let Some(second) = self.next_second(block) {
            if before.as_ref() == Some(&second) {
                // For ever, else.
                self.note("a second sweep was made otherwise than it was asked for: no further one is made")?;
                break;
            }
            before = Some(second.clone());
            let Second { pass, reason } = second;
            let Way::HalfPlane { c_deg, gamma_deg } = pass.way else {
                break;
            };
            let event = Event::SecondSweep {
                block: block.name.clone(),
                c_deg,
                gamma_deg,
                speed_deg_s: pass.speed_deg_s,
                range: pass.range,
                reason,
            };
            let follows_drift = block.reference_every.is_some_and(|every| count % every == 0);
            if !self.beside_plan(block, visits, pass, event, follows_drift).await? {
                break;
            }
            count += 1;
        }
        Ok(())
    }
}
