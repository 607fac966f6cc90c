//! Tells a front end what the engine tells: typed, and in words.

use std::cell::{Cell, RefCell};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::run::RunHeader;
use isolux_record::spectra::{DarkSubtraction, SpectralCalibration, SpectrumRecord};
use isolux_record::{Reading, Role};
use isolux_scan::clock::RunClock;
use isolux_scan::warmup::Criterion;
use isolux_scan::{Observer, ScanEvent};
use jiff::Timestamp;

use super::estimate::Estimate;
use crate::front_end::live::{Left, Live, LiveReading, LiveSpectrum, Outline, State, WarmUp};
use crate::front_end::progress::{Event, Progress, duration, ends, left_words};
use crate::run::rest;

/// What a screen shows of a spectrum.
const SHOWN_PIXELS: usize = 400;

/// Tells a front end what the engine tells.
pub struct Narrator<'a> {
    progress: &'a dyn Progress,
    step: RefCell<Option<&'static str>>,
    clock: RunClock,
    criterion: Cell<Option<Criterion>>,
    calibration: Option<SpectralCalibration>,
    estimate: RefCell<Estimate>,
    /// First visit to the reference point since the lamp was switched on, with its distance and its burning.
    first: Cell<Option<(f64, f64)>>,
    resuming: Cell<bool>,
    /// The station file, where its bench goes on existing after the scan.
    station: Option<Utf8PathBuf>,
}

impl<'a> Narrator<'a> {
    /// For a run with this header whose clock is `clock`; `already` are the rows that it holds.
    pub fn new(
        progress: &'a dyn Progress,
        header: &RunHeader,
        run: &str,
        already: &[Reading],
        clock: RunClock,
    ) -> Self {
        let narrator = Self {
            progress,
            step: RefCell::new(None),
            clock,
            criterion: Cell::new(None),
            calibration: header.spectral.clone(),
            estimate: RefCell::new(Estimate::of(header, already)),
            first: Cell::new(None),
            resuming: Cell::new(false),
            station: None,
        };
        narrator.tell(Live::Began(Box::new(Outline::of(header, run))));
        let mut done = 0;
        for reading in already {
            done += u64::from(reading.role == Role::Point);
            narrator.reading(reading, done);
        }
        narrator
    }

    /// With the station file, for what a person may do after the scan.
    #[must_use]
    pub fn of_station(self, file: Option<&Utf8Path>) -> Self {
        Self {
            station: file.map(Utf8Path::to_owned),
            ..self
        }
    }

    fn tell(&self, live: Live) {
        self.progress.event(Event::Live(&live));
    }

    fn now(&self) -> String {
        self.clock.utc_now()
    }

    /// Says what the bench does from now on.
    pub fn state(&self, state: State, sentence: &str) {
        let (sentence, at_utc) = (sentence.to_owned(), self.now());
        self.tell(Live::State {
            state,
            sentence,
            at_utc,
        });
    }

    fn journal(&self, sentence: &str) {
        self.progress.event(Event::Note(sentence));
        let (sentence, at_utc) = (sentence.to_owned(), self.now());
        self.tell(Live::Journal { sentence, at_utc });
    }

    fn begin(&self, step: &'static str, total: Option<u64>) {
        if *self.step.borrow() != Some(step) {
            self.end(String::new());
            *self.step.borrow_mut() = Some(step);
            self.progress.event(Event::Began { step, total });
        }
    }

    /// Ends the step that is on, with a sentence.
    pub fn end(&self, sentence: String) {
        if self.step.borrow_mut().take().is_some() {
            self.progress.event(Event::Ended(&sentence));
            if !sentence.is_empty() {
                let at_utc = self.now();
                self.tell(Live::Journal { sentence, at_utc });
            }
        }
    }

    /// Says how much is left; the same for people.
    fn left(&self, left_s: f64) -> String {
        let now = self.clock.utc_now().parse::<Timestamp>().unwrap_or_default();
        let ends_utc = ends(now, left_s).to_string();
        let words = left_words(left_s, now);
        let estimate = self.estimate.borrow();
        self.tell(Live::Left(Left {
            done: estimate.done(),
            total: estimate.total(),
            left_s,
            ends_utc,
        }));
        words
    }

    fn reading(&self, reading: &Reading, done: u64) {
        // A lamp that is switched on again begins with a reference of its own.
        if reading.role == Role::Reference && reading.kind == isolux_record::ReadingKind::Lit {
            match self.first.get() {
                Some((distance, _)) if distance == reading.distance_mm => {}
                _ => self
                    .first
                    .set(reading.illuminance_lx.map(|lux| (reading.distance_mm, lux))),
            }
        }
        let first = self.first.get().map(|(_, lux)| lux);
        self.tell(Live::Reading(Box::new(LiveReading::of(reading, first, done))));
    }

    fn warm_up(
        &self,
        elapsed_s: f64,
        illuminance_lx: f64,
        spread_rel: Option<f64>,
        power: Option<(Option<f64>, Option<f64>)>,
    ) {
        let Some(criterion) = self.criterion.get() else { return };
        let (power_w, power_spread_rel) = power.unwrap_or_default();
        self.tell(Live::WarmUp(WarmUp {
            elapsed_s,
            illuminance_lx,
            spread_rel,
            allowed_rel: criterion.spread_rel,
            window_s: criterion.window_s,
            power_w,
            power_spread_rel,
        }));
        let to_gate = (criterion.least_s() - elapsed_s).max(0.0);
        let left_s = to_gate + self.estimate.borrow().work_left_s();
        let left = self.left(left_s);
        let spread = spread_rel.map_or_else(String::new, |spread| format!(", {}", spread_words(spread, &criterion)));
        let what = format!("{illuminance_lx:.3} lx{spread}; {left}");
        self.progress.event(Event::At {
            done: elapsed_s as u64,
            what: &what,
        });
    }

    fn spectrum(&self, record: &SpectrumRecord, index: u64) {
        self.progress.event(Event::Note(&format!("spectrum {index} recorded")));
        if let Some(spectrum) = self
            .calibration
            .as_ref()
            .and_then(|calibration| LiveSpectrum::of(record, calibration))
        {
            self.tell(Live::Spectrum(Box::new(LiveSpectrum { index, ..spectrum })));
        }
    }
}

impl LiveSpectrum {
    /// A record, thinned; none where its counts give no irradiance.
    pub(crate) fn of(record: &SpectrumRecord, calibration: &SpectralCalibration) -> Option<Self> {
        let irradiance = record.irradiance(calibration, DarkSubtraction::Spectrum).ok()?;
        let every = record.pixels.len().div_ceil(SHOWN_PIXELS).max(1);
        let wavelengths = record.pixels.iter().map(|pixel| pixel.wavelength_nm);
        Some(Self {
            index: record.index,
            wavelength_nm: wavelengths.step_by(every).collect(),
            irradiance_w_m2_nm: irradiance.irradiance_w_m2_nm.iter().step_by(every).copied().collect(),
            time_s: record.time_s,
        })
    }
}

/// `0.21 % of 0.50 % over 15 min 00 s`.
pub(crate) fn spread_words(spread_rel: f64, criterion: &Criterion) -> String {
    format!(
        "{:.2} % of {:.2} % over {}",
        spread_rel * 100.0,
        criterion.spread_rel * 100.0,
        duration(criterion.window_s)
    )
}

impl Observer for Narrator<'_> {
    fn event(&self, event: &ScanEvent<'_>) {
        match event {
            ScanEvent::Homing => {
                self.begin("home", None);
                self.state(State::Homing, "the axes search their reference");
            }
            ScanEvent::WarmUpBegan { criterion } => {
                self.end("axes referenced".to_owned());
                self.criterion.set(Some(**criterion));
                self.first.set(None);
                self.begin("warm up", Some(criterion.least_s() as u64));
                self.state(State::WarmingUp, "the lamp is watched until it is stable");
            }
            ScanEvent::WarmUp {
                elapsed_s,
                illuminance_lx,
                spread_rel,
                power,
            } => {
                let power = power.map(|power| (power.power_w, power.spread_rel));
                self.warm_up(*elapsed_s, *illuminance_lx, *spread_rel, power);
            }
            ScanEvent::WarmUpEnded { elapsed_s, spread_rel } => {
                let window = self
                    .criterion
                    .get()
                    .map_or_else(String::new, |criterion| spread_words(*spread_rel, &criterion));
                self.end(format!("lamp stable after {}: {window}", duration(*elapsed_s)));
                self.estimate.borrow_mut().begin_work(&self.clock);
            }
            ScanEvent::Block { name, done, total } => {
                self.begin("scan", Some(*total));
                self.state(State::Scanning, &format!("block {name}"));
                self.journal_quietly(&format!("block {name}"));
                let what = format!("block {name}");
                self.progress.event(Event::At {
                    done: *done,
                    what: &what,
                });
            }
            ScanEvent::Reading { reading, done, .. } => {
                if self.resuming.take() {
                    self.state(State::Scanning, "the scan goes on");
                }
                let lux = reading
                    .illuminance_lx
                    .map_or_else(|| reading.quality.to_string(), |lux| format!("{lux:.4} lx"));
                self.reading(reading, *done);
                let left_s = {
                    let mut estimate = self.estimate.borrow_mut();
                    estimate.reached(reading, &self.clock);
                    estimate.left_s()
                };
                let left = self.left(left_s);
                let what = format!(
                    "{} C {:.1}° γ {:.1}° {lux}; {left}",
                    reading.kind, reading.c_target_deg, reading.gamma_target_deg
                );
                self.progress.event(Event::At {
                    done: *done,
                    what: &what,
                });
            }
            ScanEvent::Spectrum { index, record } => {
                self.spectrum(record, *index);
                self.journal_quietly(&format!("spectrum {index} recorded"));
            }
            ScanEvent::Paused {
                by,
                c_deg,
                gamma_deg,
                lamp_is_on,
            } => {
                let lamp = if *lamp_is_on { "on" } else { "off" };
                let sentence = format!("paused by {by}: axes at rest at C {c_deg:.2}°, γ {gamma_deg:.2}°, lamp {lamp}");
                self.journal(&sentence);
                self.state(State::Paused, &sentence);
            }
            ScanEvent::Resumed { by, paused_s } => {
                self.estimate.borrow_mut().paused(*paused_s);
                let sentence = format!("goes on after {} by {by}", duration(*paused_s));
                self.journal(&sentence);
                self.resuming.set(true);
                self.state(State::Resuming, &sentence);
            }
            ScanEvent::Slept {
                slept_s,
                c_deg,
                gamma_deg,
            } => {
                self.estimate.borrow_mut().paused(*slept_s);
                self.journal(&format!(
                    "this program did not run for {} (it was stopped, or the computer slept): axes at rest at C {c_deg:.2}°, γ \
                     {gamma_deg:.2}°; the reference point and the interrupted visit are read again",
                    duration(*slept_s)
                ));
            }
            ScanEvent::Ended(left) => self.journal(&rest::sentence(left, self.station.as_deref())),
            ScanEvent::Note(sentence) => self.journal(sentence),
        }
    }
}

impl Narrator<'_> {
    /// A line for the journal that the terminal shows otherwise.
    fn journal_quietly(&self, sentence: &str) {
        let (sentence, at_utc) = (sentence.to_owned(), self.now());
        self.tell(Live::Journal { sentence, at_utc });
    }
}
