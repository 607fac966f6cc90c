//! The run directory: what a bench did, readable after any death of the program that wrote it.

pub(crate) mod axis;
mod error;
mod format;
mod header;
mod read;

use std::fs::OpenOptions;

use camino::{Utf8Path, Utf8PathBuf};

pub use error::{RunError, vacant};
pub use format::{FORMAT, FORMAT_3};
pub use header::{BenchCheck, DeviceRecord, Resumed, RunHeader, SpectrumEntry, Stopped, Written};

use crate::disk::{self, Appended, failed, sha256};
pub use crate::event::StopHow;
use crate::event::{EVENTS_FILE, Event, Logged};
use crate::reading::Reading;
use crate::readings::Chain;
use crate::run_lock::RunLock;
use crate::spectra::{SpectralCalibration, SpectrumRecord};
use crate::sweeps::SweepRecord;
pub use read::Run;
use read::Survey;

/// run.toml says how far readings.csv is written after the first row and after every so many.
const ROWS_PER_HEADER: u64 = 50;

/// Writes a run. Whatever is returned from is on the disk.
#[derive(Debug)]
pub struct RunDir {
    path: Utf8PathBuf,
    header: RunHeader,
    readings: Appended,
    chain: Chain,
    next_index: u64,
    next_spectrum: u64,
    next_sweep: u64,
    start_s: f64,
    events: Appended,
    event_count: u64,
    lock: Option<RunLock>,
}

impl RunDir {
    /// Writes only as long as `lock` is held: nothing once another process has taken it over.
    pub fn guard(&mut self, lock: RunLock) {
        self.lock = Some(lock);
    }

    /// Whether this process may write here still.
    ///
    /// # Errors
    /// [`RunError::TakenOver`].
    pub fn still_ours(&self) -> Result<(), RunError> {
        match &self.lock {
            Some(lock) if !lock.is_ours() => Err(RunError::TakenOver {
                path: self.path.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Begins a run in `path`, which must not exist, be empty, or hold what a program that was killed had begun there.
    ///
    /// # Errors
    /// [`RunError::Occupied`], or what the system says.
    pub fn create(path: &Utf8Path, header: RunHeader) -> Result<Self, RunError> {
        if !vacant(path) {
            return Err(RunError::Occupied { path: path.to_owned() });
        }
        disk::create_folder(&path.join("spectra"))?;
        let readings_path = path.join("readings.csv");
        let columns = header.layout().header();
        disk::replace(&readings_path, columns.as_bytes())?;
        let events_path = path.join(EVENTS_FILE);
        disk::replace(&events_path, b"")?;
        let mut run = Self {
            path: path.to_owned(),
            chain: Chain::new(header.layout()),
            header,
            readings: Appended::open(&readings_path, columns.as_bytes())?,
            next_index: 0,
            next_spectrum: 0,
            next_sweep: 0,
            start_s: 0.0,
            events: Appended::open(&events_path, b"")?,
            event_count: 0,
            lock: None,
        };
        // run.toml last: a folder with it is a run.
        run.write_header()?;
        Ok(run)
    }

    /// Resumes a run that broke off: the torn tail is cut off, the next rows follow the whole ones. Plan, station and
    /// the serial numbers of the instruments must be those of the run.
    ///
    /// # Errors
    /// [`RunError::Changed`] names what differs, [`RunError::Damaged`] what is not as it was recorded.
    pub fn resume(path: &Utf8Path, now: &RunHeader) -> Result<(Self, Run), RunError> {
        Self::again(Survey::of(path)?.whole()?, now)
    }

    /// Resumes a run with a damaged record: what is whole stays, damaged files are set aside in a folder of the run,
    /// run.toml says so, and what is missing can be read again.
    ///
    /// # Errors
    /// As [`resume`](Self::resume), but for the damage.
    pub fn reread(path: &Utf8Path, now: &RunHeader) -> Result<(Self, Run), RunError> {
        Self::again(Survey::of(path)?, now)
    }

    fn again(survey: Survey, now: &RunHeader) -> Result<(Self, Run), RunError> {
        let run = &survey.run;
        let path = run.path.clone();
        same_bench(&path, &run.header, now)?;
        disk::remove_unpublished(&path)?;
        let set_aside = set_aside(&path, &survey.damaged_files)?;
        let mut header = run.header.clone();
        let layout = header.layout();
        let indices = run.spectra.iter().map(|spectrum| spectrum.index);
        let next_spectrum = indices
            .chain(header.spectrum.iter().map(|entry| entry.index))
            .max()
            .map_or(0, |last| last + 1);
        let next_sweep = header
            .sweep
            .iter()
            .map(|entry| entry.index + 1)
            .max()
            .unwrap_or_default();
        let start_s = run.next_session_s(&now.started_utc);
        header.stopped = None;
        header.state(&now.subject());
        header
            .spectrum
            .retain(|entry| run.spectra.iter().any(|spectrum| spectrum.index == entry.index));
        header
            .sweep
            .retain(|entry| entry.torn || run.sweeps.iter().any(|sweep| sweep.of.index == entry.index));
        header.resumed.push(Resumed {
            utc: now.started_utc.clone(),
            program: now.program.clone(),
            first_row: run.readings.rows.len() as u64,
            start_s: layout.has_run_time().then_some(start_s),
            damage: survey.damage.clone(),
            set_aside,
        });
        header.written = None;
        // The whole rows are written anew: what the disk holds after a failed sync is not what a reader saw.
        let whole = survey.readings.get(..run.readings.whole_bytes).unwrap_or_default();
        let columns = layout.header();
        let whole = if run.readings.rows.is_empty() {
            columns.as_bytes()
        } else {
            whole
        };
        let readings_path = path.join("readings.csv");
        disk::replace(&readings_path, whole)?;
        let events_path = path.join(EVENTS_FILE);
        let events = whole_lines(&events_path)?;
        let mut dir = Self {
            readings: Appended::open(&readings_path, whole)?,
            chain: if run.readings.layout == layout {
                run.readings.chain()
            } else {
                Chain::new(layout)
            },
            next_index: run.readings.rows.len() as u64,
            next_spectrum,
            next_sweep,
            start_s,
            events: Appended::open(&events_path, &events)?,
            event_count: disk::lines(&events),
            lock: None,
            header,
            path,
        };
        if let Some(first) = run.readings.chains.first() {
            dir.header.written = Some(Written {
                readings: dir.next_index,
                first_chain: first.clone(),
                chain: dir.chain.last().to_owned(),
            });
        }
        dir.write_header()?;
        if !survey.damage.is_empty() {
            dir.event(&Logged {
                time_utc: now.started_utc.clone(),
                event: Event::Reread {
                    damage: survey.damage,
                    first_row: dir.next_index,
                },
            })?;
        }
        Ok((dir, survey.run))
    }

    /// The folder.
    pub fn path(&self) -> &Utf8Path {
        &self.path
    }

    /// run.toml as it stands.
    pub fn header(&self) -> &RunHeader {
        &self.header
    }

    /// Readings recorded so far.
    pub fn len(&self) -> u64 {
        self.next_index
    }

    /// Seconds since the run began at which this session began.
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// Whether no reading was recorded yet.
    pub fn is_empty(&self) -> bool {
        self.next_index == 0
    }

    /// Appends one reading and syncs; its `index`, `session` and `burning` are set here. When this returns it, the row
    /// outlives a loss of power. After an error no further row is taken: the run has to be resumed.
    ///
    /// # Errors
    /// What the system says.
    pub fn append(&mut self, mut reading: Reading) -> Result<Reading, RunError> {
        self.still_ours()?;
        reading.index = self.next_index;
        reading.session = self.header.resumed.len() as u32;
        reading.burning = Some(self.header.burnings);
        let (row, chain) = self.chain.row(&reading);
        self.readings.write_synced(row.as_bytes())?;
        self.chain = chain;
        self.next_index += 1;
        if self.next_index == 1 || self.next_index.is_multiple_of(ROWS_PER_HEADER) {
            self.write_header()?;
        }
        Ok(reading)
    }

    /// Writes one spectrum whole; its `index` is set here.
    ///
    /// # Errors
    /// What the system says, or why the counts give no irradiance.
    pub fn spectrum(
        &mut self,
        mut spectrum: SpectrumRecord,
        calibration: &SpectralCalibration,
    ) -> Result<u64, RunError> {
        self.still_ours()?;
        spectrum.index = self.next_spectrum;
        let text = spectrum.to_csv(calibration)?;
        let entry = SpectrumEntry {
            index: spectrum.index,
            pixels: spectrum.pixels.len() as u64,
            sha256: sha256(text.as_bytes()),
        };
        disk::replace(&self.path.join(entry.file()), text.as_bytes())?;
        self.next_spectrum += 1;
        self.header.spectrum.push(entry);
        self.write_header()?;
        Ok(spectrum.index)
    }

    /// Writes one sweep whole, or what there is of a torn one; its `index`, `session` and `burning` are set here.
    ///
    /// # Errors
    /// What the system says.
    pub fn sweep(&mut self, mut sweep: SweepRecord) -> Result<u64, RunError> {
        self.still_ours()?;
        sweep.of.index = self.next_sweep;
        sweep.of.session = self.header.resumed.len() as u32;
        sweep.of.burning = self.header.burnings;
        let text = sweep.to_csv()?;
        let entry = sweep.entry(text.as_bytes());
        disk::create_folder(&self.path.join("sweeps"))?;
        disk::replace(&self.path.join(entry.file()), text.as_bytes())?;
        self.next_sweep += 1;
        self.header.sweep.push(entry);
        self.write_header()?;
        Ok(sweep.of.index)
    }

    /// Appends one event.
    ///
    /// # Errors
    /// What the system says.
    pub fn event(&mut self, logged: &Logged) -> Result<(), RunError> {
        self.still_ours()?;
        // By way of a value: its keys are in the order of the alphabet.
        let line = serde_json::to_value(logged).map_err(RunError::Event)?;
        self.events.write(format!("{line}\n").as_bytes())?;
        self.event_count += 1;
        Ok(())
    }

    /// Records when the lamp was switched on.
    ///
    /// # Errors
    /// What the system says.
    pub fn lamp_on(&mut self, utc: String) -> Result<(), RunError> {
        self.header.lamp_on_utc = Some(utc);
        self.header.burnings += 1;
        self.write_header()
    }

    /// Records how the run ended, with number and hash of its rows and events. run.toml is replaced in one step: it
    /// says so, or it does not.
    ///
    /// # Errors
    /// What the system says.
    pub fn stop(&mut self, mut stopped: Stopped) -> Result<(), RunError> {
        stopped.readings = self.next_index;
        stopped.readings_sha256 = Some(self.readings.sha256());
        stopped.events = Some(self.event_count);
        stopped.events_sha256 = Some(self.events.sha256());
        // The record of the end does not wait for the events, from which no number is computed.
        let synced = self.events.sync();
        self.header.stopped = Some(stopped);
        self.write_header()?;
        Ok(synced?)
    }

    fn write_header(&mut self) -> Result<(), RunError> {
        self.still_ours()?;
        if self.next_index > 0 {
            let chain = self.chain.last().to_owned();
            let written = self.header.written.get_or_insert_with(|| Written {
                readings: 0,
                first_chain: chain.clone(),
                chain: String::new(),
            });
            (written.readings, written.chain) = (self.next_index, chain);
        }
        let text = self.header.to_text()?;
        Ok(disk::replace(&self.path.join("run.toml"), text.as_bytes())?)
    }
}

fn same_bench(path: &Utf8Path, run: &RunHeader, now: &RunHeader) -> Result<(), RunError> {
    let changed = |what: String| RunError::Changed {
        path: path.to_owned(),
        what,
    };
    if run.plan != now.plan {
        return Err(changed("the plan".to_owned()));
    }
    if run.station != now.station {
        return Err(changed("the station".to_owned()));
    }
    if run.spectral != now.spectral {
        return Err(changed("the spectral calibration".to_owned()));
    }
    if run.luxmeter != now.luxmeter {
        return Err(changed("the spectral responsivity of the lux meter".to_owned()));
    }
    for (before, after) in run.device.iter().zip(&now.device) {
        if before.role != after.role || before.model != after.model || before.serial != after.serial {
            let name = |device: &DeviceRecord| {
                format!(
                    "{} {}",
                    device.model,
                    device.serial.as_deref().unwrap_or("without serial number")
                )
            };
            return Err(changed(format!(
                "{} ({}, the run had {})",
                after.role,
                name(after),
                name(before)
            )));
        }
    }
    if run.device.len() != now.device.len() {
        return Err(changed("the set of instruments".to_owned()));
    }
    Ok(())
}

/// Copies of `files` in a fresh folder of the run; its name, where there are any.
fn set_aside(run: &Utf8Path, files: &[String]) -> Result<Option<String>, RunError> {
    if files.is_empty() {
        return Ok(None);
    }
    let name = (1..u32::MAX)
        .map(|number| format!("damaged-{number}"))
        .find(|name| !run.join(name).exists())
        .unwrap_or_default();
    for file in files {
        let from = run.join(file);
        let bytes = std::fs::read(&from).map_err(failed(&from, "read"))?;
        let to = run.join(&name).join(file);
        disk::create_folder(to.parent().unwrap_or(run))?;
        disk::replace(&to, &bytes)?;
    }
    Ok(Some(name))
}

/// The whole lines of a file, which is cut to them; nothing where there is none.
fn whole_lines(path: &Utf8Path) -> Result<Vec<u8>, RunError> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut bytes = std::fs::read(path).map_err(failed(path, "read"))?;
    let whole = bytes
        .iter()
        .rposition(|&byte| byte == b'\n')
        .map_or(0, |place| place + 1);
    if whole < bytes.len() {
        let file = OpenOptions::new()
            .write(true)
            .open(path)
            .map_err(failed(path, "open"))?;
        file.set_len(whole as u64)
            .map_err(failed(path, "cut off the torn tail"))?;
        bytes.truncate(whole);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests;
