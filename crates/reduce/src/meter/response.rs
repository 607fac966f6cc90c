//! Readings of the lux meter as it would give them in proportion to the light, at the temperature of its calibration
//! and rested: linearity first, then temperature and fatigue, before anything is subtracted.

use std::borrow::Cow;

use isolux_record::{ReadingKind, Run};

use super::found::Found;
use super::{fatigue, linearity, temperature};
use crate::Options;
use crate::background::Level;
use crate::bench::Bench;
use crate::correction::Correction;

/// What was done to the readings.
#[derive(Debug, Clone, Default)]
pub struct Response {
    pub linearity: Found,
    pub temperature: Found,
    pub fatigue: Found,
}

impl Response {
    /// Of the readings of `run`, in order; what `bench` takes out is left to it.
    pub fn of(run: &Run, options: &Options, bench: Option<&Bench>) -> Self {
        let meter = run.header.station.luxmeter();
        let rows = &run.readings.rows;
        let on = |correction| !options.without.contains(&correction);
        let by_model = |effect| bench.is_some_and(|bench| bench.takes_out(effect));
        let offset_lx = offset_lx(run);
        let linearity = meter.linearity.as_ref().filter(|_| !by_model(linearity::EFFECT));
        let temperature = meter.temperature.as_ref().filter(|_| !by_model(temperature::EFFECT));
        let fatigue = meter.fatigue.as_ref();
        Self {
            linearity: linearity.map_or_else(Found::default, |stated| {
                linearity::of(stated, rows, offset_lx, on(Correction::Linearity))
            }),
            temperature: temperature.map_or_else(Found::default, |stated| {
                temperature::of(stated, rows, on(Correction::Temperature))
            }),
            fatigue: fatigue.map_or_else(Found::default, |stated| {
                fatigue::of(stated, rows, offset_lx, on(Correction::Fatigue))
            }),
        }
    }

    /// All of it.
    pub fn found(&self) -> [&Found; 3] {
        [&self.linearity, &self.temperature, &self.fatigue]
    }

    /// The run with these readings.
    pub fn applied<'a>(&self, run: &'a Run) -> Cow<'a, Run> {
        if self.found().iter().all(|found| found.factors.is_empty()) {
            return Cow::Borrowed(run);
        }
        let offset_lx = offset_lx(run);
        let mut corrected = run.clone();
        for (place, row) in corrected.readings.rows.iter_mut().enumerate() {
            if row.kind == ReadingKind::Capped {
                continue;
            }
            let factors = self
                .found()
                .map(|found| found.factors.get(place).copied().unwrap_or(1.0));
            let factor: f64 = factors.iter().product();
            row.illuminance_lx = row.illuminance_lx.map(|lux| offset_lx + factor * (lux - offset_lx));
            row.u_lx = row.u_lx.map(|u| factor * u);
            row.digit_lx = row.digit_lx.map(|digit| factor * digit);
        }
        Cow::Owned(corrected)
    }
}

/// What the meter shows without light; 0 where that was not read.
fn offset_lx(run: &Run) -> f64 {
    let capped = run.readings.rows.iter().filter(|row| row.kind == ReadingKind::Capped);
    Level::of(capped).map_or(0.0, |level| level.mean_lx)
}
