//! One visit: move, settle, read, verify, and only then record. A visit that was disturbed is made again.

use isolux_device::{LuxOutcome, LuxReading};
use isolux_record::plan::{Block, Instrument};
use isolux_record::spectra::SpectrumRecord;
use isolux_record::{Electrical, Event, Quality, Reading, ReadingKind, Role};
use tokio::time::Instant;

use super::limit::Waiting;
use super::repeats;
use super::session::Session;
use super::taken::Taken;
use super::verify::BenchState;
use crate::clock::microseconds;
use crate::electrical;
use crate::error::ScanError;
use crate::itinerary::Visit;
use crate::motion::Pose;
use crate::settle::Settling;

/// Tries of a visit or a warm-up before the scan ends.
pub(super) const TRIES: u32 = 3;

impl Session<'_> {
    /// Makes a visit and records it. `already` are the readings of it that an earlier session has recorded. Where the
    /// reference point is at a limit, the scan waits for a stable lamp and reads it again before it ends.
    pub async fn visit(&mut self, block: &Block, visit: &Visit, already: (u32, &[f64])) -> Result<(), ScanError> {
        self.visit_after(block, visit, already, None).await
    }

    /// The same, where the lamp was waited for already: since then.
    pub(super) async fn visit_after(
        &mut self,
        block: &Block,
        visit: &Visit,
        already: (u32, &[f64]),
        mut waiting: Option<Waiting>,
    ) -> Result<(), ScanError> {
        let mut tries = 1;
        let before = self.axes.target();
        loop {
            // After the lamp had to be switched on again it is warmed up first, and its drift begins at a visit of its
            // own.
            self.outputs(block).await?;
            let now = if visit.role != Role::Reference && self.lacks_reference(block) {
                visit.reference_before()
            } else {
                *visit
            };
            let last = tries == TRIES && waiting.is_some();
            let outcome = self.sound(block, &now, already, last).await;
            self.awake_until_now()?;
            match outcome {
                Ok(taken) => {
                    if let Some(waiting) = waiting.take() {
                        self.lamp_is_back(waiting, &taken)?;
                    }
                    self.keep(taken)?;
                    if now == *visit {
                        self.done += u64::from(visit.counts());
                        return Ok(());
                    }
                }
                Err(error) if error.can_be_measured_again() && tries < TRIES => {
                    tries += 1;
                    self.again(&error, before).await?;
                }
                Err(error) if error.is_limit_of_lamp() && waiting.is_none() => {
                    waiting = Some(self.wait_for_lamp(&error.to_string())?);
                    tries = 1;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// What a visit gives, with pose and outputs verified and within the limits of the plan.
    async fn sound(
        &mut self,
        block: &Block,
        visit: &Visit,
        already: (u32, &[f64]),
        last: bool,
    ) -> Result<Taken, ScanError> {
        if let Some(pass) = &visit.pass {
            return self.sweep(block, visit, pass).await.map(Taken::Sweep);
        }
        if visit.role == Role::Point && block.instrument == Instrument::Spectroradiometer {
            return self.spectrum(block, visit).await.map(Taken::Spectrum);
        }
        let readings = self.readings(block, visit, already).await?;
        if visit.role == Role::Reference
            && let Some(reading) = readings.first()
            && let Err(error) = self
                .references
                .judge(reading, self.references.last(reading.distance_mm), &self.limits)
        {
            // The reading itself is true: axes and outputs are as they should be. A reduction must know of a jump: the
            // points before it may have been read on either side. A slow drift leaves them as they are.
            if last && matches!(error, ScanError::Reference { .. }) {
                self.awake_until_now()?;
                self.keep(Taken::Readings(readings))?;
            }
            return Err(error);
        }
        Ok(Taken::Readings(readings))
    }

    /// The readings of the lux meter at one pose, not yet recorded.
    pub(super) async fn readings(
        &mut self,
        block: &Block,
        visit: &Visit,
        already: (u32, &[f64]),
    ) -> Result<Vec<Reading>, ScanError> {
        let already = if visit.role == Role::Point {
            already
        } else {
            (0, [].as_slice())
        };
        let pose = self.axes.go_to(visit.c_deg, visit.gamma_deg).await?;
        let mut settling = Settling::default();
        let (settled, mut line) = loop {
            let (light, line) = self.verified(pose.rest_at).await?;
            if let Some(settled) = settling.add(light, &self.photometer.noise) {
                break (settled, line);
            }
        };
        if !settled.stable {
            self.unsettled += 1;
            let at = format!("C {}°, γ {}°", visit.c_deg, visit.gamma_deg);
            self.note(&format!(
                "the light did not settle at {at}; its reading is marked failed"
            ))?;
        }
        let mut values = already.1.to_vec();
        let mut light = settled.reading;
        let mut taken = already.0;
        let mut readings = Vec::new();
        loop {
            let reading = self.reading(block, visit, pose, &light, taken, settled.stable).await?;
            let reading = Reading {
                electrical: line,
                ..reading
            };
            values.extend(reading.illuminance_lx);
            let digit_lx = reading.digit_lx.unwrap_or_default();
            readings.push(reading);
            taken += 1;
            if visit.role == Role::Reference
                || repeats::enough(block.repeats, taken, &values, &light, self.photometer.noise)
            {
                let pose_deg = (visit.c_deg, visit.gamma_deg);
                repeats::agree(pose_deg, &values, digit_lx, self.photometer.noise, &self.limits)?;
                return Ok(readings);
            }
            (light, line) = self.verified(pose.rest_at).await?;
        }
    }

    /// A new reading of light and supply line, during which and after which everything is as it was left.
    async fn verified(&mut self, not_before: Instant) -> Result<(LuxReading, Electrical), ScanError> {
        let left = BenchState {
            rail: self.rail_left(),
            outputs: self.outputs_left(),
            axes: &self.axes,
        };
        let power = self.devices.power.as_deref();
        let line = async {
            match power {
                Some(meter) => electrical::read(meter, not_before).await.map(Some),
                None => Ok(None),
            }
        };
        // Both to their end: an answer that nobody waits for would meet the next request.
        let both = async {
            let (light, line) = tokio::join!(self.photometer.read(not_before), line);
            Ok((light?, line?))
        };
        let (light, line) = left.during(both).await?;
        self.photometer.retries += line.as_ref().map_or(0, |line| u64::from(line.retries));
        Ok((
            light,
            line.as_ref().map_or_else(Electrical::default, electrical::recorded),
        ))
    }

    async fn reading(
        &mut self,
        block: &Block,
        visit: &Visit,
        pose: Pose,
        light: &LuxReading,
        repeat: u32,
        stable: bool,
    ) -> Result<Reading, ScanError> {
        let quality = match light.outcome {
            _ if !stable => Quality::Failed,
            LuxOutcome::Unsteady => Quality::Failed,
            LuxOutcome::Measured(_) => Quality::Ok,
            LuxOutcome::OverRange => Quality::OverRange,
            LuxOutcome::UnderRange => Quality::UnderRange,
        };
        let factor = self.engine.station.luxmeter().calibration_factor;
        let illuminance_lx = light
            .illuminance()
            .filter(|_| quality == Quality::Ok)
            .map(|lux| lux.value() * factor);
        let digit_lx = light.digit.value() * factor;
        Ok(Reading {
            index: 0,
            block: block.name.clone(),
            kind: block.kind,
            time_s: Some(self.time_s(light.middle())),
            c_deg: pose.c_deg,
            gamma_deg: pose.gamma_deg,
            distance_mm: self.distance_mm,
            travel: self.axes.travel(),
            range: i32::from(light.range),
            ambient_c: self.ambient_c().await?,
            illuminance_lx,
            u_lx: illuminance_lx.map(|lux| self.photometer.noise.u_lx(lux, digit_lx)),
            quality,
            role: visit.role,
            point: visit.point,
            repeat,
            c_target_deg: visit.c_deg,
            gamma_target_deg: visit.gamma_deg,
            digit_lx: Some(digit_lx),
            integration_s: Some(microseconds(
                light.ended.saturating_duration_since(light.began).as_secs_f64(),
            )),
            raw: hex::encode(&light.evidence),
            session: 0,
            burning: None,
            lamp_s: self.lamp_s(light.middle()),
            electrical: Electrical::default(),
        })
    }

    /// Records what a visit gave.
    pub(super) fn keep(&mut self, taken: Taken) -> Result<(), ScanError> {
        let readings = match taken {
            Taken::Readings(readings) => readings,
            Taken::Spectrum(record) => return self.keep_spectrum(record),
            Taken::Sweep(record) => return self.keep_sweep(record),
        };
        for reading in readings {
            self.without_number += u64::from(reading.quality != Quality::Ok);
            if reading.role == Role::Reference {
                self.references.keep(&reading, &self.limits);
            }
            let recorded = self.run.append(reading)?;
            let described = self.now(Event::Reading(Box::new(recorded)));
            self.engine.observer.event(&described);
        }
        Ok(())
    }

    fn keep_spectrum(&mut self, record: SpectrumRecord) -> Result<(), ScanError> {
        let Some(spectro) = &self.devices.spectro else {
            return Ok(());
        };
        let index = self.run.spectrum(record.clone(), &spectro.calibration)?;
        self.spectra += 1;
        self.event(Event::Spectrum {
            index,
            integration_s: record.integration_s,
            record: Some(Box::new(record)),
        })
    }

    /// Whether this block follows the drift of the lamp by visits, and none was made since the lamp was switched on.
    fn lacks_reference(&self, block: &Block) -> bool {
        block.kind == ReadingKind::Lit
            && block.reference_every.is_some()
            && self.references.last(self.distance_mm).is_none()
    }
}
