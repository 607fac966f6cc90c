//! A run directory as events: of a run that was finished, and of one that another process is writing.

use std::collections::HashMap;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::run::StopHow;
use isolux_record::{Reading, ReadingKind, Role, Run, RunLock};
use serde_json::Value;

use crate::Failure;
use crate::front_end::live::{Left, Live, LiveReading, LiveSpectrum, Outline, State, WarmUp};
use crate::run::record;

/// Who writes a run directory, where another process does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Writer {
    /// In words: program, process, since when.
    pub words: String,
}

/// Who writes the run directory `run` now, this process left out.
pub fn writer(run: &Utf8Path) -> Option<Writer> {
    let us = std::process::id();
    let held = RunLock::held(run).filter(|held| held.holder.as_ref().is_none_or(|holder| holder.pid != us))?;
    Some(Writer {
        words: held.to_string(),
    })
}

/// Asks the process that writes the run directory `run` to end: it stops its axes and verifies that they rest.
///
/// # Errors
/// Exit 3 when nobody writes it, or its writer cannot be asked.
pub fn ask_writer_to_end(run: &Utf8Path) -> Result<String, Failure> {
    let held = RunLock::held(run).ok_or_else(|| Failure::instrument(format!("nobody writes {run} now")))?;
    let holder = held.holder.as_ref();
    let asked = holder.map_or_else(
        || Err("it does not say who it is".to_owned()),
        isolux_lock::Holder::ask_to_end,
    );
    match asked {
        Ok(()) => Ok(format!("{held} was asked to end; it stops its axes")),
        Err(why) => Err(Failure::instrument(format!("{held} could not be asked to end: {why}"))
            .help("end it by hand, or run `isolux stop STATION.toml`")),
    }
}

/// What a run directory tells from its beginning on; further calls tell what has come since.
#[derive(Debug)]
pub struct Replay {
    path: Utf8PathBuf,
    began: bool,
    rows: usize,
    spectra: usize,
    events: usize,
    ended: Option<(StopHow, String)>,
    done: std::collections::BTreeSet<u64>,
    first: HashMap<(Option<u32>, u64), f64>,
}

impl Replay {
    /// Of the run directory `path`, which is read by [`further`](Self::further).
    pub fn of(path: &Utf8Path) -> Self {
        Self {
            path: path.to_owned(),
            began: false,
            rows: 0,
            spectra: 0,
            events: 0,
            ended: None,
            done: std::collections::BTreeSet::new(),
            first: HashMap::new(),
        }
    }

    /// What has come since the last call.
    ///
    /// # Errors
    /// Bad input (exit 2) for what is no run directory, or a damaged one.
    pub fn further(&mut self) -> Result<Vec<Live>, Failure> {
        let run = record::read(&self.path)?;
        let mut told = Vec::new();
        if !self.began {
            self.began = true;
            told.push(Live::Began(Box::new(Outline::of(&run.header, self.path.as_str()))));
        }
        self.events(&mut told);
        for reading in run.readings.rows.iter().skip(self.rows) {
            told.push(Live::Reading(Box::new(self.reading(reading))));
        }
        self.rows = self.rows.max(run.readings.rows.len());
        if let Some(calibration) = &run.header.spectral {
            let further = run.spectra.iter().skip(self.spectra);
            let further = further.filter_map(|record| LiveSpectrum::of(record, calibration));
            told.extend(further.map(|spectrum| Live::Spectrum(Box::new(spectrum))));
        }
        self.spectra = self.spectra.max(run.spectra.len());
        self.end(&run, &mut told);
        Ok(told)
    }

    fn reading(&mut self, reading: &Reading) -> LiveReading {
        if reading.role == Role::Point {
            self.done.insert(reading.point);
        }
        let key = (reading.burning, reading.distance_mm.to_bits());
        if reading.role == Role::Reference
            && reading.kind == ReadingKind::Lit
            && let Some(lux) = reading.illuminance_lx
        {
            self.first.entry(key).or_insert(lux);
        }
        LiveReading::of(reading, self.first.get(&key).copied(), self.done.len() as u64)
    }

    /// Lines of events.jsonl; a line that is not whole yet is taken by the next call.
    fn events(&mut self, told: &mut Vec<Live>) {
        let text = std::fs::read_to_string(self.path.join("events.jsonl")).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        for line in whole.lines().skip(self.events) {
            self.events += 1;
            let Ok(event) = serde_json::from_str::<Value>(line) else {
                continue;
            };
            let at_utc = event["time_utc"].as_str().unwrap_or_default().to_owned();
            let text = |key: &str| event[key].as_str().unwrap_or_default().to_owned();
            let number = |key: &str| event[key].as_f64();
            let (state, sentence) = match event["event"].as_str().unwrap_or_default() {
                "began" => (Some(State::Homing), "the axes search their reference".to_owned()),
                "homed" => (None, "axes referenced".to_owned()),
                "warm_up" => {
                    told.push(Live::WarmUp(WarmUp {
                        elapsed_s: number("lamp_s").or_else(|| number("time_s")).unwrap_or_default(),
                        illuminance_lx: number("illuminance_lx").unwrap_or_default(),
                        spread_rel: number("spread_rel"),
                        allowed_rel: 0.0,
                        window_s: 0.0,
                        power_w: number("power_w"),
                        power_spread_rel: number("power_spread_rel"),
                    }));
                    continue;
                }
                "stable" => (None, "lamp stable".to_owned()),
                "block" => (Some(State::Scanning), format!("block {}", text("name"))),
                "note" | "stopped" => (None, text("message")),
                "again" => (None, format!("measured again: {}", text("reason"))),
                "paused" => (Some(State::Paused), format!("paused by {}", text("by"))),
                "resumed" => (Some(State::Scanning), format!("goes on, by {}", text("by"))),
                "lamp" => {
                    let on = event["on"].as_bool() == Some(true);
                    let sentence = if on { "lamp on" } else { "lamp off" };
                    (on.then_some(State::WarmingUp), sentence.to_owned())
                }
                "spectrum" => (None, "spectrum recorded".to_owned()),
                "asked" => (None, format!("asked: {}", text("prompt"))),
                _ => continue,
            };
            if let Some(state) = state {
                let (sentence, at_utc) = (sentence.clone(), at_utc.clone());
                told.push(Live::State {
                    state,
                    sentence,
                    at_utc,
                });
            }
            told.push(Live::Journal { sentence, at_utc });
        }
    }

    fn end(&mut self, run: &Run, told: &mut Vec<Live>) {
        let total = isolux_scan::itinerary::visits(&run.header.plan);
        let total = total.iter().filter(|visit| visit.role == Role::Point).count() as u64;
        let at_utc = run.header.stopped.as_ref().map(|stopped| stopped.utc.clone());
        let done = (self.done.len() + run.spectra.len()) as u64;
        if !told.is_empty() {
            let remaining = run.header.stopped.is_none();
            let mut estimate = crate::scan::Estimate::of(&run.header, &[]);
            run.readings.rows.iter().for_each(|row| estimate.advance(row));
            let left_s = if remaining { estimate.left_s() } else { 0.0 };
            let ends_utc = at_utc.clone().unwrap_or_default();
            told.push(Live::Left(Left {
                done,
                total,
                left_s,
                ends_utc,
            }));
        }
        let Some(stopped) = &run.header.stopped else { return };
        let ended = (stopped.how, stopped.message.clone());
        if self.ended.as_ref() != Some(&ended) {
            let state = match stopped.how {
                StopHow::Completed => State::Completed,
                StopHow::Interrupted => State::Interrupted,
                StopHow::Failed => State::Failed,
            };
            let rest = if stopped.axes_at_rest {
                "the axes are at rest"
            } else {
                "AXES NOT VERIFIED AT REST"
            };
            told.push(Live::State {
                state,
                sentence: format!("{}; {rest}", stopped.message),
                at_utc: stopped.utc.clone(),
            });
            self.ended = Some(ended);
        }
    }
}
