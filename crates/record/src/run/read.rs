//! Reads a run and compares it with what was recorded of it: nothing that was lost, changed or exchanged becomes a
//! number.

use std::io::ErrorKind;

use camino::{Utf8Path, Utf8PathBuf};

use super::axis;
use super::error::RunError;
use super::header::{RunHeader, SpectrumEntry};
use crate::disk::{failed, lines, sha256};
use crate::event::{EVENTS_FILE, StopHow};
use crate::file::{self, FileError, LARGEST_TABLE};
use crate::readings;
use crate::spectra::SpectrumRecord;
use crate::sweeps::{SweepEntry, SweepRecord};
use crate::table::ObservationError;

/// A run as far as it is whole, and what is not.
#[derive(Debug)]
pub(super) struct Survey {
    /// What is whole: rows before the first damaged one, spectra that are as they were recorded.
    pub run: Run,
    /// The bytes of readings.csv.
    pub readings: Vec<u8>,
    /// What is damaged, one sentence each with the file.
    pub damage: Vec<String>,
    /// Files that are there and damaged, by their names in the run.
    pub damaged_files: Vec<String>,
    /// Rows that were recorded, where that is known.
    recorded: Option<u64>,
}

impl Survey {
    /// # Errors
    /// [`RunError::NoRun`], a run.toml that cannot be used, what the system says.
    pub fn of(path: &Utf8Path) -> Result<Self, RunError> {
        let header = RunHeader::read(path)?;
        let mut survey = Self {
            readings: Vec::new(),
            damage: Vec::new(),
            damaged_files: Vec::new(),
            recorded: header.stopped.as_ref().map(|stopped| stopped.readings),
            run: Run {
                path: path.to_owned(),
                header,
                readings: readings::Readings::default(),
                spectra: Vec::new(),
                sweeps: Vec::new(),
                notices: Vec::new(),
            },
        };
        survey.readings()?;
        survey.spectra()?;
        survey.sweeps()?;
        survey.notices();
        Ok(survey)
    }

    /// The run, if nothing of it is damaged.
    ///
    /// # Errors
    /// [`RunError::Damaged`].
    pub fn whole(self) -> Result<Self, RunError> {
        if self.damage.is_empty() {
            return Ok(self);
        }
        let of = self.recorded.map_or_else(String::new, |count| format!(" of {count}"));
        let rows = self.run.readings.rows.len();
        Err(RunError::Damaged {
            sound: format!(
                "verified by their checksums: the first {rows}{of} readings and {} spectra",
                self.run.spectra.len()
            ),
            path: self.run.path,
            damage: self.damage,
        })
    }

    fn damaged(&mut self, file: &str, what: &str) {
        let path = self.run.path.join(file);
        if path.exists() {
            self.damaged_files.push(file.to_owned());
        }
        self.damage.push(format!("{path}: {what}"));
    }

    fn readings(&mut self) -> Result<(), RunError> {
        let name = "readings.csv";
        let file = self.run.path.join(name);
        let Some(bytes) = bytes(&file)? else {
            self.damaged(name, "is missing");
            return Ok(());
        };
        let (mut readings, error) = readings::parse_whole(&file, &bytes);
        let header = self.run.header.clone();
        let mut damage = Vec::new();
        if let Some(error) = &error {
            damage.push(error.to_string());
        } else if readings.layout != header.layout() {
            damage.push(format!("{file}: has the columns of another format than run.toml"));
            readings.truncate(0);
        }
        // The first row is in run.toml before the second is read.
        let unknown = header.written.is_none() && readings.rows.len() > 1;
        let of_another_run = unknown
            || header.written.as_ref().is_some_and(|written| {
                let last = (written.readings as usize).checked_sub(1);
                let last = last.and_then(|last| readings.chains.get(last));
                let first = readings.chains.first();
                first.is_some_and(|first| *first != written.first_chain)
                    || last.is_some_and(|last| *last != written.chain)
            });
        if of_another_run {
            damage.push(format!("{file}: its rows are of another run than run.toml"));
            readings.truncate(0);
        }
        let found = readings.rows.len();
        let at_least = header.written.as_ref().map_or(0, |written| written.readings);
        if damage.is_empty() {
            match &header.stopped {
                Some(stopped) => {
                    let recorded = stopped.readings as usize;
                    if found < recorded {
                        damage.push(format!("{file}: holds {found} readings, {recorded} were recorded"));
                    } else if found > recorded && stopped.how == StopHow::Failed {
                        self.run.notices.push(format!(
                            "{file}: rows from {recorded} on were never confirmed by the disk and are ignored"
                        ));
                        readings.truncate(recorded);
                    } else if found > recorded {
                        damage.push(format!("{file}: holds {found} readings, {recorded} were recorded"));
                        readings.truncate(recorded);
                    }
                    let rows = bytes.get(..readings.whole_bytes).unwrap_or_default();
                    if damage.is_empty()
                        && stopped
                            .readings_sha256
                            .as_ref()
                            .is_some_and(|hash| *hash != sha256(rows))
                    {
                        damage.push(format!("{file}: its rows are not those that were recorded"));
                        readings.truncate(0);
                    }
                }
                None if (found as u64) < at_least => {
                    damage.push(format!(
                        "{file}: holds {found} readings, at least {at_least} were recorded"
                    ));
                }
                None => {}
            }
        }
        if !damage.is_empty() {
            self.damaged_files.push(name.to_owned());
            self.damage.append(&mut damage);
        }
        axis::place(&header, &mut readings);
        self.run.readings = readings;
        self.readings = bytes;
        Ok(())
    }

    fn spectra(&mut self) -> Result<(), RunError> {
        let found = numbered_files(&self.run.path, "spectra")?;
        let entries = self.run.header.spectrum.clone();
        for entry in &entries {
            let name = entry.file();
            match self.spectrum(entry)? {
                Ok(spectrum) => self.run.spectra.push(spectrum),
                Err(what) => self.damaged(&name, &what),
            }
        }
        let mut unknown = found;
        unknown.retain(|name| !entries.iter().any(|entry| entry.file() == *name));
        // A program that is killed leaves one spectrum that run.toml does not list, not more.
        let stale = self.run.header.stopped.is_none() && unknown.len() > 1;
        for name in unknown {
            if stale {
                self.damaged(
                    &name,
                    "is not listed in run.toml, which is of another run or of an earlier time",
                );
            } else {
                let file = self.run.path.join(name);
                self.run
                    .notices
                    .push(format!("{file}: is not in the record and is ignored"));
            }
        }
        Ok(())
    }

    /// One spectrum, or what is wrong with its file.
    fn spectrum(&self, entry: &SpectrumEntry) -> Result<Result<SpectrumRecord, String>, RunError> {
        let file = self.run.path.join(entry.file());
        let Some(bytes) = bytes(&file)? else {
            return Ok(Err("is missing".to_owned()));
        };
        let parsed = SpectrumRecord::parse(&file, &String::from_utf8_lossy(&bytes));
        if sha256(&bytes) != entry.sha256 {
            let lines = lines(&bytes).saturating_sub(1);
            return Ok(Err(format!(
                "is not the file that was recorded: its SHA-256 is another ({} pixels recorded, {lines} lines found){}",
                entry.pixels,
                place(parsed.err())
            )));
        }
        Ok(parsed.map_err(|error| error.to_string()))
    }

    fn sweeps(&mut self) -> Result<(), RunError> {
        let found = numbered_files(&self.run.path, "sweeps")?;
        let entries = self.run.header.sweep.clone();
        for entry in &entries {
            match self.sweep(entry)? {
                Ok(sweep) if entry.torn => {
                    let why = sweep.of.torn.unwrap_or_default();
                    let file = self.run.path.join(entry.file());
                    self.run
                        .notices
                        .push(format!("{file}: a torn sweep, kept as evidence: {why}"));
                }
                Ok(sweep) => self.run.sweeps.push(sweep),
                Err(what) => self.damaged(&entry.file(), &what),
            }
        }
        let unknown = found
            .into_iter()
            .filter(|name| !entries.iter().any(|entry| entry.file() == *name));
        for name in unknown {
            let file = self.run.path.join(name);
            self.run
                .notices
                .push(format!("{file}: is not in the record and is ignored"));
        }
        Ok(())
    }

    /// One sweep, or what is wrong with its file.
    fn sweep(&self, entry: &SweepEntry) -> Result<Result<SweepRecord, String>, RunError> {
        let file = self.run.path.join(entry.file());
        let Some(bytes) = bytes(&file)? else {
            return Ok(Err("is missing".to_owned()));
        };
        let parsed = SweepRecord::parse(&file, &String::from_utf8_lossy(&bytes));
        if sha256(&bytes) != entry.sha256 {
            let place = place(parsed.err());
            return Ok(Err(format!(
                "is not the file that was recorded: its SHA-256 is another{place}"
            )));
        }
        Ok(parsed.map_err(|error| error.to_string()))
    }

    fn notices(&mut self) {
        let path = self.run.path.clone();
        let header = &self.run.header;
        let mut notices = Vec::new();
        if let Some(torn) = &self.run.readings.torn_tail {
            notices.push(format!(
                "{path}/readings.csv:{}: the last row was cut short by a crash and is ignored",
                torn.line
            ));
        }
        for session in header.resumed.iter().filter(|session| !session.damage.is_empty()) {
            let aside = session.set_aside.as_deref().unwrap_or("no file");
            notices.push(format!(
                "resumed {} on a damaged record, and what was missing after row {} was read again; {aside} holds the damaged files: {}",
                session.utc,
                session.first_row,
                session.damage.join("; ")
            ));
        }
        match &header.stopped {
            None => notices.push("the run was never stopped: its program was killed".to_owned()),
            Some(stopped) => {
                if stopped.how != StopHow::Completed {
                    notices.push(format!("the run was {}: {}", stopped.how, stopped.message));
                }
                if let Some((count, hash)) = stopped.events.zip(stopped.events_sha256.as_ref()) {
                    let events = std::fs::read(path.join(EVENTS_FILE)).unwrap_or_default();
                    if sha256(&events) != *hash {
                        let lines = lines(&events);
                        notices.push(format!(
                            "{path}/events.jsonl is not as it was recorded ({count} events recorded, {lines} lines found); no number \
                             is computed from it"
                        ));
                    }
                }
            }
        }
        notices.append(&mut self.run.notices);
        self.run.notices = notices;
    }
}

/// Where a changed file has its first fault, if a checksum of its rows tells.
fn place(fault: Option<ObservationError>) -> String {
    fault.map_or_else(String::new, |fault| format!("; {fault}"))
}

/// The file's bytes; none when it is not there.
fn bytes(path: &Utf8Path) -> Result<Option<Vec<u8>>, RunError> {
    match file::read(path, LARGEST_TABLE) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(FileError::Io(error)) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(FileError::Io(error)) => Err(failed(path, "read")(error).into()),
        Err(other) => Err(failed(path, "read")(std::io::Error::other(other)).into()),
    }
}

/// Names of the numbered files in a folder of the run, by number.
fn numbered_files(run: &Utf8Path, name: &str) -> Result<Vec<String>, RunError> {
    let folder = run.join(name);
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in folder.read_dir_utf8().map_err(failed(&folder, "list"))? {
        let path: Utf8PathBuf = entry.map_err(failed(&folder, "list"))?.into_path();
        // A calibration or a half-written part may stand beside them.
        let numbered = path
            .file_stem()
            .is_some_and(|stem| !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_digit()));
        if numbered && path.extension() == Some("csv") {
            names.extend(path.file_name().map(|file| format!("{name}/{file}")));
        }
    }
    names.sort();
    Ok(names)
}

/// A run as it stands on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The folder.
    pub path: Utf8PathBuf,
    /// run.toml.
    pub header: RunHeader,
    /// readings.csv: rows, and the torn tail if a crash left one.
    pub readings: readings::Readings,
    /// spectra/, by index.
    pub spectra: Vec<SpectrumRecord>,
    /// sweeps/, by index, the whole ones.
    pub sweeps: Vec<SweepRecord>,
    /// What a person should know of the record, one sentence each: everything that reads a run passes them on.
    pub notices: Vec<String>,
}

impl Run {
    /// Reads a run directory, whole or broken off, and compares it with what was recorded of it.
    ///
    /// # Errors
    /// [`RunError`] with file and line; [`RunError::Damaged`] for files that are not what was recorded.
    pub fn read(path: &Utf8Path) -> Result<Self, RunError> {
        Ok(Survey::of(path)?.whole()?.run)
    }

    /// Seconds since the run began at which a session begins whose UTC is `utc`. What is recorded already was before
    /// it, whatever became of the clock of the computer.
    pub(super) fn next_session_s(&self, utc: &str) -> f64 {
        let rows = self.readings.rows.iter().filter_map(|row| row.time_s);
        let spectra = self.spectra.iter().filter_map(|spectrum| spectrum.time_s);
        let sweeps = self.sweeps.iter().flat_map(|sweep| &sweep.light);
        let sweeps = sweeps.map(|sample| sample.answered_s);
        let sessions = self.header.resumed.iter().filter_map(|session| session.start_s);
        rows.chain(spectra)
            .chain(sweeps)
            .chain(sessions)
            .fold(self.header.seconds(utc).unwrap_or(0.0).max(0.0), f64::max)
    }
}
