//! `calibrate`: a run with a standard lamp → the factors of a spectroradiometer or a lux meter, with their uncertainty,
//! and what has changed since the last ones.

mod diary;
mod document;
mod files;
mod procedure;
pub mod spectrometer;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::run::StopHow;
use isolux_record::{Plan, RunHeader, Standard, Subject};
use isolux_reduce::standard::{self, CalibrationError};
use jiff::Timestamp;
use jiff::civil::Date;

use crate::Failure;
use crate::files::{self as disk_files, Overwrite};
use crate::front_end::control::Control;
use crate::front_end::progress::Progress;
use crate::history;
use crate::instruments::bench::{PROGRAM, StationFiles};
use crate::run::record;
use crate::scan::plan::located;
use crate::scan::{Operator, Place, ScanJob, Target};

pub use document::{Calibration, FORMAT, Outcome};
pub use isolux_reduce::standard::{Calibrated as Instrument, LuxFactor, SpectralFactors};

/// Folder in the run with what is made of it.
pub const FOLDER: &str = "calibration";

/// Days after which a calibration is due again, where nothing else is asked for.
pub const VALID_DAYS: i32 = 365;

/// What is calibrated, with what, and where it is recorded.
#[derive(Clone)]
pub struct CalibrationRequest<'a> {
    /// The instrument.
    pub instrument: Instrument,
    /// The bench, STATION.toml.
    pub station: &'a Utf8Path,
    /// The certificate of the standard lamp.
    pub standard: &'a Utf8Path,
    /// The run directory; one that was broken off is resumed, one that is complete is only computed again.
    pub out: &'a Utf8Path,
    /// Days after which the calibration is due again.
    pub valid_days: i32,
    /// The reason for which instruments may be taken over.
    pub force: Option<&'a str>,
    /// The person beside the bench.
    pub operator: Option<&'a dyn Operator>,
    /// Pauses and ends the scan.
    pub control: &'a Control,
    /// Receives what happens.
    pub progress: &'a dyn Progress,
}

/// A calibration and the files that it wrote.
#[derive(Debug)]
pub struct Done {
    /// What was found.
    pub calibration: Calibration,
    /// The folder of its files.
    pub folder: Utf8PathBuf,
    /// Their names.
    pub files: Vec<String>,
}

/// Carries the procedure out and computes the factors.
///
/// # Errors
/// Bad input (exit 2), before anything is opened, for a certificate that has expired or does not fit, and for a station
/// that does not state what is needed. "No" (exit 1) where the record does not give a calibration: another current,
/// saturated, not linear, unsteady. As a scan for the rest.
pub fn run(request: &CalibrationRequest<'_>) -> Result<Done, Failure> {
    let standard = Standard::load(request.standard).map_err(Failure::bad_input)?;
    let source = StationFiles::load(request.station)?;
    let refused = |error: CalibrationError| failure(request.standard, &error);
    let recorded = recorded(request.out)?;
    if recorded != Some(StopHow::Completed) {
        let distance_mm = procedure::distance_mm(request.instrument, &source.station, &standard);
        let today = Timestamp::now().to_string();
        let day = today.get(..10).unwrap_or_default();
        standard::stated(request.instrument, &source.station, &standard, distance_mm, day).map_err(refused)?;
        let text = procedure::plan(request.instrument, &source.station, &standard);
        let bench = AtBench {
            out: request.out,
            force: request.force,
            operator: request.operator,
            control: request.control,
            progress: request.progress,
        };
        bench.scan(&source, &text, &subject(&standard), recorded.is_some())?;
    }
    let run = record::read_at_rest(request.out)?;
    let header = disk_files::read(&request.out.join("run.toml"))?;
    let outcome = match request.instrument {
        Instrument::Spectroradiometer => {
            standard::spectroradiometer(&run, &standard).map(|factors| Outcome::Spectroradiometer(Box::new(factors)))
        }
        Instrument::Luxmeter => standard::luxmeter(&run, &standard).map(|factor| Outcome::Luxmeter(Box::new(factor))),
    };
    let outcome = outcome.map_err(|error| {
        let refused = failure(request.standard, &error);
        Failure {
            message: format!("{}: {error}", request.out),
            ..refused
        }
    })?;
    let calibrated = outcome.conditions().day.clone();
    let calibration = Calibration {
        format: FORMAT.to_owned(),
        program: PROGRAM.to_owned(),
        due: due(&calibrated, request.valid_days)?,
        calibrated,
        record_sha256: isolux_record::disk::sha256(&header),
        outcome,
    };
    let folder = request.out.join(FOLDER);
    let made = files::of(&calibration, &standard, request.standard)?;
    for (name, bytes) in &made {
        // They are computed from the record, whose hash is in them: the same again, or those of a better program.
        disk_files::write(&folder.join(name), bytes, Overwrite::Force)?;
    }
    history::add(request.station, &diary::entries(request.out, &calibration))?;
    Ok(Done {
        calibration,
        folder,
        files: made.into_iter().map(|(name, _)| name).collect(),
    })
}

/// How the run in `path` ended; none where there is no run, [`StopHow::Interrupted`] where its program was killed.
fn recorded(path: &Utf8Path) -> Result<Option<StopHow>, Failure> {
    if !path.join("run.toml").is_file() {
        return Ok(None);
    }
    let header = RunHeader::read(path).map_err(Failure::bad_input)?;
    Ok(Some(header.stopped.map_or(StopHow::Interrupted, |stopped| stopped.how)))
}

/// With whom and what a procedure is carried out.
#[derive(Clone, Copy)]
pub struct AtBench<'a> {
    /// The run directory; one that was broken off is resumed, one that is complete is only computed again.
    pub out: &'a Utf8Path,
    /// The reason for which instruments may be taken over.
    pub force: Option<&'a str>,
    /// The person beside the bench.
    pub operator: Option<&'a dyn Operator>,
    /// Pauses and ends the scan.
    pub control: &'a Control,
    /// Receives what happens.
    pub progress: &'a dyn Progress,
}

impl AtBench<'_> {
    /// Scans by the plan in `text`, or goes on with the run where it was broken off.
    fn scan(&self, source: &StationFiles, text: &str, subject: &Subject, resume: bool) -> Result<(), Failure> {
        let file = Utf8Path::new("procedure of the calibration");
        let plan = Plan::parse(file, text).map_err(Failure::bad_input)?;
        isolux_scan::dry_run(&source.station, &plan).map_err(|fault| located(file, text, &fault))?;
        let target = if resume {
            Target::Resume(self.out)
        } else {
            Target::New(self.out)
        };
        let job = ScanJob {
            source,
            plan: &plan,
            place: Place::take(target, self.force.is_some())?.of(subject),
            force: self.force,
            operator: self.operator,
            control: self.control,
            progress: self.progress,
        };
        match job.execute() {
            Ok(_) => Ok(()),
            Err(failure) if failure.help.as_ref().is_some_and(|help| help.contains("--resume")) => {
                Err(failure.help(format!("the same command goes on with {}", self.out)))
            }
            Err(failure) => Err(failure),
        }
    }
}

/// The lamp as what was measured.
fn subject(standard: &Standard) -> Subject {
    let mut subject = Subject::default();
    let lamp = &standard.document().lamp;
    subject.luminaire.name = Some(lamp.designation.clone());
    subject.luminaire.sample = Some(lamp.number.clone());
    subject.luminaire.hours_run = lamp.hours_run.map(|hours| format!("{hours} h"));
    subject
}

/// The day on which the calibration is due again.
fn due(calibrated: &str, valid_days: i32) -> Result<String, Failure> {
    let day: Date = calibrated.parse().map_err(Failure::bad_input)?;
    let due = day.checked_add(jiff::Span::new().days(valid_days));
    due.map(|due| due.to_string()).map_err(Failure::bad_input)
}

fn failure(standard: &Utf8Path, error: &CalibrationError) -> Failure {
    let message = format!("{standard}: {error}");
    if error.is_input() {
        Failure::bad_input(message)
    } else {
        Failure::no(message).help("no factor was written; the record stays as evidence, begin again in another folder")
    }
}
