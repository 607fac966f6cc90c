//! One session at the bench: from the first stop to the last visit, and what the instruments were last told.

use std::collections::{HashMap, HashSet};

use isolux_device::LuxRange;
use isolux_record::limits::Limits;
use isolux_record::plan::Plan;
use isolux_record::run::{Run, RunDir};
use isolux_record::{Event, Logged, ReadingKind, Role};
use tokio::time::Instant;

use super::around::{Engine, ScanSummary};
use super::coverage::Coverage;
use super::progress::Progress;
use super::reference::References;

use crate::chosen::Chosen;
use crate::clock::{RunClock, microseconds};
use crate::devices::{Devices, TwoState};
use crate::error::ScanError;
use crate::itinerary::{Visit, is_last_sweep, visits};
use crate::motion::{Axes, drive_rail, stop_all};
use crate::settle::Photometer;

/// A session and the state in which it left the bench.
pub(super) struct Session<'a> {
    pub engine: &'a Engine<'a>,
    pub devices: &'a Devices,
    pub run: &'a mut RunDir,
    pub clock: RunClock,
    pub axes: Axes<'a>,
    pub photometer: Photometer<'a>,
    pub limits: Limits,
    /// Seconds of the run at which the lamp was switched on; none: never yet.
    pub lamp_on_s: Option<f64>,
    pub lamp_is_on: bool,
    pub warm: bool,
    pub shutter_open: Option<bool>,
    /// Whether the lux meter has its dark, if it needs one.
    pub dark_taken: bool,
    pub baffle_in: Option<bool>,
    /// Where the lux meter stands.
    pub distance_mm: f64,
    /// Where the rail was driven to; none where it is not driven.
    pub rail_mm: Option<f64>,
    pub references: References,
    /// Whether the lamp was left alone during a pause and not looked at since.
    pub lamp_unproven: bool,
    pub done: u64,
    pub total: u64,
    pub spectra: u64,
    pub without_number: u64,
    pub unsettled: u64,
    pub visits_again: u64,
    pub warm_up_s: Option<f64>,
    /// Ranges above the expected one that sweeps need, because their light was over range.
    pub range_up: u8,
    /// Ranges above the one chosen that the present sweep of dim light needs.
    pub dim_range_up: u8,
    /// Where sweeps have light.
    pub coverage: Coverage,
    /// What half-planes are chosen by, of every block of sweeps.
    pub chosen: HashMap<String, Chosen>,
    /// Blocks whose symmetry rings have shown.
    pub symmetric: HashSet<String>,
    /// How far the computer's clock is ahead of the run's, by the last look.
    pub wall_ahead_s: f64,
}

impl<'a> Session<'a> {
    pub fn new(
        engine: &'a Engine<'a>,
        devices: &'a Devices,
        run: &'a mut RunDir,
        clock: RunClock,
        limits: Limits,
    ) -> Self {
        let mut photometer = Photometer::new(devices.meter.as_ref());
        // The scatter under the lit lamp says nothing of that near zero; what the station states does. A resumed scan
        // may end without a warm-up.
        photometer.noise.absolute_lx = engine.station.luxmeter().noise_lx.unwrap_or_default();
        Self {
            engine,
            devices,
            run,
            clock,
            axes: Axes::new(devices, engine.station),
            photometer,
            limits,
            lamp_on_s: None,
            lamp_is_on: false,
            warm: false,
            shutter_open: None,
            dark_taken: false,
            baffle_in: None,
            distance_mm: engine.station.bench().distance_mm,
            rail_mm: None,
            references: References::default(),
            lamp_unproven: false,
            done: 0,
            total: 0,
            spectra: 0,
            without_number: 0,
            unsettled: 0,
            visits_again: 0,
            warm_up_s: None,
            range_up: 0,
            dim_range_up: 0,
            coverage: Coverage::default(),
            chosen: HashMap::new(),
            symmetric: HashSet::new(),
            wall_ahead_s: 0.0,
        }
    }

    pub fn summary(&self, before: u64) -> ScanSummary {
        ScanSummary {
            points: self.total,
            readings: self.run.len() - before,
            spectra: self.spectra,
            without_number: self.without_number,
            unsettled: self.unsettled,
            retries: self.photometer.retries,
            visits_again: self.visits_again,
            duration_s: self.clock.session_seconds(Instant::now()),
            warm_up_s: self.warm_up_s,
        }
    }

    /// The whole plan, less what `resumed` holds.
    pub async fn day(&mut self, plan: &Plan, resumed: Option<&Run>) -> Result<(), ScanError> {
        let visits = visits(plan);
        let progress = Progress::of(resumed);
        self.coverage = Coverage::of(resumed);
        self.chosen = Chosen::by_block(resumed);
        self.total = visits.iter().filter(|visit| visit.role == Role::Point).count() as u64;
        self.event(Event::Began {
            points: self.total,
            resumed: resumed.is_some(),
        })?;
        self.awake(async |session| session.begin(resumed).await).await?;
        let mut current = None;
        for (place, visit) in visits.iter().enumerate() {
            let block = &plan.blocks()[visit.block];
            let last_sweep = is_last_sweep(&visits, place);
            let has = progress.has(visit, block);
            self.done += u64::from(has && visit.role == Role::Point);
            // Which of them are swept is decided once the first half-plane is.
            let made = has || visit.is_to_be_chosen(block);
            let complete = |session: &Self| {
                session.next_sweep(block).is_none()
                    && session.next_second(block).is_none()
                    && !session.coverage.lacks(block)
                    && !session.lacks_checks(visit, &visits, &progress)
            };
            if made && (!last_sweep || complete(self)) {
                continue;
            }
            self.look_at_wall_clock()?;
            self.awake(async |session| session.pause_if_asked().await).await?;
            if current != Some(visit.block) {
                self.awake(async |session| session.place(block).await).await?;
                self.awake(async |session| session.outputs(block).await).await?;
                let name = block.name.clone();
                self.event(Event::Block { name })?;
                if resumed.is_some() && current.is_none() && block.kind == ReadingKind::Lit {
                    // What was read before is trusted again only against the reference point.
                    let reference = visit.reference_before();
                    self.awake(async |session| session.visit(block, &reference, (0, &[])).await)
                        .await?;
                }
                current = Some(visit.block);
            }
            if !made {
                self.judge_symmetry(block, visit)?;
                let visit = &self.with_its_gamma(block, visit);
                let already = progress.readings(visit);
                self.awake(async |session| {
                    session.prove_lamp(block, visit).await?;
                    session.visit(block, visit, already).await
                })
                .await?;
            }
            if last_sweep {
                let of_block = |one: &&Visit| one.block == visit.block;
                let of_block: Vec<Visit> = visits.iter().filter(of_block).copied().collect();
                self.sweep_chosen(block, &of_block).await?;
                self.sweep_again_in_part(block, &of_block).await?;
                self.fill_gaps(block, &of_block).await?;
                self.read_at_rest(visit, &visits, &progress).await?;
            }
        }
        Ok(())
    }

    /// Everything up to the first block: axes and rail at rest where they belong, the lamp found.
    async fn begin(&mut self, resumed: Option<&Run>) -> Result<(), ScanError> {
        // A program that was killed may have left an axis running.
        stop_all(self.devices).await.map_err(|axes| ScanError::NotAtRest {
            axes,
            before: String::new(),
        })?;
        self.axes.home().await?;
        self.event(Event::Homed {})?;
        self.devices
            .meter
            .set_range(LuxRange::Auto)
            .await
            .map_err(ScanError::device("luxmeter"))?;
        if let Some(rail) = &self.devices.rail {
            let home_mm = self.engine.station.bench().distance_mm;
            drive_rail(rail.as_ref(), home_mm).await?;
            self.rail_mm = Some(home_mm);
        }
        self.find_lamp(resumed).await
    }

    /// Whether the lamp is on already, and since when. Only a lamp of this very run has a known time.
    async fn find_lamp(&mut self, resumed: Option<&Run>) -> Result<(), ScanError> {
        let since = resumed.and_then(|run| self.lit_since(run));
        self.references = resumed.map_or_else(References::default, |run| {
            References::of(&run.readings.rows, &self.limits)
        });
        match &self.devices.lamp {
            Some(TwoState::Device(lamp)) => {
                let on = lamp.state().await.map_err(ScanError::device("lamp"))?;
                if on && let Some(since) = since {
                    self.lamp_is_on = true;
                    self.lamp_on_s = Some(since);
                    // Known to be on since then; whether it is stable, its light decides again, and the last reference
                    // visits of the run still are of this burning.
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

    /// Seconds of the run at which the lamp was last switched on: by the last reading since, else by the UTC of it, for
    /// the clock of the computer may have been set meanwhile.
    fn lit_since(&self, run: &Run) -> Option<f64> {
        let last = run.readings.rows.last();
        let by_reading = last
            .filter(|row| row.burning == Some(run.header.burnings))
            .and_then(|row| Some(row.time_s? - row.lamp_s?));
        by_reading.or_else(|| self.clock.seconds_of_utc(run.header.lamp_on_utc.as_deref()?))
    }

    /// The lamp was switched on at this moment: its clock and its reference visits begin anew.
    pub fn lamp_now_on(&mut self) -> Result<(), ScanError> {
        let now = Instant::now();
        self.lamp_is_on = true;
        self.warm = false;
        self.lamp_unproven = false;
        self.lamp_on_s = Some(self.clock.seconds(now));
        self.references.next_burning();
        self.run.lamp_on(self.clock.utc(now))?;
        Ok(())
    }

    pub async fn ambient_c(&self) -> Result<Option<f64>, ScanError> {
        match &self.devices.ambient {
            Some(thermometer) => {
                let reading = thermometer.read().await.map_err(ScanError::device("ambient"))?;
                Ok(Some(reading.temperature.value()))
            }
            None => Ok(None),
        }
    }

    /// Seconds since the run began.
    pub fn time_s(&self, at: Instant) -> f64 {
        microseconds(self.clock.seconds(at))
    }

    /// Seconds since the lamp was switched on; none before that.
    pub fn lamp_s(&self, at: Instant) -> Option<f64> {
        self.lamp_on_s.map(|on| microseconds(self.clock.seconds(at) - on))
    }

    pub fn note(&mut self, sentence: &str) -> Result<(), ScanError> {
        let message = sentence.to_owned();
        self.event(Event::Note { message })
    }

    /// Records what has happened, and tells it.
    pub fn event(&mut self, event: Event) -> Result<(), ScanError> {
        let logged = self.now(event);
        self.run.event(&logged)?;
        self.engine.observer.event(&logged);
        Ok(())
    }

    /// What happens at this moment.
    pub fn now(&self, event: Event) -> Logged {
        let time_utc = self.clock.utc_now();
        Logged { time_utc, event }
    }
}

impl Visit {
    /// A visit to the reference point just before this one.
    pub(super) fn reference_before(&self) -> Self {
        let (c_deg, gamma_deg) = crate::itinerary::REFERENCE_DEG;
        Self {
            role: Role::Reference,
            c_deg,
            gamma_deg,
            pass: None,
            again: false,
            ..*self
        }
    }
}
