//! Lamp, shutter, baffle and distance: brought into the state that a block needs, and found in it again.

use std::time::Duration;

use isolux_record::event::WarmUp;
use isolux_record::plan::{Block, Instrument};
use isolux_record::{Event, ReadingKind};
use tokio::time::Instant;

use super::session::Session;
use super::verify::Output;
use super::visit::TRIES;
use crate::clock::microseconds;
use crate::devices::{OperatorRequest, TwoState};
use crate::error::ScanError;
use crate::itinerary::REFERENCE_DEG;
use crate::motion::{drive_rail, rail_holds, stop_all};
use crate::read_distance::distance_mm;
use crate::warmup::{Criterion, StabilityCheck, Stable};

impl Session<'_> {
    /// Brings the detector to the distance of a block, and asks what the block asks.
    pub async fn place(&mut self, block: &Block) -> Result<(), ScanError> {
        let station = self.engine.station;
        let distance = distance_mm(station, block);
        let of_meter = block.instrument == Instrument::Luxmeter;
        if let Some(prompt) = &block.prompt {
            self.ask(prompt.clone(), block.kind, distance).await?;
        }
        match &self.devices.rail {
            Some(rail) if of_meter && self.rail_mm != Some(distance) => {
                let found_mm = drive_rail(rail.as_ref(), distance).await?;
                self.rail_mm = Some(distance);
                self.event(Event::Rail { distance_mm: found_mm })?;
            }
            None if of_meter && distance != self.distance_mm && block.prompt.is_none() => {
                let prompt = station.rail().and_then(|rail| rail.prompt.clone());
                let words = prompt.unwrap_or_else(|| "move the detector".to_owned());
                self.ask(format!("{words} (to {distance} mm)"), block.kind, distance)
                    .await?;
            }
            _ => {}
        }
        if of_meter {
            self.distance_mm = distance;
        }
        Ok(())
    }

    /// Brings lamp, warm-up, baffle and shutter into the state that a block needs; what is in it already is left alone.
    pub async fn outputs(&mut self, block: &Block) -> Result<(), ScanError> {
        self.dark(block).await?;
        match block.kind {
            ReadingKind::Lit => {
                self.baffle(block, false).await?;
                self.shutter(block, true).await?;
                self.lamp(block, true).await?;
            }
            ReadingKind::Baffled => {
                // The check of stability needs the light before the baffle goes in.
                self.lamp(block, true).await?;
                self.shutter(block, true).await?;
                self.baffle(block, true).await?;
            }
            ReadingKind::LampOff => {
                self.lamp(block, false).await?;
                self.baffle(block, false).await?;
                self.shutter(block, true).await?;
            }
            ReadingKind::Capped => self.shutter(block, false).await?,
        }
        Ok(())
    }

    /// Records why a visit or a warm-up is made again, and brings everything back that is not as it was left. `before`
    /// is where the axes came from: they approach again from there, because backlash depends on it.
    pub async fn again(&mut self, error: &ScanError, before: Option<(f64, f64)>) -> Result<(), ScanError> {
        self.visits_again += 1;
        let reason = error.to_string();
        self.event(Event::Again { reason })?;
        self.restore().await?;
        if let Some((c_deg, gamma_deg)) = before
            && self.axes.hold().await.is_err()
        {
            self.axes.go_to(c_deg, gamma_deg).await?;
        }
        Ok(())
    }

    /// Brings rail and outputs back that are not as they were left.
    pub async fn restore(&mut self) -> Result<(), ScanError> {
        if let Some((rail, distance)) = self.rail_left()
            && rail_holds(rail, distance).await.is_err()
        {
            drive_rail(rail, distance).await?;
        }
        for Output {
            role,
            device,
            left,
            switched,
            ..
        } in self.outputs_left()
        {
            if device.state().await.map_err(ScanError::device(role))? == left {
                continue;
            }
            device.set(left).await.map_err(ScanError::device(role))?;
            if role == "lamp" && left {
                self.lamp_now_on()?;
            }
            self.event(switched(left))?;
        }
        Ok(())
    }

    async fn lamp(&mut self, block: &Block, on: bool) -> Result<(), ScanError> {
        if self.lamp_is_on != on {
            match &self.devices.lamp {
                Some(TwoState::Device(lamp)) => lamp.set(on).await.map_err(ScanError::device("lamp"))?,
                Some(TwoState::Person(prompt)) => {
                    let words = format!("{prompt} ({})", if on { "ON" } else { "OFF" });
                    self.ask(words, block.kind, self.distance_mm).await?;
                }
                // The block's own prompt has asked for it.
                None => {}
            }
            if on {
                self.lamp_now_on()?;
            } else {
                self.lamp_is_on = false;
                self.warm = false;
            }
            self.event(Event::Lamp { on })?;
        }
        if on && !self.warm {
            self.warm_up(block).await?;
        }
        Ok(())
    }

    /// Waits until the lamp is stable. A window during which an axis or an output was not as it was left says nothing.
    async fn warm_up(&mut self, block: &Block) -> Result<(), ScanError> {
        let mut tries = 1;
        loop {
            match self.warm_up_once(block).await {
                Ok(true) => return Ok(()),
                // Nobody looked at the lamp during the pause: the window begins anew, the time on counts on.
                Ok(false) => {}
                Err(error) if error.can_be_measured_again() && tries < TRIES => {
                    tries += 1;
                    self.again(&error, None).await?;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Whether the lamp is stable; not where a pause came between.
    async fn warm_up_once(&mut self, block: &Block) -> Result<bool, ScanError> {
        self.baffle(block, false).await?;
        self.shutter(block, true).await?;
        self.axes.go_to(REFERENCE_DEG.0, REFERENCE_DEG.1).await?;
        let now = Instant::now();
        let on_for = self.clock.seconds(now) - self.lamp_on_s.unwrap_or_default();
        let criterion = Criterion::of(self.engine.station, &self.limits).beginning_at(on_for);
        let on_at = now.checked_sub(Duration::from_secs_f64(on_for.max(0.0))).unwrap_or(now);
        let mut check = StabilityCheck::new(criterion, on_at);
        let stable = loop {
            let look = check.look(&mut self.photometer, self.devices.power.as_deref()).await;
            // First of all: light that somebody has cut off says nothing of the lamp.
            self.verify().await?;
            let look = look?;
            // Nobody looked at the lamp meanwhile: its window begins anew.
            self.awake_until_now()?;
            self.look_at_wall_clock()?;
            self.event(Event::WarmUp(WarmUp {
                lamp_s: microseconds(look.elapsed_s),
                illuminance_lx: look.illuminance_lx,
                spread_rel: look.spread_rel,
                power: look.power,
            }))?;
            if let Some(stable) = check.judge(&look)? {
                break stable;
            }
            tokio::select! {
                () = check.pause() => {}
                _ = self.engine.pause.wait_asked() => {}
            }
            if self.pause_if_asked().await? {
                return Ok(false);
            }
        };
        let Stable {
            elapsed_s,
            spread_rel,
            illuminance_lx,
            noise,
        } = stable;
        self.photometer.noise.relative = noise.relative;
        self.warm = true;
        let factor = self.engine.station.luxmeter().calibration_factor;
        self.references.keep_stable(self.distance_mm, illuminance_lx * factor);
        self.warm_up_s = Some(elapsed_s);
        self.event(Event::Stable {
            lamp_s: microseconds(elapsed_s),
            spread_rel,
            noise_rel: noise.relative,
        })?;
        Ok(true)
    }

    pub async fn shutter(&mut self, block: &Block, open: bool) -> Result<(), ScanError> {
        if self.shutter_open != Some(open) {
            let words = if open { "uncap the detector" } else { "cap the detector" };
            let as_found = self.shutter_open.is_none() && open;
            let shutter = self.devices.shutter.as_ref();
            if self.switch(shutter, "shutter", open, words, block, as_found).await? {
                self.event(Event::Shutter { on: open })?;
            }
            self.shutter_open = Some(open);
        }
        Ok(())
    }

    async fn baffle(&mut self, block: &Block, inside: bool) -> Result<(), ScanError> {
        if self.baffle_in != Some(inside) {
            let words = if inside {
                "put the baffle into the beam"
            } else {
                "take the baffle out of the beam"
            };
            let as_found = self.baffle_in.is_none() && !inside;
            let baffle = self.devices.baffle.as_ref();
            if self.switch(baffle, "baffle", inside, words, block, as_found).await? {
                self.event(Event::Baffle { on: inside })?;
            }
            self.baffle_in = Some(inside);
        }
        Ok(())
    }

    /// Switches an output; whether anything was done. A person is not asked for the state that a bench has anyway at
    /// the start (`as_found`).
    async fn switch(
        &mut self,
        switch: Option<&TwoState>,
        role: &'static str,
        on: bool,
        words: &str,
        block: &Block,
        as_found: bool,
    ) -> Result<bool, ScanError> {
        match switch {
            Some(TwoState::Device(device)) => device.set(on).await.map_err(ScanError::device(role))?,
            Some(TwoState::Person(_)) | None if as_found => return Ok(false),
            Some(TwoState::Person(prompt)) => {
                self.ask(format!("{prompt} ({words})"), block.kind, self.distance_mm)
                    .await?;
            }
            // The block that needed it had a prompt of its own; now it has to be undone.
            None if block.prompt.is_none() => self.ask(words.to_owned(), block.kind, self.distance_mm).await?,
            None => {}
        }
        Ok(true)
    }

    /// Stops the axes, asks the person, records who answered.
    async fn ask(&mut self, prompt: String, kind: ReadingKind, distance_mm: f64) -> Result<(), ScanError> {
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        let request = OperatorRequest {
            prompt,
            kind,
            distance_mm,
        };
        let answer = self.engine.operator.carry_out(&request).await;
        self.event(Event::Asked {
            prompt: request.prompt.clone(),
            distance_mm,
            who: answer.as_ref().ok().cloned(),
            declined: answer.as_ref().err().cloned(),
        })?;
        answer.map(drop).map_err(|reason| ScanError::Declined {
            prompt: request.prompt,
            reason,
        })
    }
}
