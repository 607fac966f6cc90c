//! A session with instruments: real links and real time, twins among them perhaps; or the virtual darkroom alone and a
//! clock that runs as fast as it can.

use std::future::Future;
use std::sync::Arc;

use async_trait::async_trait;
use camino::Utf8Path;
use isolux_darkroom::Darkroom;
use isolux_device::{Kind, Target};
use isolux_record::Station;
use isolux_transport::{LineSettings, Link, LinkError, Links, MemoryLinks, Recorder, SystemLinks};
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Serving, VirtualRoom};
use tokio::runtime::Runtime;

use crate::darkroom::capture;
use crate::front_end::control::Control;
use crate::front_end::progress::{Event, Progress};
use crate::instruments::owner::{self, TakeOver};
use crate::instruments::{catalogue, roles};
use crate::{Failure, FailureKind};

/// Links of virtual time: the clock runs on as soon as nobody computes, which no real instrument can follow.
struct TwinsOnly(MemoryLinks);

#[async_trait]
impl Links for TwinsOnly {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        if address.starts_with("memory:") {
            return self.0.open(address, line).await;
        }
        Err(LinkError {
            address: address.to_owned(),
            reason:
                "this session runs in virtual time, hours in seconds, and a real instrument needs its own time: every \
                     deadline would be over before it could answer"
                    .to_owned(),
            advice: Some("open it in a station of its own, or together with twins at memory: in real time".to_owned()),
        })
    }
}

/// The links of a session, and the room behind them if it is virtual.
pub struct Session {
    /// Opens addresses.
    pub links: Arc<dyn Links>,
    /// The virtual room, on the same runtime as the drivers.
    pub room: Option<VirtualRoom>,
    system: SystemLinks,
    /// Ends with the session.
    serving: Option<Serving>,
}

impl Session {
    /// Links of the machine, and in memory those of the built-in darkroom if `in_memory`.
    ///
    /// # Errors
    /// Never for the built-in darkroom as it is shipped.
    pub fn open(in_memory: bool) -> Result<Self, Failure> {
        if in_memory {
            return Self::in_room(Darkroom::built_in().map_err(Failure::bad_input)?, &Choice::default());
        }
        Ok(Self::of_links(SystemLinks::default()))
    }

    /// The links of the machine, without a room.
    pub(crate) fn of_links(system: SystemLinks) -> Self {
        Self {
            links: Arc::new(system.clone()),
            room: None,
            system,
            serving: None,
        }
    }

    /// Links for `station`, which stands in `file`: those of the machine, and in memory those of the darkroom that the
    /// station names or of the built-in one. Must be called on the runtime.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line of the darkroom.
    pub fn of(station: &Station, file: &Utf8Path, progress: &dyn Progress) -> Result<Self, Failure> {
        Self::on(SystemLinks::default(), station, file, progress)
    }

    /// As [`of`](Self::of), through links of the caller's.
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn on(
        system: SystemLinks,
        station: &Station,
        file: &Utf8Path,
        progress: &dyn Progress,
    ) -> Result<Self, Failure> {
        if !roles::has_twins(station) {
            return match station.darkroom() {
                None => Ok(Self::of_links(system)),
                Some(_) => Err(Failure::bad_input(format!(
                    "{file}: `darkroom` is the room behind memory: links, and this station has none"
                ))
                .help(
                    "remove the key, or write a station by `isolux virtual darkroom --in-memory --station-out FILE`",
                )),
            };
        }
        let document = match station.darkroom() {
            None => Darkroom::built_in().map_err(Failure::bad_input)?,
            Some(darkroom) => {
                let darkroom = file.parent().unwrap_or(Utf8Path::new("")).join(darkroom);
                capture::document(&darkroom, progress)?
            }
        };
        let choice = twins_of(station, file)?;
        if roles::is_virtual(station) {
            return Self::in_room(document, &choice);
        }
        let (twins, real): (Vec<_>, Vec<_>) = roles::opened(station).partition(|(_, _, open)| roles::in_memory(open));
        let names = |roles: &[(&'static str, Kind, &str)]| {
            let names = roles.iter().map(|(key, ..)| key.trim_end_matches(".open"));
            names.collect::<Vec<_>>().join(", ")
        };
        progress.event(Event::Note(&format!(
            "in real time, because {} are real instruments; twins are {}: they see the virtual room, its axes and its lamp alone",
            names(&real),
            names(&twins)
        )));
        let mut session = Self::of_links(system);
        session.serve(document, &choice)?;
        Ok(session)
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
        let mut session = Self::of(station, file, progress)?;
        if let Some(path) = trace {
            let failed = |error: std::io::Error| Failure::instrument(format!("{path}: cannot write: {error}"));
            let file = std::fs::File::create(path).map_err(failed)?;
            session.links = Arc::new(Recorder::new(session.links.clone(), Box::new(file)).map_err(failed)?);
        }
        Ok(session)
    }

    /// Becomes the owner of all instruments of `station` before any of them is opened; `force` is the reason for which
    /// they may be taken over from a process that does not answer.
    ///
    /// # Errors
    /// Exit 3, naming who has an instrument, since when, and what to do.
    pub async fn claim(&self, station: &Station, force: Option<&str>) -> Result<Option<TakeOver>, Failure> {
        owner::claim(&self.system, station, force).await
    }

    /// The failure of work in this session; where another process has taken the instruments over, it says so.
    pub fn explain(&self, failure: Failure) -> Failure {
        match self.system.lost() {
            Some(lost) if !failure.message.contains(&lost) => Failure {
                message: format!(
                    "{}; {lost}: what the axes do now is up to that process",
                    failure.message
                ),
                ..failure
            },
            _ => failure,
        }
    }

    /// In-memory links of the darkroom `document` with the twins of `choice`. Must be called on the runtime.
    ///
    /// # Errors
    /// Exit 3 when the twins cannot listen.
    pub fn in_room(document: Darkroom, choice: &Choice) -> Result<Self, Failure> {
        let mut session = Self::of_links(SystemLinks::default());
        session.serve(document, choice)?;
        session.links = Arc::new(TwinsOnly(session.system.memory.clone()));
        Ok(session)
    }

    /// Serves the twins of `choice` in the room of `document` to the memory: links of this session.
    fn serve(&mut self, document: Darkroom, choice: &Choice) -> Result<(), Failure> {
        let room = VirtualRoom::open_with(document, choice);
        self.serving = Some(room.listen(&self.system.memory).map_err(Failure::instrument)?);
        self.room = Some(room);
        Ok(())
    }
}

/// The twins that answer the drivers of a station: `DRIVER:memory:luxmeter` is the lux meter's twin that speaks to
/// DRIVER.
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
pub fn run<T>(in_memory: bool, work: impl Future<Output = Result<T, Failure>>) -> Result<T, Failure> {
    runtime(in_memory)?.block_on(work)
}

/// A runtime on the thread that waits for it: in virtual time, hours in seconds, if `in_memory`.
///
/// # Errors
/// Exit 3 when the system gives none.
pub(crate) fn runtime(in_memory: bool) -> Result<Runtime, Failure> {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    builder.enable_all();
    if in_memory {
        builder.start_paused(true);
    }
    builder.build().map_err(Failure::instrument)
}

/// As [`run`], at the pace of `control` where time is virtual.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_controlled<T>(
    in_memory: bool,
    control: &Control,
    work: impl Future<Output = Result<T, Failure>>,
) -> Result<T, Failure> {
    run(in_memory, async {
        if in_memory {
            control.paced(work).await
        } else {
            work.await
        }
    })
}

/// How a scan's errors reach a front end.
pub fn failure(error: &isolux_scan::ScanError) -> Failure {
    use isolux_scan::ScanErrorKind as Kind;
    let kind = match error.kind() {
        Kind::BadPlan => FailureKind::BadInput,
        Kind::NotAccepted => FailureKind::No,
        Kind::Instrument => FailureKind::Instrument,
        Kind::Interrupted => FailureKind::Interrupted,
    };
    Failure {
        kind,
        message: error.to_string(),
        help: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front_end::progress::Silent;
    use crate::init::virtual_station;
    use crate::instruments::catalogue::Catalogue;

    fn station(changes: &[(&str, &str)]) -> Station {
        let mut text = virtual_station(&Choice::default()).unwrap().0;
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replacen(from, to, 1);
        }
        Station::parse(Utf8Path::new("s.toml"), &text).unwrap()
    }

    #[test]
    fn one_real_instrument_makes_time_real_whichever_it_is() {
        assert!(roles::is_virtual(&station(&[])));
        for (from, to) in [
            ("konica-t10a:memory:luxmeter?head=0", "konica-t10a:/dev/ttyUSB1?head=0"),
            ("zaber:memory:axes?axis=2", "zaber:/dev/ttyUSB0?axis=2"),
            ("ocean-ooi:memory:spectrometer", "ocean-ooi:tcp://127.0.0.1:7000"),
            ("zaber:memory:axes?ai=1&", "zaber:/dev/ttyUSB0?ai=1&"),
        ] {
            let mixed = station(&[(from, to)]);
            assert!(!roles::is_virtual(&mixed) && roles::has_twins(&mixed), "{to}");
        }
    }

    #[tokio::test]
    async fn a_mixed_station_has_twins_in_real_time_and_opens_the_rest() {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let meter = format!("konica-t10a:tcp://{}?head=0", listener.local_addr().unwrap());
        let mixed = station(&[("konica-t10a:memory:luxmeter?head=0", &meter)]);
        let session = Session::of(&mixed, Utf8Path::new("s.toml"), &Silent).unwrap();
        let catalogue = Catalogue::new(session.links.clone());
        let thermometer = catalogue
            .thermometer(mixed.ambient().unwrap().open.as_deref().unwrap())
            .await;
        thermometer.unwrap().read().await.unwrap();
        let (opened, accepted) = tokio::join!(
            tokio::time::timeout(
                std::time::Duration::from_millis(200),
                catalogue.lux_meter(&mixed.luxmeter().open)
            ),
            listener.accept()
        );
        assert!(
            opened.is_err() && accepted.is_ok(),
            "it was connected, and waits for an answer in real time"
        );
    }

    #[tokio::test(start_paused = true)]
    async fn virtual_time_refuses_a_real_instrument_and_says_why() {
        let session = Session::open(true).unwrap();
        let catalogue = Catalogue::new(session.links.clone());
        let error = catalogue
            .lux_meter("konica-t10a:tcp://127.0.0.1:9?head=0")
            .await
            .err()
            .unwrap();
        let stated = error.to_string();
        assert!(
            stated.contains("virtual time") && stated.contains("its own time"),
            "{stated}"
        );
    }

    #[test]
    fn two_drivers_on_one_twin_and_a_driver_without_twin_are_refused_by_the_key() {
        let of = |changes: &[(&str, &str)]| twins_of(&station(changes), Utf8Path::new("s.toml"));
        let both = [("konica-t10a:memory:luxmeter?head=0", "konica-t10a:memory:axes?head=0")];
        let error = of(&both).err().unwrap().message;
        assert!(
            error.contains("s.toml: luxmeter.open") && error.contains("axis.c.open has driver zaber"),
            "{error}"
        );
        let wrong = [("konica-t10a:memory:luxmeter?head=0", "zaber:memory:luxmeter?head=0")];
        let error = of(&wrong).err().unwrap().message;
        assert!(
            error.contains("no twin that plays the luxmeter") && error.contains("konica-t10a"),
            "{error}"
        );
    }
}
