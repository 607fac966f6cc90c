//! The run directory: what a bench did, readable after any death of the program that wrote it.

use std::fs::{File, OpenOptions};
use std::io::Write;

use camino::{Utf8Path, Utf8PathBuf};
use serde::{Deserialize, Serialize};

use crate::document::{DocumentError, Source, read_text};
use crate::plan::Plan;
use crate::reading::Reading;
use crate::readings::{self, Readings, ReadingsError};
use crate::spectra::{SpectralCalibration, SpectrumError, SpectrumRecord};
use crate::station::Station;

/// Value of `format` in run.toml.
pub const FORMAT: &str = "isolux-run/1";

/// run.toml.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunHeader {
    /// [`FORMAT`].
    pub format: String,
    /// Name and version of the program that wrote the run.
    pub program: String,
    /// UTC of the start, RFC 3339.
    pub started_utc: String,
    /// UTC of t = 0, the last switching on of the lamp; none before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp_on_utc: Option<String>,
    /// How the run ended; none while it lasts, and for ever if its program was killed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped: Option<Stopped>,
    /// Identities of the instruments.
    #[serde(default)]
    pub device: Vec<DeviceRecord>,
    /// Calibration of the spectroradiometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectral: Option<SpectralCalibration>,
    /// The station as it was.
    pub station: Station,
    /// The plan as it was.
    pub plan: Plan,
}

/// What an instrument said of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeviceRecord {
    /// Its part: `axis.c`, `axis.gamma`, `luxmeter`, `spectroradiometer`, `lamp`, …
    pub role: String,
    /// `driver:target`, or `prompt` for a person.
    pub open: String,
    /// Model.
    pub model: String,
    /// Serial number, where it can be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Firmware, where it can be asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<String>,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopped {
    /// UTC, RFC 3339.
    pub utc: String,
    /// In a word.
    pub how: StopHow,
    /// In a sentence.
    pub message: String,
    /// Whether both axes were verified at rest.
    pub axes_at_rest: bool,
    /// Readings recorded.
    pub readings: u64,
}

/// How a run ended, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopHow {
    /// Every point of the plan was read.
    Completed,
    /// A person or a signal asked for it.
    Interrupted,
    /// An instrument or the system failed.
    Failed,
}

impl std::fmt::Display for StopHow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Completed => "completed",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        })
    }
}

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
    #[error("{path} is no run directory: it has no run.toml")]
    NoRun {
        /// The folder.
        path: Utf8PathBuf,
    },
    /// The system refused.
    #[error("{path}: cannot {action}: {source}")]
    Io {
        /// The file.
        path: Utf8PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system said.
        source: std::io::Error,
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
}

impl Run {
    /// Reads a run directory, whole or broken off.
    ///
    /// # Errors
    /// [`RunError`] with file and line.
    pub fn read(path: &Utf8Path) -> Result<Self, RunError> {
        let file = path.join("run.toml");
        if !file.is_file() {
            return Err(RunError::NoRun { path: path.to_owned() });
        }
        let text = read_text(&file)?;
        let header = Source {
            file: &file,
            text: &text,
        }
        .parse(FORMAT)?;
        let readings = readings::read(&path.join("readings.csv"))?;
        let mut spectra = Vec::new();
        for name in spectrum_files(path)? {
            spectra.push(SpectrumRecord::read(&name)?);
        }
        Ok(Self {
            path: path.to_owned(),
            header,
            readings,
            spectra,
        })
    }
}

/// Writes a run. Whatever is returned from is on the disk.
#[derive(Debug)]
pub struct RunDir {
    path: Utf8PathBuf,
    header: RunHeader,
    readings: File,
    next_index: u64,
    next_spectrum: u64,
    events: File,
}

impl RunDir {
    /// Begins a run in `path`, which must not exist or be empty.
    ///
    /// # Errors
    /// [`RunError::Occupied`], or what the system says.
    pub fn create(path: &Utf8Path, header: RunHeader) -> Result<Self, RunError> {
        if path.exists()
            && !(path.is_dir() && std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none()))
        {
            return Err(RunError::Occupied { path: path.to_owned() });
        }
        let spectra = path.join("spectra");
        std::fs::create_dir_all(&spectra).map_err(io(&spectra, "make the folder"))?;
        let readings_path = path.join("readings.csv");
        let mut readings = append_to(&readings_path)?;
        write_synced(
            &mut readings,
            &readings_path,
            format!("{}\n", readings::HEADER).as_bytes(),
        )?;
        let events = append_to(&path.join("events.jsonl"))?;
        // run.toml last: a folder with it is a run.
        let run = Self {
            path: path.to_owned(),
            header,
            readings,
            next_index: 0,
            next_spectrum: 0,
            events,
        };
        run.write_header()?;
        Ok(run)
    }

    /// Takes a broken-off run up again: the torn tail is cut off, the next rows follow the whole ones. Plan, station and
    /// the serial numbers of the instruments must be those of the run.
    ///
    /// # Errors
    /// [`RunError::Changed`] names what differs.
    pub fn resume(path: &Utf8Path, now: &RunHeader) -> Result<(Self, Run), RunError> {
        let run = Run::read(path)?;
        let changed = |what: String| RunError::Changed {
            path: path.to_owned(),
            what,
        };
        if run.header.plan != now.plan {
            return Err(changed("the plan".to_owned()));
        }
        if run.header.station != now.station {
            return Err(changed("the station".to_owned()));
        }
        if run.header.spectral != now.spectral {
            return Err(changed("the spectral calibration".to_owned()));
        }
        for (before, after) in run.header.device.iter().zip(&now.device) {
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
        if run.header.device.len() != now.device.len() {
            return Err(changed("the set of instruments".to_owned()));
        }
        let readings_path = path.join("readings.csv");
        let readings = append_to(&readings_path)?;
        if run.readings.torn_tail.is_some() {
            readings
                .set_len(run.readings.whole_bytes as u64)
                .map_err(io(&readings_path, "cut off the torn tail"))?;
            readings.sync_all().map_err(io(&readings_path, "sync"))?;
        }
        let events_path = path.join("events.jsonl");
        cut_to_whole_lines(&events_path)?;
        let mut dir = Self {
            path: path.to_owned(),
            header: run.header.clone(),
            readings,
            next_index: run.readings.rows.len() as u64,
            next_spectrum: run.spectra.iter().map(|spectrum| spectrum.index + 1).max().unwrap_or(0),
            events: append_to(&events_path)?,
        };
        dir.header.stopped = None;
        dir.write_header()?;
        Ok((dir, run))
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

    /// Appends one reading and syncs; its `index` is set here. When this returns, the row survives a loss of power.
    ///
    /// # Errors
    /// What the system says.
    pub fn append(&mut self, mut reading: Reading) -> Result<u64, RunError> {
        reading.index = self.next_index;
        let path = self.path.join("readings.csv");
        write_synced(&mut self.readings, &path, readings::row(&reading).as_bytes())?;
        self.next_index += 1;
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
        spectrum.index = self.next_spectrum;
        let name = self.path.join("spectra").join(format!("{:03}.csv", spectrum.index));
        write_whole(&name, spectrum.to_csv(calibration)?.as_bytes())?;
        self.next_spectrum += 1;
        Ok(spectrum.index)
    }

    /// Appends one event; `fields` is an object whose members follow `time_utc` and `event`.
    ///
    /// # Errors
    /// What the system says.
    pub fn event(&mut self, time_utc: &str, event: &str, fields: &serde_json::Value) -> Result<(), RunError> {
        let mut line = serde_json::Map::new();
        line.insert("time_utc".to_owned(), time_utc.into());
        line.insert("event".to_owned(), event.into());
        if let Some(fields) = fields.as_object() {
            line.extend(fields.clone());
        }
        let text = format!("{}\n", serde_json::Value::Object(line));
        let path = self.path.join("events.jsonl");
        self.events.write_all(text.as_bytes()).map_err(io(&path, "write"))
    }

    /// Records when the lamp was switched on.
    ///
    /// # Errors
    /// What the system says.
    pub fn lamp_on(&mut self, utc: String) -> Result<(), RunError> {
        self.header.lamp_on_utc = Some(utc);
        self.write_header()
    }

    /// Records how the run ended. run.toml is replaced in one step: it says so, or it does not.
    ///
    /// # Errors
    /// What the system says.
    pub fn stop(&mut self, stopped: Stopped) -> Result<(), RunError> {
        let path = self.path.join("events.jsonl");
        self.events.sync_all().map_err(io(&path, "sync"))?;
        self.header.stopped = Some(stopped);
        self.write_header()
    }

    fn write_header(&self) -> Result<(), RunError> {
        write_whole(&self.path.join("run.toml"), toml::to_string(&self.header)?.as_bytes())
    }
}

fn spectrum_files(run: &Utf8Path) -> Result<Vec<Utf8PathBuf>, RunError> {
    let folder = run.join("spectra");
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in folder.read_dir_utf8().map_err(io(&folder, "list"))? {
        let path = entry.map_err(io(&folder, "list"))?.into_path();
        // Spectra are numbered; a calibration or a half-written part may stand beside them.
        let numbered = path
            .file_stem()
            .is_some_and(|stem| !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_digit()));
        if numbered && path.extension() == Some("csv") {
            names.push(path);
        }
    }
    names.sort();
    Ok(names)
}

fn append_to(path: &Utf8Path) -> Result<File, RunError> {
    OpenOptions::new()
        .create(true)
        .append(true)
        .open(path)
        .map_err(io(path, "open"))
}

fn write_synced(file: &mut File, path: &Utf8Path, bytes: &[u8]) -> Result<(), RunError> {
    file.write_all(bytes).map_err(io(path, "write"))?;
    file.sync_data().map_err(io(path, "sync"))
}

/// The folder is synced too: a rename that a loss of power undoes would leave the older file.
fn write_whole(path: &Utf8Path, bytes: &[u8]) -> Result<(), RunError> {
    let folder = path.parent().unwrap_or(Utf8Path::new("."));
    let part = folder.join(format!(".{}.part", path.file_name().unwrap_or("file")));
    let mut file = File::create(&part).map_err(io(&part, "write"))?;
    file.write_all(bytes).map_err(io(&part, "write"))?;
    file.sync_all().map_err(io(&part, "sync"))?;
    std::fs::rename(&part, path).map_err(io(path, "replace"))?;
    #[cfg(unix)]
    File::open(folder)
        .and_then(|folder| folder.sync_all())
        .map_err(io(folder, "sync"))?;
    Ok(())
}

fn cut_to_whole_lines(path: &Utf8Path) -> Result<(), RunError> {
    if !path.exists() {
        return Ok(());
    }
    let bytes = std::fs::read(path).map_err(io(path, "read"))?;
    let whole = bytes
        .iter()
        .rposition(|&byte| byte == b'\n')
        .map_or(0, |place| place + 1);
    if whole < bytes.len() {
        let file = OpenOptions::new().write(true).open(path).map_err(io(path, "open"))?;
        file.set_len(whole as u64).map_err(io(path, "cut off the torn tail"))?;
    }
    Ok(())
}

fn io<'a>(path: &'a Utf8Path, action: &'static str) -> impl Fn(std::io::Error) -> RunError + 'a {
    move |source| RunError::Io {
        path: path.to_owned(),
        action,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::tests::reading;
    use crate::spectra::tests::{calibration, spectrum};

    fn header() -> RunHeader {
        RunHeader {
            format: FORMAT.to_owned(),
            program: "isolux test".to_owned(),
            started_utc: "2026-01-01T00:00:00Z".to_owned(),
            lamp_on_utc: None,
            stopped: None,
            device: vec![DeviceRecord {
                role: "luxmeter".to_owned(),
                open: "t10a:x".to_owned(),
                model: "T-10A".to_owned(),
                serial: Some("1".to_owned()),
                firmware: None,
            }],
            spectral: Some(calibration()),
            station: Station::parse(Utf8Path::new("s.toml"), crate::station::tests::STATION).unwrap(),
            plan: Plan::parse(Utf8Path::new("p.toml"), crate::plan::tests::PLAN).unwrap(),
        }
    }

    fn stopped() -> Stopped {
        Stopped {
            utc: "2026-01-01T01:00:00Z".to_owned(),
            how: StopHow::Interrupted,
            message: "by signal".to_owned(),
            axes_at_rest: true,
            readings: 3,
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
        assert_eq!(run.header.stopped, Some(stopped()));
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
        assert_eq!(
            std::fs::read(&file).unwrap(),
            bytes,
            "the row that was lost is written again, in its place"
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
}
