//! A bench that stays open from call to call, and its scans.
//!
//! Calls may come from any thread; the steps follow one another. What raises a signal in a call (Ctrl-C) is raised when
//! the axes are verified at rest, not before.

mod events;
mod folder;
mod results;
mod scan;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use camino::Utf8PathBuf;
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::instruments::bench::StationFiles;
use isolux_app::manual::Output;
use isolux_app::manual::held::{self, HeldBench, Pending};
use isolux_app::{Failure, FailureKind};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{bad_input, of_class, raised};
use crate::path::utf8;
use crate::wait::LOOK;
pub(crate) use events::ScanEvent;
use events::Steps;
pub(crate) use folder::begin_folder;
pub(crate) use results::{LuxReading, Position, ScanSummary, SpectrumReading, WarmedUp};
pub(crate) use scan::Scan;
use scan::Shared;

/// The instruments of a station, open from here to `close`, and stopped on every way there.
#[pyclass(frozen, weakref, module = "isolux")]
pub(crate) struct Bench {
    held: Arc<Open>,
    station: Option<String>,
    scan: Mutex<Weak<Shared>>,
}

/// What has to be closed.
struct Open {
    bench: HeldBench,
    closed: AtomicBool,
    /// A fork has the memory of its parent, but neither its thread nor its instruments.
    process: u32,
    notes: Notes,
}

type Notes = Arc<Mutex<Vec<String>>>;

/// What is said while the bench is opened.
struct Noted(Notes);

impl Progress for Noted {
    fn event(&self, event: Event<'_>) {
        if let Event::Note(sentence) = event {
            self.0
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(sentence.to_owned());
        }
    }
}

#[pymethods]
impl Bench {
    /// Opens every instrument of the station file; without one the built-in virtual darkroom in memory. Nothing moves.
    #[new]
    #[pyo3(signature = (station=None, *, force=None))]
    fn new(py: Python<'_>, station: Option<PathBuf>, force: Option<String>) -> PyResult<Self> {
        py.import("isolux._ending")?.call_method0("watch")?;
        let station = station.map(|path| utf8(py, path)).transpose()?;
        let source = match &station {
            Some(file) => StationFiles::load(file),
            None => held::built_in(),
        };
        let source = source.map_err(|failure| raised(py, failure))?;
        let notes = Notes::default();
        let (bench, opened) =
            HeldBench::open(source, force, Noted(Arc::clone(&notes))).map_err(|failure| raised(py, failure))?;
        wait(py, &opened, |_| Ok(()))?;
        let held = Arc::new(Open {
            bench,
            closed: AtomicBool::new(false),
            process: std::process::id(),
            notes,
        });
        every_open().push(Arc::downgrade(&held));
        Ok(Self {
            held,
            station: station.map(Utf8PathBuf::into_string),
            scan: Mutex::default(),
        })
    }

    /// The station file; `None`: the built-in virtual darkroom.
    #[getter]
    fn station(&self) -> Option<&str> {
        self.station.as_deref()
    }

    /// Whether the whole bench is virtual, in virtual time: hours pass in seconds, and none between two calls.
    #[getter]
    fn in_memory(&self) -> bool {
        self.held.bench.in_memory()
    }

    /// Whether it is closed.
    #[getter]
    fn closed(&self) -> bool {
        self.held.closed.load(Ordering::SeqCst)
    }

    /// What was said while it was opened.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.held.notes.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Where the axes stand, read back. Nothing moves.
    #[getter]
    fn position(&self, py: Python<'_>) -> PyResult<Position> {
        let pending = self.idle(py)?.ask(async |bench, cancel| bench.position(cancel).await);
        wait(py, &pending, |_| Ok(())).map(Into::into)
    }

    /// Finds the reference of both axes. Moves them.
    fn home(&self, py: Python<'_>) -> PyResult<Position> {
        let pending = self.idle(py)?.ask(async |bench, cancel| bench.home(cancel).await);
        wait(py, &pending, |_| Ok(())).map(Into::into)
    }

    /// Moves axes and detector and waits until they rest where they were sent; what is not given stays.
    #[pyo3(signature = (c_deg=None, gamma_deg=None, *, distance_mm=None), name = "move")]
    fn move_to(
        &self,
        py: Python<'_>,
        c_deg: Option<f64>,
        gamma_deg: Option<f64>,
        distance_mm: Option<f64>,
    ) -> PyResult<Position> {
        let pending = self
            .idle(py)?
            .ask(async move |bench, cancel| bench.move_to(c_deg, gamma_deg, distance_mm, cancel).await);
        wait(py, &pending, |_| Ok(())).map(Into::into)
    }

    /// Reads the lux meter once, and the power meter with it, with lamp, shutter and baffle as they are.
    fn read(&self, py: Python<'_>) -> PyResult<LuxReading> {
        let pending = self.idle(py)?.ask(async |bench, cancel| bench.read(1, cancel).await);
        let mut readings = wait(py, &pending, |_| Ok(()))?;
        let none = || raised(py, Failure::instrument("luxmeter: no reading"));
        readings.pop().map(Into::into).ok_or_else(none)
    }

    /// Takes one spectrum with the integration time that its light needs.
    fn spectrum(&self, py: Python<'_>) -> PyResult<SpectrumReading> {
        let pending = self.idle(py)?.ask(async |bench, cancel| bench.spectrum(cancel).await);
        wait(py, &pending, |_| Ok(())).map(Into::into)
    }

    /// Switches outputs of the station and reads each back: `True` is lit, open, in the beam, feeding.
    #[pyo3(signature = (*, lamp=None, shutter=None, baffle=None, supply=None))]
    fn switch<'py>(
        &self,
        py: Python<'py>,
        lamp: Option<bool>,
        shutter: Option<bool>,
        baffle: Option<bool>,
        supply: Option<bool>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let outputs: Vec<(Output, bool)> = [
            (Output::Lamp, lamp),
            (Output::Shutter, shutter),
            (Output::Baffle, baffle),
            (Output::Supply, supply),
        ]
        .into_iter()
        .filter_map(|(output, on)| Some((output, on?)))
        .collect();
        let pending = self
            .idle(py)?
            .ask(async move |bench, cancel| bench.switch(&outputs, cancel).await);
        let states = PyDict::new(py);
        for (output, on) in wait(py, &pending, |_| Ok(()))? {
            states.set_item(output.name(), on)?;
        }
        Ok(states)
    }

    /// Switches the lamp on, opens the path, goes to the reference point and waits until the lamp is stable.
    #[pyo3(signature = (progress=None))]
    fn warm_up(&self, py: Python<'_>, progress: Option<&Bound<'_, PyAny>>) -> PyResult<WarmedUp> {
        let (steps, said) = Steps::new();
        let pending = self
            .idle(py)?
            .ask(async move |bench, cancel| bench.warm_up(cancel, &steps).await);
        let warmed_up = wait(py, &pending, |_| said.call(progress));
        said.call(progress)?;
        warmed_up.map(Into::into)
    }

    /// Carries out the plan file into the run directory `out`: an iterator of [`ScanEvent`].
    #[pyo3(signature = (plan, out, *, resume=false, reread=false, ask=None))]
    fn scan(
        &self,
        py: Python<'_>,
        plan: PathBuf,
        out: PathBuf,
        resume: bool,
        reread: bool,
        ask: Option<Py<PyAny>>,
    ) -> PyResult<Scan> {
        let (plan, out) = (utf8(py, plan)?, utf8(py, out)?);
        let bench = self.idle(py)?;
        let scan = Scan::begin(bench, plan, out, (resume, reread), ask);
        *self.scan.lock().unwrap_or_else(PoisonError::into_inner) = scan.shared();
        scan.until_begun(py)?;
        Ok(scan)
    }

    /// Ends whatever other threads do here, stops everything that moves and verifies that it rests; where.
    fn stop(&self, py: Python<'_>) -> PyResult<Position> {
        let bench = self.usable(py)?;
        bench.interrupt("stop");
        let pending = bench.ask(async |bench, cancel| {
            bench.stop().await?;
            bench.position(cancel).await
        });
        wait(py, &pending, |_| Ok(())).map(Into::into)
    }

    /// Stops everything that moves, verifies that it rests, and closes the instruments. A second call does nothing.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        close(py, &self.held, "close")
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        close(py, &self.held, "end of the with block")
    }

    fn __repr__(&self) -> String {
        let station = self.station.as_deref().unwrap_or("virtual darkroom");
        format!(
            "<isolux.Bench {station}{}>",
            if self.closed() { ", closed" } else { "" }
        )
    }
}

impl Bench {
    /// The bench, if it is open.
    fn usable(&self, py: Python<'_>) -> PyResult<&HeldBench> {
        if self.held.process != std::process::id() {
            return Err(forked(py));
        }
        if self.closed() {
            return Err(bad_input(py, "this bench is closed", "open another isolux.Bench"));
        }
        Ok(&self.held.bench)
    }

    /// The bench, if it is open and no scan is on.
    fn idle(&self, py: Python<'_>) -> PyResult<&HeldBench> {
        let bench = self.usable(py)?;
        let scan = self.scan.lock().unwrap_or_else(PoisonError::into_inner).upgrade();
        if scan.is_some_and(|scan| !scan.has_ended()) {
            let message = "a scan is on at this bench";
            let help = "iterate to its end, take its result(), or end it by its close()";
            return Err(bad_input(py, message, help));
        }
        Ok(bench)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !self.closed() {
            Python::attach(|py| unraisable(py, close(py, &self.held, "the bench was discarded")));
        }
    }
}

/// Every bench that may be open.
fn every_open() -> std::sync::MutexGuard<'static, Vec<Weak<Open>>> {
    static OPEN: Mutex<Vec<Weak<Open>>> = Mutex::new(Vec::new());
    let mut every = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    every.retain(|open| open.strong_count() > 0);
    every
}

/// Closes every bench that is open; the first failure.
#[pyfunction]
pub(crate) fn close_benches(py: Python<'_>) -> PyResult<()> {
    let every: Vec<_> = every_open().iter().filter_map(Weak::upgrade).collect();
    let closed: Vec<_> = every.iter().map(|open| close(py, open, "end of the program")).collect();
    closed.into_iter().collect()
}

fn close(py: Python<'_>, open: &Open, reason: &str) -> PyResult<()> {
    if open.process != std::process::id() || open.closed.swap(true, Ordering::SeqCst) {
        return Ok(());
    }
    wait(py, &open.bench.close(reason), |_| Ok(()))
}

/// Waits for a step with the interpreter free; `meanwhile` is called again and again.
///
/// # Errors
/// What the step fails with. What a signal or `meanwhile` raises, after the step has ended and what moves was verified
/// at rest; where that failed, the failure, with what was raised as its context.
fn wait<T: Send>(
    py: Python<'_>,
    pending: &Pending<T>,
    mut meanwhile: impl FnMut(Python<'_>) -> PyResult<()>,
) -> PyResult<T> {
    let mut asked: Option<PyErr> = None;
    loop {
        let outcome = py.detach(|| pending.wait(LOOK));
        let raised_now = py.check_signals().and_then(|()| meanwhile(py)).err();
        if asked.is_none()
            && let Some(error) = raised_now
        {
            pending.cancel(&error.to_string());
            asked = Some(error);
        }
        return match (outcome, asked) {
            (None, still) => {
                asked = still;
                continue;
            }
            (Some(Ok(value)), None) => Ok(value),
            (Some(Ok(_)), Some(error)) => Err(error),
            (Some(Err(failure)), None) => Err(ended(py, failure)),
            (Some(Err(failure)), Some(error)) if failure.kind == FailureKind::Interrupted => Err(error),
            (Some(Err(failure)), Some(error)) => {
                let unverified = raised(py, failure);
                unverified.set_context(py, Some(error));
                Err(unverified)
            }
        };
    }
}

/// The exception of a step that failed, or that somebody else ended.
fn ended(py: Python<'_>, failure: Failure) -> PyErr {
    if failure.kind != FailureKind::Interrupted {
        return raised(py, failure);
    }
    of_class(py, "Interrupted", failure)
}

/// The thread and the instruments of a bench belong to the process that opened it.
fn forked(py: Python<'_>) -> PyErr {
    let message = "this bench belongs to the process that was forked";
    bad_input(py, message, "open one in the process that uses it")
}

/// What nobody can catch is shown, as Python shows what a finaliser raises.
fn unraisable(py: Python<'_>, outcome: PyResult<()>) {
    if let Err(error) = outcome {
        error.write_unraisable(py, None);
    }
}
