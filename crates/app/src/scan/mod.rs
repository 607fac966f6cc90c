//! `scan`: a plan becomes a run directory.

mod estimate;
pub mod for_sensor;
mod narrator;
pub mod plan;
mod state;

use camino::Utf8Path;
use isolux_record::{Logged, Plan, Reading, RunDir, RunLock, RunLockError, Subject};
use isolux_scan::{Awake, Devices, DryRun, Engine, Nobody, dry_run};
pub use isolux_scan::{Operator, ScanSummary};
use jiff::Timestamp;

use crate::Failure;
use crate::front_end::control::Control;
pub use crate::front_end::progress::duration;
use crate::front_end::progress::{Event, Progress};
use crate::instruments::bench::StationFiles;
use crate::instruments::catalogue::Catalogue;
use crate::instruments::owner::TakeOver;
use crate::instruments::roles;
use crate::instruments::session::{self, Session};
use crate::run::record;
use crate::system::keep_awake::keep_awake;
use crate::system::signals::OnSignals;
use crate::system::{asleep, log};
use narrator::Narrator;
pub(crate) use state::{ScanState, spread_words};

/// Where a run is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target<'a> {
    /// A new run directory.
    New(&'a Utf8Path),
    /// A broken-off run that is resumed.
    Resume(&'a Utf8Path),
    /// A run with a damaged record: what is whole stays, what is missing is read again.
    Reread(&'a Utf8Path),
}

impl<'a> Target<'a> {
    fn path(self) -> &'a Utf8Path {
        match self {
            Self::New(path) | Self::Resume(path) | Self::Reread(path) => path,
        }
    }
}

/// A run directory that this process alone writes from now on.
#[derive(Debug, Clone)]
pub struct Place<'a> {
    target: Target<'a>,
    lock: RunLock,
    /// From whom it was taken over.
    from: Option<String>,
    /// What is measured there, and for whom.
    subject: Subject,
}

impl<'a> Place<'a> {
    /// Takes the run directory before any instrument is opened; with `force` also from a process that does not answer.
    ///
    /// # Errors
    /// Exit 3 naming who writes it; bad input (exit 2) for what the disk would refuse later.
    pub fn take(target: Target<'a>, force: bool) -> Result<Self, Failure> {
        let path = target.path();
        // A folder is made for a new run alone.
        if matches!(target, Target::New(_)) || !path.is_dir() {
            refuse(target)?;
        }
        let (lock, from) = RunLock::take(path, force).map_err(|error| {
            let failure = Failure::instrument(&error);
            match error {
                RunLockError::InUse { held, .. } if held.works() => {
                    failure.help("wait until it ends, or end it (Ctrl-C there)")
                }
                RunLockError::InUse { .. } => failure
                    .help("end that process, or take the run over with --force \"REASON\"; the reason is recorded"),
                RunLockError::Refused { .. } => failure,
            }
        })?;
        refuse(target)?;
        Ok(Self {
            target,
            lock,
            from: from.map(|held| format!("{path} from {held}")),
            subject: Subject::default(),
        })
    }

    /// The same place, for a record of `subject`.
    #[must_use]
    pub fn of(mut self, subject: &Subject) -> Self {
        self.subject = subject.clone();
        self
    }
}

/// A scan to be carried out.
#[derive(Clone)]
pub struct ScanJob<'a> {
    /// The bench.
    pub source: &'a StationFiles,
    /// What is measured on it.
    pub plan: &'a Plan,
    /// Where it is recorded.
    pub place: Place<'a>,
    /// The reason for which instruments may be taken over from a process that does not answer.
    pub force: Option<&'a str>,
    /// The person beside the bench.
    pub operator: Option<&'a dyn Operator>,
    /// Pauses and ends the scan.
    pub control: &'a Control,
    /// Receives what happens.
    pub progress: &'a dyn Progress,
}

impl ScanJob<'_> {
    /// Opens the instruments and scans.
    ///
    /// # Errors
    /// 1 when a check fails; 3 when an instrument fails, belongs to another process, or an axis could not be
    /// verified at rest; 130 when interrupted.
    pub fn execute(&self) -> Result<ScanSummary, Failure> {
        let Self { source, progress, .. } = *self;
        let in_memory = roles::is_virtual(&source.station);
        session::run_controlled(in_memory, self.control, async {
            let session = Session::of(&source.station, &source.file, progress)?;
            let signals = OnSignals::ending(&self.control.cancel)?;
            let outcome = async {
                let taken = session.claim(&source.station, self.force).await?;
                let _awake = keep_awake(!in_memory, progress);
                let catalogue = Catalogue::new(session.links.clone()).beside(&source.file);
                let mut devices = source.open(&catalogue).await?;
                self.execute_on(&mut devices, taken.as_ref(), Timestamp::now())
                    .await
                    .map_err(|failure| session.explain(failure))
            }
            .await;
            signals.until_reported(outcome)
        })
    }

    /// Scans on instruments that are open. What was `taken` over is recorded.
    ///
    /// # Errors
    /// As [`execute`](Self::execute).
    pub async fn execute_on(
        &self,
        devices: &mut Devices,
        taken: Option<&TakeOver>,
        now_utc: Timestamp,
    ) -> Result<ScanSummary, Failure> {
        let Self {
            source,
            plan,
            control,
            progress,
            ..
        } = *self;
        let place = self.place.clone();
        let mut header = source.header(devices, plan, now_utc.to_string());
        header.state(&place.subject);
        let (mut run, resumed) = match place.target {
            Target::New(path) => (RunDir::create(path, header).map_err(record_failure)?, None),
            Target::Resume(path) | Target::Reread(path) => {
                let (run, old) = match place.target {
                    Target::Reread(_) => RunDir::reread(path, &header),
                    _ => RunDir::resume(path, &header),
                }
                .map_err(record_failure)?;
                old.notices
                    .iter()
                    .for_each(|notice| progress.event(Event::Note(notice)));
                (run, Some(old))
            }
        };
        run.guard(place.lock);
        log::keep_in(run.path());
        if let Some(taken) = taken {
            let from = taken.from.iter().chain(&place.from).cloned().collect();
            run.event(&Logged {
                time_utc: now_utc.to_string(),
                event: isolux_record::Event::TakenOver {
                    reason: taken.reason.clone(),
                    from,
                },
            })
            .map_err(record_failure)?;
        }
        let already: &[Reading] = resumed.as_ref().map_or(&[], |run| &run.readings.rows);
        let lasting = (!roles::is_virtual(&source.station)).then_some(source.file.as_path());
        // Virtual time stands still while the program does not run.
        let awake = match lasting {
            Some(_) => Awake::watching(asleep::clock()),
            None => Awake::unwatched(),
        };
        let observer = Narrator::new(progress, run.header(), run.path(), already, lasting);
        let wall_clock: &dyn Fn() -> Timestamp = &Timestamp::now;
        let engine = Engine {
            station: &source.station,
            operator: self.operator.unwrap_or(&Nobody),
            pause: &control.pause,
            observer: &observer,
            awake: &awake,
            now_utc,
            wall_clock: lasting.is_some().then_some(wall_clock),
        };
        // The states of a scan are too many for the stack of whoever waits for it.
        let outcome = Box::pin(engine.run(devices, plan, &mut run, &control.cancel, resumed.as_ref())).await;
        if let Err(error) = &outcome {
            tracing::error!(%error, "the scan ended early");
        }
        log::leave_run();
        observer.ended(&match &outcome {
            Ok(summary) => format!(
                "{} readings, {} spectra in {}",
                summary.readings,
                summary.spectra,
                duration(summary.duration_s)
            ),
            Err(error) => format!("ended early: {error}"),
        });
        outcome.map_err(|error| {
            let failure = session::failure(&error);
            let path = run.path();
            if run.still_ours().is_err() {
                return failure;
            }
            failure.help(format!(
                "{path} holds {} readings; go on with --resume {path}",
                run.len()
            ))
        })
    }
}

/// The station and the plan of these files, and what the one asks of the other: limits of the axes and of the rail,
/// switches that are missing, a person who is not there.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub fn checked(
    station: &Utf8Path,
    plan_file: &Utf8Path,
    attended: bool,
) -> Result<(StationFiles, Plan, DryRun), Failure> {
    let source = StationFiles::load(station)?;
    let (plan, day) = planned(&source, plan_file, attended)?;
    Ok((source, plan, day))
}

/// The plan of this file, and what it asks of the station of `source`.
///
/// # Errors
/// As [`checked`].
pub(crate) fn planned(source: &StationFiles, plan_file: &Utf8Path, attended: bool) -> Result<(Plan, DryRun), Failure> {
    let (plan, text) = plan::load(plan_file)?;
    let day = dry_run(&source.station, &plan).map_err(|fault| plan::located(plan_file, &text, &fault))?;
    if asks(source, &plan) && !attended {
        return Err(Failure::bad_input(format!(
            "{plan_file} asks a person for something, and nobody is there to answer"
        ))
        .help("run it from a terminal or from the page, or name who is asked"));
    }
    Ok((plan, day))
}

/// Whether somebody will be asked.
fn asks(source: &StationFiles, plan: &Plan) -> bool {
    let station = &source.station;
    let person = |access: Option<&isolux_record::station::Access>| access.is_some_and(|access| access.prompt.is_some());
    let kinds = |kind| plan.blocks().iter().any(|block| block.kind == kind);
    let other_distance = plan.blocks().iter().any(|block| {
        block
            .distance_mm
            .is_some_and(|distance| distance != station.bench().distance_mm)
            && block.instrument == isolux_record::plan::Instrument::Luxmeter
    });
    plan.blocks().iter().any(|block| block.prompt.is_some())
        || station.lamp().is_some_and(|lamp| lamp.prompt.is_some())
        || person(station.shutter()) && kinds(isolux_record::ReadingKind::Capped)
        || person(station.baffle()) && kinds(isolux_record::ReadingKind::Baffled)
        || station.rail().is_some_and(|rail| rail.prompt.is_some()) && other_distance
}

/// What would be refused by the disk is refused before the instruments are opened.
fn refuse(target: Target<'_>) -> Result<(), Failure> {
    match target {
        Target::New(path) => {
            if !isolux_record::run::vacant(path) {
                return Err(Failure::bad_input(format!("{path} is not empty")).help(format!(
                    "choose another folder, or take the run up again with --resume {path}"
                )));
            }
        }
        Target::Resume(path) => {
            record::read(path)?;
        }
        Target::Reread(path) => {
            isolux_record::RunHeader::read(path).map_err(Failure::bad_input)?;
        }
    }
    Ok(())
}

fn record_failure(error: isolux_record::RunError) -> Failure {
    let help = record::help(&error);
    Failure {
        help,
        ..session::failure(&isolux_scan::ScanError::Record(error))
    }
}
