//! The days themselves: scanned and captured by the functions behind `isolux scan`, `reduce` and `virtual capture`.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::darkroom::capture::{self, CaptureUnit, Series};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::run::reduce;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_app::{Failure, init};
use isolux_darkroom::{Darkroom, Room};
use isolux_record::Plan;
use isolux_record::observation::{MapSet, Need, Observations, open};
use isolux_virtual::station::{calibration, in_memory, station};
use isolux_virtual::twins::Choice;

use crate::lamps::Lamp;
use crate::plans::{self, Grid};

/// Bins along a side of a map.
pub const BINS: usize = 24;

/// Noise of first days and of days without a fault whose readings are not looked at; those of cases begin above.
const OTHER_DAY: u64 = 1_000_000;

/// Days that many cases share, each made when it is first asked for.
pub struct Days {
    root: Utf8PathBuf,
    first: Made<(Lamp, u64), Utf8PathBuf>,
    readings: Made<(Lamp, Grid, bool), Observations>,
    maps: Made<(Lamp, u64), MapSet>,
}

/// Values that are made once, whoever asks first; others wait.
type Made<Key, Value> = Mutex<HashMap<Key, Arc<OnceLock<Result<Arc<Value>, DayError>>>>>;

/// Why there is no such day: what the use case said that failed.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{0}")]
pub struct DayError(pub String);

impl From<Failure> for DayError {
    fn from(failure: Failure) -> Self {
        Self(failure.message)
    }
}

impl Days {
    /// Days whose files lie below `root`.
    pub fn below(root: &Utf8Path) -> Self {
        Self {
            root: root.to_owned(),
            first: Made::default(),
            readings: Made::default(),
            maps: Made::default(),
        }
    }

    /// The model that the first day made of lamp number `seed` of a kind.
    ///
    /// # Errors
    /// As scan and reduction.
    pub fn model(&self, lamp: Lamp, seed: u64) -> Result<Arc<Utf8PathBuf>, DayError> {
        made(&self.first, (lamp, seed), || {
            let folder = self.root.join(format!("first-{}-{seed}", lamp.name()));
            let room = lamp.room(seed, OTHER_DAY + seed);
            scan_in(&room, &room, &plans::first_day()?, false, &folder)?;
            let reduced = reduce::run(&folder, &reduce::ReduceRequest::default(), Overwrite::Never)?;
            Ok(reduced.folder.join("luminaire.model.toml"))
        })
    }

    /// A second scan without a fault: where and when it reads, and how well.
    ///
    /// # Errors
    /// As the scan.
    pub fn readings(&self, lamp: Lamp, grid: Grid, hasty: bool) -> Result<Arc<Observations>, DayError> {
        made(&self.readings, (lamp, grid, hasty), || {
            let name = format!("second-{}-{}-{hasty}", lamp.name(), grid.name());
            let folder = self.root.join(name);
            let room = lamp.room(1, OTHER_DAY);
            second_scan(&room, &room, grid, hasty, &folder)?;
            open(&folder, Need::Values).map_err(Failure::bad_input)
        })
    }

    /// The maps of the second day without a fault.
    ///
    /// # Errors
    /// As the capture.
    pub fn maps(&self, lamp: Lamp, seed: u64) -> Result<Arc<MapSet>, DayError> {
        made(&self.maps, (lamp, seed), || {
            let folder = self.root.join(format!("maps-{}-{seed}", lamp.name()));
            let file = second_maps(&lamp.room(seed, OTHER_DAY), &folder)?;
            MapSet::open(&file, Need::Values).map_err(Failure::bad_input)
        })
    }
}

fn made<Key: Eq + Hash, Value>(
    all: &Made<Key, Value>,
    key: Key,
    make: impl FnOnce() -> Result<Value, Failure>,
) -> Result<Arc<Value>, DayError> {
    let cell = Arc::clone(
        all.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .entry(key)
            .or_default(),
    );
    cell.get_or_init(|| Ok(Arc::new(make()?))).clone()
}

/// Scans the plan of a second day into the run directory `folder`, in `room`; the station is that of the room `known`.
///
/// # Errors
/// As the scan: a lamp that never becomes stable, a reading that cannot be.
pub fn second_scan(
    room: &Darkroom,
    known: &Darkroom,
    grid: Grid,
    hasty: bool,
    folder: &Utf8Path,
) -> Result<(), Failure> {
    scan_in(room, known, &grid.plan()?, hasty, folder)
}

/// Scans the plan of a second day with a spectrum into the run directory `folder`, in `room`, and reduces it; the station
/// is that of the room `known`. Gives the file of the spectrum.
///
/// # Errors
/// As scan and reduction.
pub fn second_spectrum(room: &Darkroom, known: &Darkroom, folder: &Utf8Path) -> Result<Utf8PathBuf, DayError> {
    scan_in(room, known, &plans::with_spectrum()?, false, folder)?;
    let reduced = reduce::run(folder, &reduce::ReduceRequest::default(), Overwrite::Never)?;
    Ok(reduced.folder.join("spectrum.toml"))
}

/// The criterion of a bench on which nobody waits until the lamp is warm.
const HASTY: &str = "\n[lamp.stable]\nleast_s = 300.0\nwindow_s = 60.0\nspread_rel = 0.2\n";

fn scan_in(room: &Darkroom, known: &Darkroom, plan: &Plan, hasty: bool, folder: &Utf8Path) -> Result<(), Failure> {
    let choice = Choice::default();
    let outlets = in_memory(&choice);
    let criterion = if hasty { HASTY } else { "" };
    let text = station(known, &outlets) + criterion;
    let source = StationFiles::from_text(&text, calibration(&Room::new(known.clone()), &outlets).as_deref())?;
    session::run(true, async {
        let session = Session::in_room(room.clone(), &choice)?;
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = jiff::Timestamp::UNIX_EPOCH;
        let job = ScanJob {
            source: &source,
            plan,
            place: Place::take(Target::New(folder), false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        Box::pin(job.execute_on(&mut devices, None, now)).await
    })?;
    Ok(())
}

/// Captures the maps of a second day in `room` into `folder`: those of `virtual capture --designed` for the scene of
/// `isolux init`. Gives their file.
///
/// # Errors
/// As the capture.
pub fn second_maps(room: &Darkroom, folder: &Utf8Path) -> Result<Utf8PathBuf, Failure> {
    let [darkroom, scene, maps] = ["darkroom.toml", "scene.toml", "maps.toml"].map(|name| folder.join(name));
    let text = toml::to_string(room).map_err(Failure::bad_input)?;
    for (file, text) in [(&darkroom, text.as_str()), (&scene, init::SCENE)] {
        isolux_app::files::write(file, text.as_bytes(), Overwrite::Never)?;
    }
    let options = capture::Options {
        unit: CaptureUnit::Relative,
        bins: Some([BINS, BINS]),
        series: Series::Designed,
        exposure: 1.0,
        overwrite: Overwrite::Never,
    };
    capture::capture(&darkroom, &scene, &maps, &options, &Silent)?;
    Ok(maps)
}
