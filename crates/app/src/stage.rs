//! Where a bench plays: real links and real time, or the built-in virtual darkroom and a clock that runs as fast as it can.

use std::future::Future;
use std::sync::Arc;

use camino::Utf8Path;
use isolux_darkroom::Darkroom;
use isolux_device::Target;
use isolux_record::Station;
use isolux_transport::{Links, Recorder, SystemLinks};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Serving, VirtualRoom};

use crate::owner::{self, TakeOver};
use crate::progress::Progress;
use crate::{Failure, FailureKind, capture, catalogue, roles};

/// Whether a station lives in the virtual darkroom of this process: all its links are `memory:`.
pub fn is_virtual(station: &Station) -> bool {
    station.axis_c().open.contains(":memory:") && station.luxmeter().open.contains(":memory:")
}

/// The links of a session, and the room behind them if it is virtual.
pub struct Stage {
    /// Opens addresses.
    pub links: Arc<dyn Links>,
    /// The virtual room, on the same runtime as the drivers.
    pub room: Option<VirtualRoom>,
    system: SystemLinks,
    _serving: Option<Serving>,
}

impl Stage {
    /// Links of the machine, and in memory those of the built-in darkroom if `in_memory`.
    ///
    /// # Errors
    /// Never for the built-in darkroom as it is shipped.
    pub fn open(in_memory: bool) -> Result<Self, Failure> {
        if in_memory {
            return Self::in_room(Darkroom::built_in().map_err(Failure::bad_input)?, &Choice::default());
        }
        let system = SystemLinks::default();
        Ok(Self {
            links: Arc::new(system.clone()),
            room: None,
            system,
            _serving: None,
        })
    }

    /// Links for `station`, which stands in `file`: those of the machine, and in memory those of the darkroom that the station
    /// names or of the built-in one. Must be called on the runtime.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line of the darkroom.
    pub fn of(station: &Station, file: &Utf8Path, progress: &dyn Progress) -> Result<Self, Failure> {
        match station.darkroom() {
            None if is_virtual(station) => {
                let document = Darkroom::built_in().map_err(Failure::bad_input)?;
                Self::in_room(document, &twins_of(station, file)?)
            }
            None => Self::open(false),
            Some(_) if !is_virtual(station) => Err(Failure::bad_input(format!(
                "{file}: `darkroom` is the room behind memory: links, and this station has others"
            ))
            .help("remove the key, or write a station by `isolux virtual darkroom --in-memory --station-out FILE`")),
            Some(darkroom) => {
                let darkroom = file.parent().unwrap_or(Utf8Path::new("")).join(darkroom);
                Self::in_room(capture::document(&darkroom, progress)?, &twins_of(station, file)?)
            }
        }
    }

    /// As [`of`](Self::of), with every byte on the links written to `trace`.
    ///
    /// # Errors
    /// Exit 3 when the trace cannot be written.
    pub fn recording(
        station: &Station,
        file: &Utf8Path,
        trace: Option<&Utf8Path>,
        progress: &dyn Progress,
    ) -> Result<Self, Failure> {
        let mut stage = Self::of(station, file, progress)?;
        if let Some(path) = trace {
            let failed = |error: std::io::Error| Failure::instrument(format!("{path}: cannot write: {error}"));
            let file = std::fs::File::create(path).map_err(failed)?;
            stage.links = Arc::new(Recorder::new(stage.links.clone(), Box::new(file)).map_err(failed)?);
        }
        Ok(stage)
    }

    /// Becomes the owner of all instruments of `station` before any of them is opened; `force` is the reason for which they
    /// may be taken over from a process that does not answer.
    ///
    /// # Errors
    /// Exit 3, naming who has an instrument, since when, and what to do.
    pub async fn claim(&self, station: &Station, force: Option<&str>) -> Result<Option<TakeOver>, Failure> {
        owner::claim(&self.system, station, force).await
    }

    /// The failure of work on this stage; where another process has taken the instruments over, it says so.
    pub fn explain(&self, failure: Failure) -> Failure {
        match self.system.lost() {
            Some(lost) => Failure {
                message: format!("{}; {lost}: what the axes do now is its affair", failure.message),
                ..failure
            },
            None => failure,
        }
    }

    /// In-memory links of the darkroom `document` with the twins of `choice`. Must be called on the runtime.
    ///
    /// # Errors
    /// Exit 3 when the twins cannot listen.
    pub fn in_room(document: Darkroom, choice: &Choice) -> Result<Self, Failure> {
        let links = SystemLinks::default();
        let room = VirtualRoom::open_with(document, choice);
        let serving = room.listen(&links.memory).map_err(Failure::instrument)?;
        Ok(Self {
            links: Arc::new(links.clone()),
            room: Some(room),
            system: links,
            _serving: Some(serving),
        })
    }
}

/// The twins that answer the drivers of a station: `DRIVER:memory:luxmeter` is the lux meter's twin that speaks to DRIVER.
///
/// # Errors
/// Bad input (exit 2) for a driver that has no twin of that instrument, and for two drivers on one twin.
fn twins_of(station: &Station, file: &Utf8Path) -> Result<Choice, Failure> {
    let mut choice = Choice::default();
    let mut chosen: Vec<(Instrument, &str, String)> = Vec::new();
    for (key, _, open) in roles::opened(station) {
        // What is no address, or names no driver or no pipe, is told when it is opened.
        let Ok(target) = Target::parse(open) else { continue };
        let pipe = target.link().strip_prefix("memory:");
        let instrument = Instrument::ALL
            .into_iter()
            .find(|one| pipe == Some(VirtualRoom::pipe(*one)));
        let (Some(instrument), Some(_)) = (instrument, catalogue::driver(target.driver())) else {
            continue;
        };
        let wrong = |message: String| Failure::bad_input(format!("{file}: {key}: `{open}`: {message}"));
        match chosen.iter().find(|(known, ..)| *known == instrument) {
            Some((_, _, driver)) if driver == target.driver() => {}
            Some((_, other, driver)) => {
                let message = format!("{other} has driver {driver} there, and one twin speaks one language");
                return Err(wrong(message));
            }
            None => {
                choice
                    .choose(instrument, target.driver())
                    .map_err(|error| wrong(error.to_string()))?;
                chosen.push((instrument, key, target.driver().to_owned()));
            }
        }
    }
    Ok(choice)
}

/// Runs `work` on a runtime of its own: in virtual time, hours in seconds, if `in_memory`.
///
/// # Errors
/// Exit 3 when the system gives no runtime, else what `work` answers.
pub fn play<T>(in_memory: bool, work: impl Future<Output = Result<T, Failure>>) -> Result<T, Failure> {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all();
    if in_memory {
        builder.start_paused(true);
    }
    let runtime = builder.build().map_err(Failure::instrument)?;
    runtime.block_on(work)
}

/// How a scan's errors reach a front end.
pub fn failure(error: &isolux_scan::ScanError) -> Failure {
    use isolux_scan::ScanErrorKind as Kind;
    let kind = match error.kind() {
        Kind::BadPlan => FailureKind::BadInput,
        Kind::Gate => FailureKind::No,
        Kind::Instrument => FailureKind::Instrument,
        Kind::Interrupted => FailureKind::Interrupted,
    };
    Failure {
        kind,
        message: error.to_string(),
        help: None,
    }
}
