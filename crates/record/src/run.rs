//! The run directory: what a bench did, readable after any death of the program that wrote it.

mod header;
mod read;

use std::fs::OpenOptions;

use camino::{Utf8Path, Utf8PathBuf};

pub use header::{
    DeviceRecord, FORMAT, FORMAT_1, FORMAT_2, Resumed, RunHeader, SpectrumEntry, StopHow, Stopped, Written,
};

use crate::disk::{self, Appended, DiskError, failed, sha256};
use crate::document::DocumentError;
use crate::reading::Reading;
use crate::readings::{Chain, Layout, Readings, ReadingsError};
use crate::run_lock::{LOCK_FILE, RunLock};
use crate::spectra::{SpectralCalibration, SpectrumError, SpectrumRecord};
use read::Survey;

/// run.toml says how far readings.csv is written after the first row and after every so many.
const ROWS_PER_HEADER: u64 = 50;

/// A run directory that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The target exists.
    #[error("{path} is not empty; choose another folder for the run")]
    Occupied {
        /// The folder.
        path: Utf8PathBuf,
    },
    /// There is no run there.
    #[error("{path} is no run directory: {}", no_run(*unfinished, path))]
    NoRun {
        /// The folder.
        path: Utf8PathBuf,
        /// Whether a program was killed there before its run began.
        unfinished: bool,
    },
    /// The system refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// run.toml is not what this program wrote.
    #[error("{file} was changed or damaged after it was written: {what}; restore it from a copy")]
    HeaderChanged {
        /// The file.
        file: Utf8PathBuf,
        /// How that is known.
        what: String,
    },
    /// Files of the run are not what was recorded.
    #[error("{}; {sound}", damage.join("; "))]
    Damaged {
        /// The folder.
        path: Utf8PathBuf,
        /// What is wrong, each with its file.
        damage: Vec<String>,
        /// What is still as it was recorded.
        sound: String,
    },
    /// run.toml cannot be used.
    #[error(transparent)]
    Header(#[from] DocumentError),
    /// The header could not be written as TOML.
    #[error("run.toml: {0}")]
    Serialise(#[from] toml::ser::Error),
    /// readings.csv cannot be trusted.
    #[error(transparent)]
    Readings(#[from] ReadingsError),
    /// A spectrum cannot be used.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// Another process has taken the folder over from this one.
    #[error("{path} was taken over by another process; this one writes nothing more to it")]
    TakenOver {
        /// The folder.
        path: Utf8PathBuf,
    },
    /// The run is not the one that is to be taken up again.
    #[error("cannot resume {path}: {what} is not that of the run")]
    Changed {
        /// The folder.
        path: Utf8PathBuf,
        /// What differs, with both values where they are short.
        what: String,
    },
}

/// A run as it stands on disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The folder.
    pub path: Utf8PathBuf,
    /// run.toml.
    pub header: RunHeader,
    /// readings.csv: rows, and the torn tail if a crash left one.
    pub readings: Readings,
    /// spectra/, by index.
    pub spectra: Vec<SpectrumRecord>,
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
}

/// Writes a run. Whatever is returned from is on the disk.
#[derive(Debug)]
pub struct RunDir {
    path: Utf8PathBuf,
    header: RunHeader,
    readings: Appended,
    chain: Chain,
    next_index: u64,
    next_spectrum: u64,
    events: Appended,
    event_count: u64,
    lock: Option<RunLock>,
}

impl RunDir {
    /// Writes only as long as `lock` is held: nothing once another process has taken it over.
    pub fn guard(&mut self, lock: RunLock) {
        self.lock = Some(lock);
    }

    fn still_ours(&self) -> Result<(), RunError> {
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
        let events_path = path.join("events.jsonl");
        disk::replace(&events_path, b"")?;
        let mut run = Self {
            path: path.to_owned(),
            chain: Chain::new(header.layout()),
            header,
            readings: Appended::open(&readings_path, columns.as_bytes())?,
            next_index: 0,
            next_spectrum: 0,
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

    /// Resumes a run with a damaged record: what is whole stays, damaged files are set aside in a folder of the run, run.toml
    /// says so, and what is missing can be read again.
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
        let set_aside = set_aside(&path, &survey.damaged_files)?;
        let mut header = run.header.clone();
        let layout = header.layout();
        let indices = run.spectra.iter().map(|spectrum| spectrum.index);
        let next_spectrum = indices
            .chain(header.spectrum.iter().map(|entry| entry.index))
            .max()
            .map_or(0, |last| last + 1);
        header.stopped = None;
        if layout.has_hashes() {
            header
                .spectrum
                .retain(|entry| run.spectra.iter().any(|spectrum| spectrum.index == entry.index));
            header.resumed.push(Resumed {
                utc: now.started_utc.clone(),
                program: now.program.clone(),
                first_row: run.readings.rows.len() as u64,
                damage: survey.damage.clone(),
                set_aside,
            });
            header.written = None;
        }
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
        let events_path = path.join("events.jsonl");
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
            events: Appended::open(&events_path, &events)?,
            event_count: disk::lines(&events),
            lock: None,
            header,
            path,
        };
        if let (true, Some(first)) = (layout.has_hashes(), run.readings.chains.first()) {
            dir.header.written = Some(Written {
                readings: dir.next_index,
                first_chain: first.clone(),
                chain: dir.chain.last().to_owned(),
            });
        }
        dir.write_header()?;
        if !survey.damage.is_empty() {
            let fields = serde_json::json!({ "damage": survey.damage, "first_row": dir.next_index });
            dir.event(&now.started_utc, "reread", &fields)?;
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

    /// Whether no reading was recorded yet.
    pub fn is_empty(&self) -> bool {
        self.next_index == 0
    }

    /// Appends one reading and syncs; its `index`, `session` and `burning` are set here. When this returns, the row outlives a
    /// loss of power. After an error no further row is taken: the run has to be resumed.
    ///
    /// # Errors
    /// What the system says.
    pub fn append(&mut self, mut reading: Reading) -> Result<u64, RunError> {
        self.still_ours()?;
        reading.index = self.next_index;
        reading.session = self.header.resumed.len() as u32;
        reading.burning = (self.header.layout().has_hashes()).then_some(self.header.burnings);
        let (row, chain) = self.chain.row(&reading);
        self.readings.write_synced(row.as_bytes())?;
        self.chain = chain;
        self.next_index += 1;
        if self.header.layout().has_hashes()
            && (self.next_index == 1 || self.next_index.is_multiple_of(ROWS_PER_HEADER))
        {
            self.write_header()?;
        }
        Ok(reading.index)
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
        if self.header.layout().has_hashes() {
            self.header.spectrum.push(entry);
            self.write_header()?;
        }
        Ok(spectrum.index)
    }

    /// Appends one event; `fields` is an object whose members follow `time_utc` and `event`.
    ///
    /// # Errors
    /// What the system says.
    pub fn event(&mut self, time_utc: &str, event: &str, fields: &serde_json::Value) -> Result<(), RunError> {
        self.still_ours()?;
        let mut line = serde_json::Map::new();
        line.insert("time_utc".to_owned(), time_utc.into());
        line.insert("event".to_owned(), event.into());
        if let Some(fields) = fields.as_object() {
            line.extend(fields.clone());
        }
        let text = format!("{}\n", serde_json::Value::Object(line));
        self.events.write(text.as_bytes())?;
        self.event_count += 1;
        Ok(())
    }

    /// Records when the lamp was switched on.
    ///
    /// # Errors
    /// What the system says.
    pub fn lamp_on(&mut self, utc: String) -> Result<(), RunError> {
        self.header.lamp_on_utc = Some(utc);
        if self.header.layout().has_hashes() {
            self.header.burnings += 1;
        }
        self.write_header()
    }

    /// Records how the run ended, with number and hash of its rows and events. run.toml is replaced in one step: it says so,
    /// or it does not.
    ///
    /// # Errors
    /// What the system says.
    pub fn stop(&mut self, mut stopped: Stopped) -> Result<(), RunError> {
        stopped.readings = self.next_index;
        if self.header.layout().has_hashes() {
            stopped.readings_sha256 = Some(self.readings.sha256());
            stopped.events = Some(self.event_count);
            stopped.events_sha256 = Some(self.events.sha256());
        }
        // The record of the end does not wait for the events, from which no number is computed.
        let synced = self.events.sync();
        self.header.stopped = Some(stopped);
        self.write_header()?;
        Ok(synced?)
    }

    fn write_header(&mut self) -> Result<(), RunError> {
        self.still_ours()?;
        if self.header.layout().has_hashes() && self.next_index > 0 {
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

/// Whether a run can begin in `path`: it is not there, is empty, or holds nothing but what [`RunDir::create`] writes before
/// run.toml, left by a program that was killed.
pub fn vacant(path: &Utf8Path) -> bool {
    if !path.exists() {
        return true;
    }
    let Ok(entries) = path.read_dir_utf8() else {
        return false;
    };
    entries.into_iter().all(|entry| {
        let Ok(entry) = entry else { return false };
        let file = entry.path();
        let name = entry.file_name();
        let only = |bytes: &[&[u8]]| std::fs::read(file).is_ok_and(|found| bytes.contains(&found.as_slice()));
        match name {
            "spectra" => file.read_dir_utf8().is_ok_and(|mut entries| entries.next().is_none()),
            "readings.csv" => {
                let headers = Layout::ALL.map(Layout::header);
                only(&[b"".as_slice()]) || headers.iter().any(|header| only(&[header.as_bytes()]))
            }
            "events.jsonl" => only(&[b""]),
            LOCK_FILE => true,
            _ => name.starts_with('.') && file.extension() == Some("part"),
        }
    })
}

fn no_run(unfinished: bool, path: &Utf8Path) -> String {
    if unfinished {
        format!("its program ended before anything was recorded; begin the run anew with --out {path}")
    } else {
        "it has no run.toml".to_owned()
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
mod tests {
    use super::*;
    use crate::plan::Plan;
    use crate::readings::tests::reading;
    use crate::spectra::tests::{calibration, spectrum};
    use crate::station::Station;

    fn header() -> RunHeader {
        let device = DeviceRecord {
            role: "luxmeter".to_owned(),
            open: "t10a:x".to_owned(),
            model: "T-10A".to_owned(),
            serial: Some("1".to_owned()),
            firmware: None,
        };
        RunHeader::new(
            "isolux test".to_owned(),
            "2026-01-01T00:00:00Z".to_owned(),
            vec![device],
            Some(calibration()),
            Station::parse(Utf8Path::new("s.toml"), crate::station::tests::STATION).unwrap(),
            Plan::parse(Utf8Path::new("p.toml"), crate::plan::tests::PLAN).unwrap(),
        )
    }

    fn stopped() -> Stopped {
        Stopped::new(
            "2026-01-01T01:00:00Z".to_owned(),
            StopHow::Completed,
            "every point of the plan was read".to_owned(),
            true,
        )
    }

    /// A completed run of five readings and two spectra.
    fn completed(path: &Utf8Path) {
        let mut dir = RunDir::create(path, header()).unwrap();
        for second in 0..5_u32 {
            let mut reading = reading(0);
            reading.time_s = Some(2000.0 + f64::from(second));
            dir.append(reading).unwrap();
        }
        for _ in 0..2 {
            dir.spectrum(spectrum(), &calibration()).unwrap();
        }
        dir.event("2026-01-01T00:00:01Z", "homed", &serde_json::json!({"axis": "c"}))
            .unwrap();
        dir.stop(stopped()).unwrap();
    }

    fn rows(path: &Utf8Path) -> Vec<String> {
        let text = std::fs::read_to_string(path.join("readings.csv")).unwrap();
        text.split_inclusive('\n').map(str::to_owned).collect()
    }

    fn damage(path: &Utf8Path) -> String {
        match Run::read(path) {
            Err(error @ (RunError::Damaged { .. } | RunError::HeaderChanged { .. })) => error.to_string(),
            other => panic!("{other:?}"),
        }
    }

    fn scratch() -> (tempfile::TempDir, Utf8PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().join("run")).unwrap();
        (folder, path)
    }

    #[test]
    fn what_was_written_is_read() {
        let (_keep, path) = scratch();
        let mut dir = RunDir::create(&path, header()).unwrap();
        for _ in 0..3 {
            dir.append(reading(99)).unwrap();
        }
        dir.spectrum(spectrum(), &calibration()).unwrap();
        dir.event("2026-01-01T00:00:01Z", "homed", &serde_json::json!({"axis": "c"}))
            .unwrap();
        dir.lamp_on("2026-01-01T00:00:02Z".to_owned()).unwrap();
        dir.stop(stopped()).unwrap();
        let run = Run::read(&path).unwrap();
        assert_eq!(
            run.readings.rows.iter().map(|row| row.index).collect::<Vec<_>>(),
            [0, 1, 2]
        );
        assert_eq!(run.spectra, [spectrum()]);
        assert_eq!(run.notices, [""; 0]);
        let stopped = run.header.stopped.unwrap();
        assert_eq!((stopped.readings, stopped.events), (3, Some(1)));
        let bytes = std::fs::read(path.join("readings.csv")).unwrap();
        assert_eq!(stopped.readings_sha256, Some(sha256(&bytes)), "as sha256sum says it");
        assert_eq!(run.header.station, header().station);
        assert!(matches!(
            RunDir::create(&path, header()),
            Err(RunError::Occupied { .. })
        ));
        assert!(matches!(Run::read(&path.join("spectra")), Err(RunError::NoRun { .. })));
    }

    #[test]
    fn resume_cuts_the_torn_tail_and_refuses_another_bench() {
        let (_keep, path) = scratch();
        let mut dir = RunDir::create(&path, header()).unwrap();
        dir.append(reading(0)).unwrap();
        dir.append(reading(1)).unwrap();
        drop(dir);
        let file = path.join("readings.csv");
        let bytes = std::fs::read(&file).unwrap();
        std::fs::write(&file, &bytes[..bytes.len() - 9]).unwrap();
        let (mut dir, run) = RunDir::resume(&path, &header()).unwrap();
        assert_eq!((run.readings.rows.len(), dir.len()), (1, 1));
        dir.append(reading(0)).unwrap();
        drop(dir);
        let run = Run::read(&path).unwrap();
        assert_eq!(
            run.readings
                .rows
                .iter()
                .map(|row| (row.index, row.session))
                .collect::<Vec<_>>(),
            [(0, 0), (1, 1)]
        );
        let mut other = header();
        other.device[0].serial = Some("2".to_owned());
        let error = RunDir::resume(&path, &other).unwrap_err().to_string();
        assert!(error.contains("luxmeter (T-10A 2, the run had T-10A 1)"), "{error}");
        let mut other = header();
        let text = crate::plan::tests::PLAN.replace("repeats = 20", "repeats = 21");
        other.plan = Plan::parse(Utf8Path::new("p.toml"), &text).unwrap();
        assert!(matches!(RunDir::resume(&path, &other), Err(RunError::Changed { .. })));
    }

    #[test]
    fn rows_that_are_lost_from_a_completed_run_are_missed() {
        for (lost, words) in [
            (4..6, "holds 3 readings, 5 were recorded"),
            (2..3, "a row is missing"),
            (1..6, "holds 0 readings, 5 were recorded"),
        ] {
            let (_keep, path) = scratch();
            completed(&path);
            let mut left = rows(&path);
            left.drain(lost);
            std::fs::write(path.join("readings.csv"), left.concat()).unwrap();
            let said = damage(&path);
            assert!(said.contains(words) && said.contains("readings.csv"), "{said}");
            assert!(matches!(
                RunDir::resume(&path, &header()),
                Err(RunError::Damaged { .. })
            ));
        }
    }

    /// No checksum of a row and no number of a row tells: the rows are whole and of the same plan.
    #[test]
    fn rows_and_spectra_of_another_run_are_not_this_one() {
        let (_keep, path) = scratch();
        completed(&path);
        let (_keep, other) = scratch();
        let mut dir = RunDir::create(&other, header()).unwrap();
        for second in 0..5_u32 {
            let mut reading = reading(0);
            reading.time_s = Some(2000.5 + f64::from(second));
            dir.append(reading).unwrap();
        }
        std::fs::copy(other.join("readings.csv"), path.join("readings.csv")).unwrap();
        assert!(damage(&path).contains("readings.csv: its rows are of another run"));
        // Nor where the program was killed.
        let theirs = std::fs::read(other.join("readings.csv")).unwrap();
        let (_keep, killed) = scratch();
        let mut dir = RunDir::create(&killed, header()).unwrap();
        dir.append(reading(0)).unwrap();
        std::fs::write(killed.join("readings.csv"), &theirs).unwrap();
        assert!(damage(&killed).contains("of another run"));
        // Nor beside a run.toml in which no row was written yet.
        let (_keep, begun) = scratch();
        drop(RunDir::create(&begun, header()).unwrap());
        std::fs::write(begun.join("readings.csv"), &theirs).unwrap();
        assert!(damage(&begun).contains("of another run"));

        let (_keep, path) = scratch();
        completed(&path);
        std::fs::copy(path.join("spectra/000.csv"), path.join("spectra/001.csv")).unwrap();
        assert!(damage(&path).contains("spectra/001.csv: is not the file that was recorded"));
        std::fs::remove_file(path.join("spectra/001.csv")).unwrap();
        assert!(damage(&path).contains("spectra/001.csv: is missing"));
    }

    #[test]
    fn any_change_of_run_toml_is_refused() {
        let (_keep, path) = scratch();
        completed(&path);
        let file = path.join("run.toml");
        let text = std::fs::read_to_string(&file).unwrap();
        for changed in [
            text.replacen("saturation_counts = 32768.0", "saturation_counts = 32769.0", 1),
            text.replacen("readings = 5", "readings = 4", 1),
            text.replacen("isolux-run/3", "isolux-run/2", 1),
            text.replacen("isolux-run/3", "isolux-run/1", 1),
            text[..text.rfind("[check]").unwrap()].to_owned(),
            text[..text.len() - 3].to_owned(),
        ] {
            assert_ne!(changed, text);
            std::fs::write(&file, &changed).unwrap();
            let said = Run::read(&path).unwrap_err().to_string();
            assert!(said.contains("run.toml"), "{said}");
        }
    }

    #[test]
    fn a_damaged_record_is_read_again_from_its_whole_rows_on_and_nothing_is_thrown_away() {
        let (_keep, path) = scratch();
        completed(&path);
        let file = path.join("readings.csv");
        let whole = rows(&path);
        let mut changed = whole.clone();
        changed[3] = changed[3].replacen("3.37", "3.38", 1);
        std::fs::write(&file, changed.concat()).unwrap();
        std::fs::remove_file(path.join("spectra/000.csv")).unwrap();
        let (mut dir, run) = RunDir::reread(&path, &header()).unwrap();
        assert_eq!((dir.len(), run.readings.rows.len(), run.spectra.len()), (2, 2, 1));
        assert_eq!(
            std::fs::read_to_string(path.join("damaged-1/readings.csv")).unwrap(),
            changed.concat()
        );
        assert_eq!(dir.append(reading(0)).unwrap(), 2);
        assert_eq!(dir.spectrum(spectrum(), &calibration()).unwrap(), 2);
        dir.stop(stopped()).unwrap();
        let run = Run::read(&path).unwrap();
        assert_eq!(rows(&path)[..3], whole[..3]);
        assert_eq!(run.readings.rows[2].session, 1);
        assert_eq!(
            run.spectra.iter().map(|spectrum| spectrum.index).collect::<Vec<_>>(),
            [1, 2]
        );
        let said = run.notices.concat();
        assert!(
            said.contains("damaged-1 holds") && said.contains("row 2 is damaged"),
            "{said}"
        );
        assert!(said.contains("000.csv: is missing"), "{said}");
    }

    #[test]
    fn a_row_that_the_disk_did_not_confirm_is_no_reading() {
        let (_keep, path) = scratch();
        let mut dir = RunDir::create(&path, header()).unwrap();
        dir.append(reading(0)).unwrap();
        dir.readings.fail_to_sync();
        assert!(matches!(dir.append(reading(0)), Err(RunError::Disk(_))));
        assert!(dir.append(reading(0)).is_err());
        let mut failed = stopped();
        failed.how = StopHow::Failed;
        dir.stop(failed).unwrap();
        // A disk that fails may not have cut the row off either.
        let (row, _) = dir.chain.row(&Reading { index: 1, ..reading(1) });
        let file = path.join("readings.csv");
        std::fs::write(&file, rows(&path).concat() + &row).unwrap();
        let run = Run::read(&path).unwrap();
        assert_eq!(run.readings.rows.len(), 1);
        assert!(run.notices.concat().contains("rows from 1 on were never confirmed"));
        let (mut dir, _) = RunDir::resume(&path, &header()).unwrap();
        assert_eq!(dir.append(reading(0)).unwrap(), 1);
        dir.stop(stopped()).unwrap();
        let run = Run::read(&path).unwrap();
        assert_eq!((run.readings.rows.len(), run.readings.rows[1].session), (2, 1));
    }

    #[test]
    fn a_run_of_format_1_is_read_and_resumed_as_what_it_is() {
        let (_keep, path) = scratch();
        let mut old = header();
        FORMAT_1.clone_into(&mut old.format);
        let mut dir = RunDir::create(&path, old).unwrap();
        dir.lamp_on("2026-01-01T00:00:02Z".to_owned()).unwrap();
        dir.append(reading(0)).unwrap();
        dir.spectrum(spectrum(), &calibration()).unwrap();
        drop(dir);
        let text = std::fs::read_to_string(path.join("run.toml")).unwrap();
        assert!(
            !["burnings", "[check]", "[written]", "[[spectrum]]"]
                .iter()
                .any(|new| text.contains(new)),
            "{text}"
        );
        let (mut dir, run) = RunDir::resume(&path, &header()).unwrap();
        assert!(run.notices[0].contains("carries no hashes"), "{:?}", run.notices);
        dir.append(reading(0)).unwrap();
        assert_eq!(dir.spectrum(spectrum(), &calibration()).unwrap(), 1);
        dir.stop(stopped()).unwrap();
        let run = Run::read(&path).unwrap();
        assert_eq!((run.readings.rows.len(), run.spectra.len()), (2, 2));
        // The number of readings is known there too.
        let left = rows(&path);
        std::fs::write(path.join("readings.csv"), left[..2].concat()).unwrap();
        assert!(damage(&path).contains("holds 1 readings, 2 were recorded"));
    }

    #[test]
    fn what_a_kill_before_the_first_run_toml_leaves_is_no_obstacle() {
        let (_keep, path) = scratch();
        drop(RunDir::create(&path, header()).unwrap());
        std::fs::remove_file(path.join("run.toml")).unwrap();
        let said = Run::read(&path).unwrap_err().to_string();
        assert!(said.contains("begin the run anew with --out"), "{said}");
        completed(&path);
        assert_eq!(Run::read(&path).unwrap().readings.rows.len(), 5);
        // A file of somebody else is not ours to write over.
        let (_keep, path) = scratch();
        drop(RunDir::create(&path, header()).unwrap());
        std::fs::remove_file(path.join("run.toml")).unwrap();
        std::fs::write(path.join("readings.csv"), "c_deg,gamma_deg\n").unwrap();
        assert!(matches!(
            RunDir::create(&path, header()),
            Err(RunError::Occupied { .. })
        ));
    }
}
