//! Tells a front end what the engine does: each event with what it means, and the steps and sentences of the terminal.

use std::cell::RefCell;

use camino::Utf8Path;
use isolux_record::run::RunHeader;
use isolux_record::{Event, Logged, Reading};
use isolux_scan::Observer;
use jiff::Timestamp;

use super::state::{ScanState, look_words};
use crate::front_end::live::{Live, Outline};
use crate::front_end::progress::{self, Progress, left_words};
use crate::run::rest;

/// Tells a front end what the engine does.
pub struct Narrator<'a> {
    progress: &'a dyn Progress,
    step: RefCell<Option<&'static str>>,
    scan: RefCell<ScanState>,
    /// When the last event happened.
    last_utc: RefCell<String>,
    /// The station file, where its bench goes on existing after the scan.
    station: Option<&'a Utf8Path>,
}

impl<'a> Narrator<'a> {
    /// For the run in `run` with this header; `already` are the rows that it holds. `station` is the station file, where
    /// its bench goes on existing after the scan.
    pub fn new(
        progress: &'a dyn Progress,
        header: &RunHeader,
        run: &Utf8Path,
        already: &[Reading],
        station: Option<&'a Utf8Path>,
    ) -> Self {
        let narrator = Self {
            progress,
            step: RefCell::new(None),
            scan: RefCell::new(ScanState::of(header)),
            last_utc: RefCell::new(header.started_utc.clone()),
            station,
        };
        progress.event(progress::Event::Outline(&Outline::of(header, run.as_str())));
        for reading in already {
            narrator.follow(&header.logged(reading));
        }
        narrator
    }

    fn follow(&self, logged: &Logged) -> Live {
        self.last_utc.replace(logged.time_utc.clone());
        let live = self.scan.borrow_mut().follow(logged.clone());
        self.progress.event(progress::Event::Live(&live));
        live
    }

    fn begin(&self, step: &'static str, total: Option<u64>) {
        if *self.step.borrow() != Some(step) {
            self.end("");
            *self.step.borrow_mut() = Some(step);
            self.progress.event(progress::Event::Began { step, total });
        }
    }

    fn at(&self, done: u64, what: &str) {
        self.progress.event(progress::Event::At { done, what });
    }

    fn end(&self, sentence: &str) {
        if self.step.borrow_mut().take().is_some() {
            self.progress.event(progress::Event::Ended(sentence));
        }
    }

    /// The scan has ended, in a sentence.
    pub fn ended(&self, sentence: &str) {
        self.end(sentence);
        let live = Live::note(self.last_utc.borrow().clone(), sentence);
        self.progress.event(progress::Event::Live(&live));
    }

    /// The steps of the terminal, and what it says beside them.
    fn say(&self, live: &Live) {
        let sentence = live.sentence.as_deref().unwrap_or_default();
        let left = || {
            let at = live.logged.time_utc.parse::<Timestamp>().unwrap_or_default();
            live.left
                .as_ref()
                .map_or_else(String::new, |left| left_words(left.left_s, at))
        };
        let (done, total) = self.scan.borrow().points();
        let criterion = *self.scan.borrow().criterion();
        let warm_up = || self.begin("warm up", Some(criterion.least_s() as u64));
        match &live.logged.event {
            Event::Began { .. } => self.begin("home", None),
            Event::Homed {} | Event::Stable { .. } => self.end(sentence),
            Event::Lamp { on: true } => warm_up(),
            Event::WarmUp(look) => {
                warm_up();
                self.at(
                    look.lamp_s as u64,
                    &format!("{}; {}", look_words(look, &criterion), left()),
                );
            }
            Event::Block { .. } => {
                self.begin("scan", Some(total));
                self.at(done, sentence);
            }
            Event::Reading(reading) => {
                self.begin("scan", Some(total));
                let lux = reading
                    .illuminance_lx
                    .map_or_else(|| reading.quality.to_string(), |lux| format!("{lux:.4} lx"));
                let (kind, c, gamma) = (reading.kind, reading.c_target_deg, reading.gamma_target_deg);
                self.at(done, &format!("{kind} C {c:.1}° γ {gamma:.1}° {lux}; {}", left()));
            }
            Event::Stopped { left: Some(left), .. } => {
                self.progress
                    .event(progress::Event::Note(&rest::sentence(left, self.station)));
            }
            Event::Spectrum { .. }
            | Event::Sweep { .. }
            | Event::HalfPlanes { .. }
            | Event::SecondSweep { .. }
            | Event::Symmetry { .. }
            | Event::Again { .. }
            | Event::Paused { .. }
            | Event::Resumed { .. }
            | Event::BenchFound { .. }
            | Event::Note { .. } => self.progress.event(progress::Event::Note(sentence)),
            _ => {}
        }
    }
}

impl Observer for Narrator<'_> {
    fn event(&self, logged: &Logged) {
        self.say(&self.follow(logged));
    }
}
