//! A run directory as events: of a run that was finished, and of one that another process is writing.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::{Event, Logged, Run, RunLock, event};

use crate::Failure;
use crate::front_end::live::{Live, Outline, State};
use crate::run::record;
use crate::scan::ScanState;

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
    let requested = holder.map_or_else(
        || Err("it does not say who it is".to_owned()),
        isolux_lock::Holder::ask_to_end,
    );
    match requested {
        Ok(()) => Ok(format!("{held} was asked to end; it stops its axes")),
        Err(why) => Err(Failure::instrument(format!("{held} could not be asked to end: {why}"))
            .help("end it by hand, or run `isolux stop STATION.toml`")),
    }
}

/// What a run directory tells from its beginning on; further calls tell what has come since.
#[derive(Debug)]
pub struct Replay {
    path: Utf8PathBuf,
    scan: Option<ScanState>,
    events: usize,
    rows: usize,
    spectra: BTreeSet<u64>,
}

impl Replay {
    /// Of the run directory `path`, which is read by [`further`](Self::further).
    pub fn of(path: &Utf8Path) -> Self {
        Self {
            path: path.to_owned(),
            scan: None,
            events: 0,
            rows: 0,
            spectra: BTreeSet::new(),
        }
    }

    /// What has come since the last call; at the first one with the outline of the scan.
    ///
    /// # Errors
    /// Bad input (exit 2) for what is no run directory, or a damaged one.
    pub fn further(&mut self) -> Result<(Option<Outline>, Vec<Live>), Failure> {
        let run = record::read(&self.path)?;
        let outline = self
            .scan
            .is_none()
            .then(|| Outline::of(&run.header, self.path.as_str()));
        let recorded = self.recorded(&run);
        let scan = self.scan.get_or_insert_with(|| ScanState::of(&run.header));
        let mut events: Vec<Live> = recorded.into_iter().map(|logged| scan.follow(logged)).collect();
        // The end is recorded in run.toml where the events could not be written, too.
        let ended = matches!(
            scan.state(),
            Some(State::Completed | State::Interrupted | State::Failed)
        );
        if let Some(stopped) = run.header.stopped.filter(|_| !ended) {
            events.push(scan.follow(stopped.logged()));
        }
        Ok((outline, events))
    }

    /// Events, rows and spectra that were not given yet, in the order of time.
    fn recorded(&mut self, run: &Run) -> Vec<Logged> {
        let spectrum = |index: u64| run.spectra.iter().find(|record| record.index == index);
        let mut all: Vec<Logged> = event::read(&self.path).into_iter().skip(self.events).collect();
        self.events += all.len();
        let mut given = std::mem::take(&mut self.spectra);
        all.retain_mut(|logged| match &mut logged.event {
            Event::Spectrum { index, record, .. } => {
                *record = spectrum(*index).cloned().map(Box::new);
                given.insert(*index)
            }
            _ => true,
        });
        // A program that is killed has recorded a spectrum and not yet the event of it.
        let new = run.spectra.iter().filter(|record| given.insert(record.index));
        all.extend(new.map(|record| Logged {
            time_utc: run.header.utc(record.time_s),
            event: Event::Spectrum {
                index: record.index,
                integration_s: record.integration_s,
                record: Some(Box::new(record.clone())),
            },
        }));
        self.spectra = given;
        all.extend(
            run.readings
                .rows
                .iter()
                .skip(self.rows)
                .map(|row| run.header.logged(row)),
        );
        self.rows = self.rows.max(run.readings.rows.len());
        all.sort_by_cached_key(|logged| logged.time_utc.parse::<jiff::Timestamp>().unwrap_or_default());
        all
    }
}
