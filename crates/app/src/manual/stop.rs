//! `stop`: what moves is stopped and verified, whoever owns the instruments and whatever has become of them.
//!
//! The owner is asked to end first (SIGTERM), because it stops the axes itself and closes its record; a process that
//! hangs or was stopped does not. So the instruments are taken from it: it can send them nothing more, even if it is
//! continued later, and the stop goes to the axes from here.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use camino::Utf8Path;
use isolux_device::{Axis, Coordinate, Target};
use isolux_lock::{Held, Holder, Lock, LockError, ProcessState};
use isolux_record::Station;
use isolux_scan::motion;
use isolux_transport::{SystemLinks, lock_files};
use serde::Serialize;
use tokio::time::{Instant, sleep};

use crate::Failure;
use crate::front_end::progress::Silent;
use crate::instruments::catalogue::Catalogue;
use crate::instruments::session::{self, Session};
use crate::instruments::{bench, roles};
use crate::manual::Position;
use crate::system::signals::OnSignals;

/// How long an owner that was asked to end may take before the axes are stopped without it.
const PATIENCE: Duration = Duration::from_millis(700);

/// The axes rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stopped {
    /// Where, read back.
    #[serde(flatten)]
    pub at: Position,
    /// What became of the owner of the instruments, one sentence each.
    pub owner: Vec<String>,
}

/// Stops every axis of the station and the rail, and verifies that they rest.
///
/// # Errors
/// Exit 2 for the station; exit 3 when an axis could not be verified at rest, or when an owner keeps the instruments
/// and may drive them again.
pub fn stop(file: &Utf8Path) -> Result<Stopped, Failure> {
    let station = Station::load(file).map_err(Failure::bad_input)?;
    let in_memory = roles::is_virtual(&station);
    session::run(in_memory, async {
        // A stop is not interrupted.
        let signals = OnSignals::listen()?;
        let (_locks, owner, may_drive) = hand_over(&axis_links(&station)).await;
        let session = match Session::on(SystemLinks::beside_their_owner(), &station, file, &Silent) {
            Ok(session) => session,
            Err(failure) if in_memory => return Err(failure),
            // A room that cannot be read keeps no real axis from being stopped.
            Err(_) => Session::of_links(SystemLinks::beside_their_owner()),
        };
        let catalogue = Catalogue::new(session.links.clone()).beside(file);
        let c = bench::open_axis(&catalogue, "axis.c", station.axis_c());
        let gamma = bench::open_axis(&catalogue, "axis.gamma", station.axis_gamma());
        // Each as soon as it can be reached: one that does not answer must not keep another running.
        let (c, gamma, rail) = tokio::join!(
            halt("axis.c", async { c.await.map(Some) }),
            halt("axis.gamma", async { gamma.await.map(Some) }),
            halt("rail", bench::open_rail(&catalogue, &station)),
        );
        let failed: Vec<String> = [&c, &gamma, &rail]
            .into_iter()
            .filter_map(|rest| rest.as_ref().err().cloned())
            .collect();
        let outcome = match (c, gamma) {
            (Ok(Some(c_deg)), Ok(Some(gamma_deg))) if failed.is_empty() && may_drive => {
                let rest = format!("stopped and at rest for now at C {c_deg:.4}°, γ {gamma_deg:.4}°");
                Err(Failure::instrument(format!("{rest}; {}", owner.join("; "))))
            }
            (Ok(Some(c_deg)), Ok(Some(gamma_deg))) if failed.is_empty() => Ok(Stopped {
                at: Position {
                    c_deg,
                    gamma_deg,
                    distance_mm: None,
                },
                owner,
            }),
            _ => {
                let mut sentences = failed;
                sentences.push("SWITCH THE AXES OFF BY HAND".to_owned());
                sentences.extend(owner);
                Err(Failure::instrument(sentences.join("; ")))
            }
        };
        signals.until_reported(outcome)
    })
}

/// The links of everything that moves.
fn axis_links(station: &Station) -> BTreeSet<String> {
    let rail = station.rail().and_then(|rail| rail.open.as_deref());
    [station.axis_c().open.as_str(), &station.axis_gamma().open]
        .into_iter()
        .chain(rail)
        .filter_map(|open| Some(Target::parse(open).ok()?.link().to_owned()))
        .collect()
}

/// Stops one axis; where it rests, or why that could not be verified.
async fn halt<P: Coordinate>(
    role: &'static str,
    opened: impl Future<Output = Result<Option<Box<dyn Axis<P>>>, Failure>>,
) -> Result<Option<f64>, String> {
    let unverified = |why: &dyn std::fmt::Display| format!("{role} could not be verified at rest ({why})");
    let Some(axis) = opened.await.map_err(|failure| unverified(&failure))? else {
        return Ok(None);
    };
    let rest = motion::stop(role, axis.as_ref()).await;
    rest.map(|position| Some(position.place.number()))
        .map_err(|(_, error)| unverified(&error))
}

/// Takes the locks of `links` from whoever has them, who is asked to end first. A lock that cannot be had keeps nothing
/// from being stopped. What became of the owners, and whether one of them may drive the axes again.
async fn hand_over(links: &BTreeSet<String>) -> (Vec<Lock>, Vec<String>, bool) {
    let (mut locks, mut stated, mut may_drive) = (Vec::new(), Vec::new(), false);
    let mut owned: Vec<(PathBuf, Held)> = Vec::new();
    for link in links {
        // What has no address fails where it is opened.
        for file in lock_files(link).await.unwrap_or_default() {
            match Lock::take(&file) {
                Ok(lock) => locks.push(lock),
                Err(LockError::Held(held)) => owned.push((file, held)),
                Err(error) => stated.push(format!("{error}; stopped without the lock")),
            }
        }
    }
    // All are asked before any is waited for.
    let requested: Vec<(PathBuf, Held, EndRequest)> = {
        let mut by_pid = BTreeMap::new();
        let ask = |(file, held): (PathBuf, Held)| {
            let requested = match &held.holder {
                Some(holder) => by_pid.entry(holder.pid).or_insert_with(|| ask_to_end(holder)).clone(),
                None => EndRequest::Not("it does not say who it is".to_owned()),
            };
            (file, held, requested)
        };
        owned.into_iter().map(ask).collect()
    };
    let deadline = Instant::now() + PATIENCE;
    for (file, held, requested) in requested {
        let mut taken = Lock::take(&file);
        while requested == EndRequest::Ending && matches!(taken, Err(LockError::Held(_))) && Instant::now() < deadline {
            sleep(Duration::from_millis(10)).await;
            taken = Lock::take(&file);
        }
        if let Ok(lock) = taken {
            locks.push(lock);
            stated.push(format!("{held} was asked to end, and ended"));
            continue;
        }
        let why = match &requested {
            EndRequest::Ending => format!("did not end within {PATIENCE:?}"),
            EndRequest::Suspended => "is suspended".to_owned(),
            EndRequest::Not(why) => format!("could not be asked to end ({why})"),
        };
        stated.push(match Lock::seize(&file) {
            Ok(lock) => {
                locks.push(lock);
                format!("{held} {why}; its instruments were taken from it, it can drive them no more")
            }
            Err(error) => {
                may_drive = true;
                format!("{held} {why}, and still has the instruments ({error}): END IT, it may drive the axes again")
            }
        });
    }
    stated.dedup();
    (locks, stated, may_drive)
}

/// Whether an owner was asked to end.
#[derive(Debug, Clone, PartialEq, Eq)]
enum EndRequest {
    /// It was, and may be on its way.
    Ending,
    /// It was, but does nothing until it is continued: waiting for it is no use.
    Suspended,
    /// It was not, and why.
    Not(String),
}

fn ask_to_end(holder: &Holder) -> EndRequest {
    match holder.ask_to_end() {
        Ok(()) if holder.state() == ProcessState::Stopped => EndRequest::Suspended,
        Ok(()) => EndRequest::Ending,
        Err(why) => EndRequest::Not(why),
    }
}
