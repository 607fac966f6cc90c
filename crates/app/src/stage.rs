//! Where a bench plays: real links and real time, or the built-in virtual darkroom and a clock that runs as fast as it can.

use std::future::Future;
use std::io::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Once};

use camino::Utf8Path;
use isolux_darkroom::Darkroom;
use isolux_record::Station;
use isolux_scan::Cancel;
use isolux_transport::{Links, Recorder, SystemLinks};
use isolux_virtual::{BUILT_IN, Serving, VirtualRoom};

use crate::{Failure, FailureKind, capture};

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
    _serving: Option<Serving>,
}

impl Stage {
    /// Links of the machine, and in memory those of the built-in darkroom if `in_memory`.
    ///
    /// # Errors
    /// Never for the built-in darkroom as it is shipped.
    pub fn open(in_memory: bool) -> Result<Self, Failure> {
        if in_memory {
            return Self::in_room(Darkroom::parse(BUILT_IN).map_err(Failure::bad_input)?);
        }
        Ok(Self {
            links: Arc::new(SystemLinks::default()),
            room: None,
            _serving: None,
        })
    }

    /// Links for `station`, which stands in `file`: those of the machine, and in memory those of the darkroom that the station
    /// names or of the built-in one. Must be called on the runtime.
    ///
    /// # Errors
    /// Bad input (exit 2) with file and line of the darkroom.
    pub fn of(station: &Station, file: &Utf8Path) -> Result<Self, Failure> {
        match station.darkroom() {
            None => Self::open(is_virtual(station)),
            Some(_) if !is_virtual(station) => Err(Failure::bad_input(format!(
                "{file}: `darkroom` is the room behind memory: links, and this station has others"
            ))
            .help("remove the key, or write a station by `isolux virtual darkroom --in-memory --station-out FILE`")),
            Some(darkroom) => {
                let darkroom = file.parent().unwrap_or(Utf8Path::new("")).join(darkroom);
                Self::in_room(capture::document(&darkroom)?)
            }
        }
    }

    /// As [`of`](Self::of), with every byte on the links written to `trace`.
    ///
    /// # Errors
    /// Exit 3 when the trace cannot be written.
    pub fn recording(station: &Station, file: &Utf8Path, trace: Option<&Utf8Path>) -> Result<Self, Failure> {
        let mut stage = Self::of(station, file)?;
        if let Some(path) = trace {
            let failed = |error: std::io::Error| Failure::instrument(format!("{path}: cannot write: {error}"));
            let file = std::fs::File::create(path).map_err(failed)?;
            stage.links = Arc::new(Recorder::new(stage.links.clone(), Box::new(file)).map_err(failed)?);
        }
        Ok(stage)
    }

    /// In-memory links of the darkroom `document`. Must be called on the runtime.
    ///
    /// # Errors
    /// Exit 3 when the twins cannot listen.
    pub fn in_room(document: Darkroom) -> Result<Self, Failure> {
        let links = SystemLinks::default();
        let room = VirtualRoom::open(document);
        let serving = room.listen(&links.memory).map_err(Failure::instrument)?;
        Ok(Self {
            links: Arc::new(links),
            room: Some(room),
            _serving: Some(serving),
        })
    }
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
    AXES_IN_USE.fetch_add(1, Ordering::SeqCst);
    let outcome = runtime.block_on(work);
    AXES_IN_USE.fetch_sub(1, Ordering::SeqCst);
    end_on_signals();
    outcome
}

/// Scans and steps by hand that are under way: they stop the axes themselves when a signal comes.
static AXES_IN_USE: AtomicUsize = AtomicUsize::new(0);

/// Once a runtime has listened for signals the system no longer ends the program on them. What is computed after a scan can
/// be ended at any time, for every file is written whole or not at all; so this does in the system's place.
fn end_on_signals() {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        std::thread::spawn(|| {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let Ok(runtime) = runtime else { return };
            runtime.block_on(async {
                loop {
                    if !signalled().await {
                        return;
                    }
                    if AXES_IN_USE.load(Ordering::SeqCst) == 0 {
                        // The front end is in the middle of a computation and cannot say it.
                        let _ = writeln!(
                            std::io::stderr(),
                            "isolux: interrupted; what was written until now is whole"
                        );
                        std::process::exit(i32::from(FailureKind::Interrupted.exit_code()));
                    }
                }
            });
        });
    });
}

/// Waits for SIGINT or SIGTERM; false where the system refuses.
async fn signalled() -> bool {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (Ok(mut interrupt), Ok(mut terminate)) = (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
        else {
            return false;
        };
        tokio::select! {
            came = interrupt.recv() => came.is_some(),
            came = terminate.recv() => came.is_some(),
        }
    }
    #[cfg(not(unix))]
    {
        tokio::signal::ctrl_c().await.is_ok()
    }
}

/// A handle that SIGINT and SIGTERM use. Must be called on the runtime.
///
/// # Errors
/// Exit 3 when the system refuses the signal handlers: a bench that cannot be interrupted is not started.
pub fn on_signals() -> Result<Cancel, Failure> {
    let cancel = Cancel::new();
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        for (kind, name) in [
            (SignalKind::interrupt(), "SIGINT"),
            (SignalKind::terminate(), "SIGTERM"),
        ] {
            let mut signals = signal(kind).map_err(Failure::instrument)?;
            let cancel = cancel.clone();
            tokio::spawn(async move {
                if signals.recv().await.is_some() {
                    cancel.cancel(name);
                }
            });
        }
    }
    #[cfg(not(unix))]
    {
        let cancel = cancel.clone();
        tokio::spawn(async move {
            if tokio::signal::ctrl_c().await.is_ok() {
                cancel.cancel("Ctrl-C");
            }
        });
    }
    Ok(cancel)
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
