//! One visit of the spectroradiometer: exposure, light, and dark with the same integration time.

use std::time::Duration;

use isolux_record::plan::{Block, Repeats};
use isolux_record::spectra::SpectrumRecord;

use super::session::Session;
use crate::devices::CalibratedSpectro;
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::read_distance::distance_mm;
use crate::spectrum::{self, Mean, Sums};

impl Session<'_> {
    /// The spectrum at one pose, not yet recorded.
    pub(super) async fn spectrum(&mut self, block: &Block, visit: &Visit) -> Result<SpectrumRecord, ScanError> {
        let devices = self.devices;
        let Some(spectro) = &devices.spectro else {
            return Err(ScanError::NoSpectroradiometer);
        };
        let pose = self.axes.go_to(visit.c_deg, visit.gamma_deg).await?;
        let count = match block.repeats {
            Repeats::Exactly(count) => count,
            Repeats::Until(_) => 8,
        };
        let time = spectrum::expose(spectro, block.peak_counts_rel).await?;
        let light = self.mean(spectro, time, count).await?;
        let was_open = self.shutter_open;
        self.shutter(block, false).await?;
        let dark = self.mean(spectro, time, count).await?;
        if was_open == Some(true) {
            self.shutter(block, true).await?;
        }
        Ok(SpectrumRecord {
            index: 0,
            block: block.name.clone(),
            point: visit.point,
            kind: block.kind,
            time_s: Some(self.time_s(light.middle)),
            lamp_s: self.lamp_s(light.middle),
            c_deg: pose.c_deg,
            gamma_deg: pose.gamma_deg,
            distance_mm: distance_mm(self.engine.station, block),
            integration_s: time.as_secs_f64(),
            averages: count,
            detector_c: light.detector_c,
            ambient_c: self.ambient_c().await?,
            pixels: spectrum::pixels(spectro, &light, &dark),
        })
    }

    /// The mean of `count` spectra that agree, each verified.
    async fn mean(&self, spectro: &CalibratedSpectro, time: Duration, count: u32) -> Result<Mean, ScanError> {
        let mut sums = Sums::new(spectro);
        for _ in 0..count {
            let raw = self.left().during(spectrum::acquire(spectro, time)).await?;
            sums.add(&raw)?;
        }
        let mean = sums.mean();
        mean.agrees(&self.limits)?;
        Ok(mean)
    }
}
