//! The engine: a plan becomes a run, and the axes are at rest when it ends, however it ends.

use std::collections::HashMap;
use std::future::poll_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::task::Poll;

use isolux_device::{LuxOutcome, LuxRange, LuxReading};
use isolux_record::plan::{Block, Instrument, Plan, Repeats};
use isolux_record::run::{Run, RunDir, StopHow, Stopped};
use isolux_record::spectra::SpectrumRecord;
use isolux_record::{Quality, Reading, ReadingKind, Role, Station};
use jiff::Timestamp;
use serde_json::{Value, json};
use tokio::time::Instant;

use crate::cancel::Cancel;
use crate::clock::{RunClock, microseconds};
use crate::devices::{Devices, Operator, Request, TwoState};
use crate::dry_run::{distance_mm, dry_run};
use crate::error::ScanError;
use crate::itinerary::{REFERENCE_DEG, Visit, visits};
use crate::motion::{Axes, Pose, drive_rail, stop_all};
use crate::observe::{Observer, ScanEvent};
use crate::settle::{Noise, Photometer};
use crate::spectrum;
use crate::warmup::{Criterion, Look, Stable, until_stable};

/// More readings than this never make a point's mean better: its digit does not average out.
const MOST_REPEATS: u32 = 256;

/// Everything around the instruments that a scan needs to know.
pub struct Engine<'a> {
    /// The bench.
    pub station: &'a Station,
    /// The person beside it.
    pub operator: &'a dyn Operator,
    /// Is told what happens.
    pub observer: &'a dyn Observer,
    /// UTC now: the only time that is asked from outside.
    pub now_utc: Timestamp,
}

/// What a finished scan did.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ScanSummary {
    /// Points of the plan.
    pub points: u64,
    /// Readings recorded in this session.
    pub readings: u64,
    /// Spectra recorded in this session.
    pub spectra: u64,
    /// Readings without a number: over or under range, failed.
    pub without_number: u64,
    /// Points whose light did not settle.
    pub unsettled: u64,
    /// Answers that were lost or damaged and asked again.
    pub retries: u64,
    /// How long it took.
    pub duration_s: f64,
    /// Seconds until the lamp was stable, where it was warmed up.
    pub warm_up_s: Option<f64>,
}

impl Engine<'_> {
    /// Runs `plan` on `devices` into `run`. With `resumed`, the points that it holds are not read again.
    ///
    /// Whatever happens, both axes are stopped and verified at rest before this returns, and run.toml says how it ended.
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
        let clock = RunClock::starting(self.now_utc);
        let before = run.len();
        let devices: &Devices = devices;
        let mut session = Session::new(self, devices, run, clock);
        let outcome = tokio::select! {
            biased;
            reason = cancel.cancelled() => Err(ScanError::Interrupted { reason, readings: 0 }),
            outcome = survive(session.day(plan, resumed)) => outcome,
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
        let fields = json!({ "how": how.to_string(), "message": message, "axes_at_rest": axes_at_rest });
        let event = run.event(&utc, "stopped", &fields);
        // The end is recorded where the events cannot be written, too.
        let recorded = run
            .stop(Stopped::new(utc, how, message.clone(), axes_at_rest))
            .and(event);
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
async fn survive(work: impl Future<Output = Result<(), ScanError>>) -> Result<(), ScanError> {
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

/// One session at the bench: what the instruments were last told.
struct Session<'a> {
    engine: &'a Engine<'a>,
    devices: &'a Devices,
    run: &'a mut RunDir,
    clock: RunClock,
    axes: Axes<'a>,
    photometer: Photometer<'a>,
    /// Seconds of this clock at which the lamp was switched on; none: never yet.
    lamp_on_s: Option<f64>,
    lamp_is_on: bool,
    warm: bool,
    shutter_open: Option<bool>,
    baffle_in: Option<bool>,
    distance_mm: f64,
    done: u64,
    total: u64,
    spectra: u64,
    without_number: u64,
    unsettled: u64,
    warm_up_s: Option<f64>,
}

impl<'a> Session<'a> {
    fn new(engine: &'a Engine<'a>, devices: &'a Devices, run: &'a mut RunDir, clock: RunClock) -> Self {
        Self {
            engine,
            devices,
            run,
            clock,
            axes: Axes::new(devices, engine.station),
            photometer: Photometer::new(devices.meter.as_ref()),
            lamp_on_s: None,
            lamp_is_on: false,
            warm: false,
            shutter_open: None,
            baffle_in: None,
            distance_mm: engine.station.bench().distance_mm,
            done: 0,
            total: 0,
            spectra: 0,
            without_number: 0,
            unsettled: 0,
            warm_up_s: None,
        }
    }

    fn summary(&self, before: u64) -> ScanSummary {
        ScanSummary {
            points: self.total,
            readings: self.run.len() - before,
            spectra: self.spectra,
            without_number: self.without_number,
            unsettled: self.unsettled,
            retries: self.photometer.retries,
            duration_s: self.clock.seconds(Instant::now()),
            warm_up_s: self.warm_up_s,
        }
    }

    async fn day(&mut self, plan: &Plan, resumed: Option<&Run>) -> Result<(), ScanError> {
        let visits = visits(plan);
        let progress = Progress::of(resumed);
        self.total = visits.iter().filter(|visit| visit.role == Role::Point).count() as u64;
        self.event("began", &json!({ "points": self.total, "resumed": resumed.is_some() }))?;
        // A program that was killed may have left an axis running.
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        self.engine.observer.event(&ScanEvent::Homing);
        self.axes.home().await?;
        self.event("homed", &Value::Null)?;
        self.devices
            .meter
            .set_range(LuxRange::Auto)
            .await
            .map_err(ScanError::device("luxmeter"))?;
        if let Some(rail) = &self.devices.rail {
            let home_mm = self.engine.station.bench().distance_mm;
            drive_rail(rail.as_ref(), home_mm).await?;
        }
        self.find_lamp(resumed).await?;
        let mut current = None;
        for visit in &visits {
            let block = &plan.blocks()[visit.block];
            if progress.has(visit, block) {
                self.done += u64::from(visit.role == Role::Point);
                continue;
            }
            if current != Some(visit.block) {
                self.prepare(block).await?;
                let (done, total) = (self.done, self.total);
                self.engine.observer.event(&ScanEvent::Block {
                    name: &block.name,
                    done,
                    total,
                });
                self.event("block", &json!({ "name": block.name }))?;
                if resumed.is_some() && current.is_none() && block.kind == ReadingKind::Lit {
                    // What was read before is trusted again only against the reference point.
                    let (c_deg, gamma_deg) = REFERENCE_DEG;
                    self.read(
                        block,
                        &Visit {
                            role: Role::Reference,
                            c_deg,
                            gamma_deg,
                            ..*visit
                        },
                        (0, &[]),
                    )
                    .await?;
                }
                current = Some(visit.block);
            }
            match block.instrument {
                Instrument::Luxmeter => self.read(block, visit, progress.readings(visit)).await?,
                Instrument::Spectroradiometer => self.spectrum(block, visit).await?,
            }
        }
        Ok(())
    }

    /// Whether the lamp is on already, and since when. Only a lamp of this very run has a known time.
    async fn find_lamp(&mut self, resumed: Option<&Run>) -> Result<(), ScanError> {
        let since = resumed
            .and_then(|run| run.header.lamp_on_utc.as_deref())
            .and_then(|utc| self.clock.seconds_of_utc(utc));
        match &self.devices.lamp {
            Some(TwoState::Device(lamp)) => {
                let on = lamp.state().await.map_err(ScanError::device("lamp"))?;
                if on && let Some(since) = since {
                    self.lamp_is_on = true;
                    self.lamp_on_s = Some(since);
                    // Known to burn since then; whether it is stable, the gate decides by its light again.
                } else if on {
                    // Since when is not known: a defined warm-up begins with a cold start of the clock.
                    self.note("the lamp was on already; its time counts from now")?;
                    self.lamp_now_on()?;
                }
            }
            Some(TwoState::Person(_)) => {}
            None => {
                self.note("the station has no [lamp]; its time counts from the start of the run")?;
                self.lamp_now_on()?;
            }
        }
        Ok(())
    }

    /// Brings the bench into the state that a block needs: distance, lamp, warm-up, baffle, shutter.
    async fn prepare(&mut self, block: &Block) -> Result<(), ScanError> {
        let station = self.engine.station;
        let distance = distance_mm(station, block);
        if let Some(prompt) = &block.prompt {
            self.ask(prompt.clone(), block.kind, distance).await?;
        } else if block.instrument == Instrument::Luxmeter && distance != self.distance_mm {
            if let Some(rail) = &self.devices.rail {
                let found_mm = drive_rail(rail.as_ref(), distance).await?;
                self.event("rail", &json!({ "distance_mm": found_mm }))?;
            } else {
                let prompt = station.rail().and_then(|rail| rail.prompt.clone());
                let words = prompt.unwrap_or_else(|| "move the detector".to_owned());
                self.ask(format!("{words} (to {distance} mm)"), block.kind, distance)
                    .await?;
            }
        }
        if block.instrument == Instrument::Luxmeter {
            self.distance_mm = distance;
        }
        match block.kind {
            ReadingKind::Lit => {
                self.baffle(block, false).await?;
                self.shutter(block, true).await?;
                self.lamp(block, true).await?;
            }
            ReadingKind::Baffled => {
                // The gate needs the light before the baffle goes in.
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
            self.event("lamp", &json!({ "on": on }))?;
        }
        if on && !self.warm {
            self.warm_up(block).await?;
        }
        Ok(())
    }

    fn lamp_now_on(&mut self) -> Result<(), ScanError> {
        let now = Instant::now();
        self.lamp_is_on = true;
        self.warm = false;
        self.lamp_on_s = Some(self.clock.seconds(now));
        self.run.lamp_on(self.clock.utc(now))?;
        Ok(())
    }

    async fn warm_up(&mut self, block: &Block) -> Result<(), ScanError> {
        self.baffle(block, false).await?;
        self.shutter(block, true).await?;
        self.axes.go_to(REFERENCE_DEG.0, REFERENCE_DEG.1).await?;
        let criterion = Criterion::of(self.engine.station);
        let observer = self.engine.observer;
        observer.event(&ScanEvent::WarmUpBegan {
            least_s: criterion.least_s(),
        });
        let now = Instant::now();
        let on_for = self.clock.seconds(now) - self.lamp_on_s.unwrap_or_default();
        let on_at = now
            .checked_sub(std::time::Duration::from_secs_f64(on_for.max(0.0)))
            .unwrap_or(now);
        let (run, clock) = (&mut *self.run, self.clock);
        let mut failed = None;
        let stable = until_stable(&mut self.photometer, &criterion, on_at, |look: Look| {
            let Look { elapsed_s, illuminance_lx, spread_rel } = look;
            observer.event(&ScanEvent::WarmUp { elapsed_s, illuminance_lx, spread_rel });
            let fields = json!({ "time_s": microseconds(elapsed_s), "illuminance_lx": illuminance_lx, "spread_rel": spread_rel });
            if let Err(error) = run.event(&clock.utc_now(), "warm_up", &fields) {
                failed.get_or_insert(error);
            }
        })
        .await?;
        if let Some(error) = failed {
            return Err(error.into());
        }
        let Stable {
            elapsed_s,
            spread_rel,
            noise,
            ..
        } = stable;
        self.photometer.noise = noise;
        self.warm = true;
        self.warm_up_s = Some(elapsed_s);
        observer.event(&ScanEvent::WarmUpEnded { elapsed_s, spread_rel });
        self.event(
            "stable",
            &json!({ "time_s": microseconds(elapsed_s), "spread_rel": spread_rel, "noise_rel": noise.relative }),
        )
    }

    async fn shutter(&mut self, block: &Block, open: bool) -> Result<(), ScanError> {
        if self.shutter_open != Some(open) {
            let words = if open { "uncap the detector" } else { "cap the detector" };
            self.throw(
                self.devices.shutter.as_ref(),
                "shutter",
                open,
                words,
                block,
                self.shutter_open.is_none() && open,
            )
            .await?;
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
            self.throw(
                self.devices.baffle.as_ref(),
                "baffle",
                inside,
                words,
                block,
                self.baffle_in.is_none() && !inside,
            )
            .await?;
            self.baffle_in = Some(inside);
        }
        Ok(())
    }

    /// Throws a switch. A person is not asked for the state that a bench has anyway at the start (`as_found`).
    async fn throw(
        &mut self,
        switch: Option<&TwoState>,
        role: &'static str,
        on: bool,
        words: &str,
        block: &Block,
        as_found: bool,
    ) -> Result<(), ScanError> {
        match switch {
            Some(TwoState::Device(device)) => device.set(on).await.map_err(ScanError::device(role))?,
            Some(TwoState::Person(_)) | None if as_found => return Ok(()),
            Some(TwoState::Person(prompt)) => {
                self.ask(format!("{prompt} ({words})"), block.kind, self.distance_mm)
                    .await?;
            }
            // The block that needed it had a prompt of its own; now it has to be undone.
            None if block.prompt.is_none() => self.ask(words.to_owned(), block.kind, self.distance_mm).await?,
            None => {}
        }
        self.event(role, &json!({ "on": on }))
    }

    /// Stops the axes, asks the person, records who answered.
    async fn ask(&mut self, prompt: String, kind: ReadingKind, distance_mm: f64) -> Result<(), ScanError> {
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        let request = Request {
            prompt,
            kind,
            distance_mm,
        };
        let answer = self.engine.operator.carry_out(&request).await;
        let fields = json!({ "prompt": request.prompt, "distance_mm": distance_mm, "who": answer.as_ref().ok(), "declined": answer.as_ref().err() });
        self.event("asked", &fields)?;
        answer.map(drop).map_err(|reason| ScanError::Declined {
            prompt: request.prompt,
            reason,
        })
    }

    /// One visit of the lux meter: move, settle, read, record.
    async fn read(&mut self, block: &Block, visit: &Visit, already: (u32, &[f64])) -> Result<(), ScanError> {
        let pose = self.axes.go_to(visit.c_deg, visit.gamma_deg).await?;
        let settled = self.photometer.settled(pose.rest_at).await?;
        if !settled.stable {
            self.unsettled += 1;
            let where_ = format!("C {}°, γ {}°", visit.c_deg, visit.gamma_deg);
            self.note(&format!(
                "the light did not settle at {where_}; its reading is marked failed"
            ))?;
        }
        let mut values = already.1.to_vec();
        let mut reading = settled.reading;
        let mut repeat = already.0;
        loop {
            let value = self
                .record(block, visit, pose, &reading, repeat, settled.stable)
                .await?;
            repeat += 1;
            values.extend(value);
            if visit.role == Role::Reference || enough(block.repeats, repeat, &values, &reading, self.photometer.noise)
            {
                break;
            }
            reading = self.photometer.read(pose.rest_at).await?;
        }
        self.done += u64::from(visit.role == Role::Point);
        Ok(())
    }

    async fn record(
        &mut self,
        block: &Block,
        visit: &Visit,
        pose: Pose,
        light: &LuxReading,
        repeat: u32,
        stable: bool,
    ) -> Result<Option<f64>, ScanError> {
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
        let reading = Reading {
            index: 0,
            block: block.name.clone(),
            kind: block.kind,
            time_s: self.time_s(light.middle()),
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
            raw: hexadecimal(&light.evidence),
            session: 0,
            burning: None,
        };
        self.without_number += u64::from(quality != Quality::Ok);
        let index = self.run.append(reading.clone())?;
        let reading = Reading { index, ..reading };
        let (done, total) = (self.done, self.total);
        self.engine.observer.event(&ScanEvent::Reading {
            reading: &reading,
            done,
            total,
        });
        Ok(illuminance_lx)
    }

    /// One visit of the spectroradiometer: move, expose, light, dark with the same integration time, record.
    async fn spectrum(&mut self, block: &Block, visit: &Visit) -> Result<(), ScanError> {
        let Some(spectro) = &self.devices.spectro else {
            return Ok(());
        };
        let pose = self.axes.go_to(visit.c_deg, visit.gamma_deg).await?;
        let count = match block.repeats {
            Repeats::Exactly(count) => count,
            Repeats::Until(_) => 8,
        };
        let time = spectrum::expose(spectro).await?;
        let light = spectrum::mean(spectro, time, count).await?;
        let was_open = self.shutter_open;
        self.shutter(block, false).await?;
        let dark = spectrum::mean(spectro, time, count).await?;
        if was_open == Some(true) {
            self.shutter(block, true).await?;
        }
        let record = SpectrumRecord {
            index: 0,
            block: block.name.clone(),
            point: visit.point,
            kind: block.kind,
            time_s: self.time_s(light.middle),
            c_deg: pose.c_deg,
            gamma_deg: pose.gamma_deg,
            distance_mm: distance_mm(self.engine.station, block),
            integration_s: time.as_secs_f64(),
            averages: count,
            detector_c: light.detector_c,
            ambient_c: self.ambient_c().await?,
            pixels: spectrum::pixels(spectro, &light, &dark),
        };
        let index = self.run.spectrum(record, &spectro.calibration)?;
        self.spectra += 1;
        self.done += 1;
        self.engine.observer.event(&ScanEvent::Spectrum { index });
        self.event(
            "spectrum",
            &json!({ "index": index, "integration_s": time.as_secs_f64() }),
        )
    }

    async fn ambient_c(&self) -> Result<Option<f64>, ScanError> {
        match &self.devices.ambient {
            Some(thermometer) => {
                let reading = thermometer.read().await.map_err(ScanError::device("ambient"))?;
                Ok(Some(reading.temperature.value()))
            }
            None => Ok(None),
        }
    }

    fn time_s(&self, at: Instant) -> Option<f64> {
        self.lamp_on_s.map(|on| microseconds(self.clock.seconds(at) - on))
    }

    fn note(&mut self, sentence: &str) -> Result<(), ScanError> {
        self.engine.observer.event(&ScanEvent::Note(sentence));
        self.event("note", &json!({ "message": sentence }))
    }

    fn event(&mut self, name: &str, fields: &Value) -> Result<(), ScanError> {
        Ok(self.run.event(&self.clock.utc_now(), name, fields)?)
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes
        .iter()
        .fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

fn enough(repeats: Repeats, taken: u32, values: &[f64], last: &LuxReading, noise: Noise) -> bool {
    match repeats {
        Repeats::Exactly(count) => taken >= count,
        Repeats::Until(u_rel) => {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let digit = last.digit.value();
            // Scatter averages out with 1/√n, the rounding of the display does not.
            let scatter = (noise.relative * mean).hypot(noise.absolute_lx) / n.sqrt();
            let u = scatter.hypot(digit / 12.0_f64.sqrt());
            taken >= MOST_REPEATS
                || values.is_empty() && taken >= 3
                || u <= u_rel * mean.abs()
                || scatter <= 0.1 * digit && taken >= 4
        }
    }
}

/// What a broken-off run holds already.
#[derive(Default)]
struct Progress {
    points: HashMap<u64, (u32, Vec<f64>)>,
    references: HashMap<u64, u32>,
    spectra: HashMap<u64, u32>,
    last_point: Option<u64>,
}

impl Progress {
    fn of(resumed: Option<&Run>) -> Self {
        let mut progress = Self::default();
        for reading in resumed.iter().flat_map(|run| &run.readings.rows) {
            match reading.role {
                Role::Reference => *progress.references.entry(reading.point).or_default() += 1,
                Role::Point => {
                    let entry = progress.points.entry(reading.point).or_default();
                    entry.0 += 1;
                    entry.1.extend(reading.illuminance_lx);
                    progress.last_point = progress.last_point.max(Some(reading.point));
                }
            }
        }
        for spectrum in resumed.iter().flat_map(|run| &run.spectra) {
            *progress.spectra.entry(spectrum.point).or_default() += 1;
        }
        progress
    }

    fn has(&self, visit: &Visit, block: &Block) -> bool {
        match (visit.role, block.instrument) {
            (Role::Reference, _) => {
                self.references.contains_key(&visit.point) || self.last_point.is_some_and(|last| last >= visit.point)
            }
            (Role::Point, Instrument::Spectroradiometer) => self.spectra.contains_key(&visit.point),
            (Role::Point, Instrument::Luxmeter) => match (self.points.get(&visit.point), block.repeats) {
                (Some((taken, _)), Repeats::Exactly(count)) => *taken >= count,
                // Whether the goal was met is known once a later point was begun.
                (Some(_), Repeats::Until(_)) => self.last_point.is_some_and(|last| last > visit.point),
                (None, _) => false,
            },
        }
    }

    /// Readings of a visit that are there already: how many, and the numbers among them.
    fn readings(&self, visit: &Visit) -> (u32, &[f64]) {
        match (visit.role, self.points.get(&visit.point)) {
            (Role::Point, Some((taken, values))) => (*taken, values),
            _ => (0, &[]),
        }
    }
}

#[cfg(test)]
mod tests;
