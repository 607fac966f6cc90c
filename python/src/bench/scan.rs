//! A scan that is iterated over.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};

use camino::Utf8PathBuf;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::operator::ByFunction;
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::manual::held::{HeldBench, Pending};
use isolux_app::scan::{Operator, ScanSummary as Summary, Target};
use isolux_app::{Failure, FailureKind};
use pyo3::prelude::*;

use super::events::{Follower, ScanEvent};
use super::{ScanSummary, ended, forked, raised, unraisable};
use crate::wait::LOOK;

/// Events that a virtual bench is ahead of whoever iterates: it waits in virtual time, a real one waits for nobody.
const AHEAD: usize = 1;

/// A scan that is on: an iterator of its events.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct Scan {
    shared: Arc<Shared>,
    pending: Pending<()>,
    run: String,
    /// A fork has no thread that scans.
    process: u32,
}

/// What the thread of the bench and whoever iterates share.
pub(crate) struct Shared {
    state: Mutex<ScanState>,
    changed: Condvar,
}

#[derive(Default)]
struct ScanState {
    events: VecDeque<ScanEvent>,
    /// The run directory is made: what is wrong from now on is wrong with the scan, not with what was asked for.
    begun: bool,
    /// Nobody iterates any more.
    abandoned: bool,
    outcome: Option<Result<Summary, Failure>>,
}

/// What whoever iterates gets.
enum Next {
    Event(Box<ScanEvent>),
    Ended,
    Nothing,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, ScanState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.state().outcome.is_some()
    }

    /// Adds an event; waits for whoever iterates if `in_step` and `goes_on`.
    fn push(&self, event: ScanEvent, in_step: bool, goes_on: impl Fn() -> bool) {
        let mut state = self.state();
        while in_step && state.begun && state.events.len() >= AHEAD && !state.abandoned && goes_on() {
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        if !state.abandoned {
            state.events.push_back(event);
        }
        self.changed.notify_all();
    }

    fn begin(&self) {
        self.state().begun = true;
        self.changed.notify_all();
    }

    fn end(&self, outcome: Result<Summary, Failure>) {
        self.state().outcome.get_or_insert(outcome);
        self.changed.notify_all();
    }

    /// What it came to, where it has ended: a failure is raised as often as it is asked for.
    fn outcome(&self) -> Option<Result<Summary, Failure>> {
        match self.state().outcome.as_ref()? {
            Ok(summary) => Some(Ok(summary.clone())),
            Err(Failure { kind, message, help }) => Some(Err(Failure {
                kind: *kind,
                message: message.clone(),
                help: help.clone(),
            })),
        }
    }

    fn abandon(&self) {
        let mut state = self.state();
        state.abandoned = true;
        state.events.clear();
        self.changed.notify_all();
    }

    /// The next event, where there is one within [`LOOK`].
    fn next(&self) -> Next {
        let mut state = self.state();
        if state.events.is_empty() && state.outcome.is_none() {
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        match state.events.pop_front() {
            Some(event) => {
                self.changed.notify_all();
                Next::Event(Box::new(event))
            }
            None if state.outcome.is_some() => Next::Ended,
            None => Next::Nothing,
        }
    }

    /// Whether the scan has begun or ended within [`LOOK`].
    fn has_begun(&self) -> bool {
        let mut state = self.state();
        if !state.begun && state.outcome.is_none() {
            let waited = self.changed.wait_timeout(state, LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.begun || state.outcome.is_some()
    }
}

/// Says what a scan says to [`Shared`], and ends it there whatever becomes of the scan.
struct Teller<F> {
    follower: Follower<F>,
    shared: Arc<Shared>,
}

impl<F: Fn(ScanEvent)> Progress for Teller<F> {
    fn event(&self, event: Event<'_>) {
        let begins = matches!(event, Event::Outline(_));
        self.follower.event(event);
        if begins {
            self.shared.begin();
        }
    }
}

impl<F> Drop for Teller<F> {
    fn drop(&mut self) {
        self.shared.end(Err(Failure::instrument(
            "the scan was not carried out: its bench was closed or broke down",
        )));
    }
}

#[pymethods]
impl Scan {
    /// The run directory.
    #[getter]
    fn run(&self) -> &str {
        &self.run
    }

    /// Whether the scan has ended, well or not.
    #[getter]
    fn ended(&self) -> bool {
        self.shared.has_ended()
    }

    /// Waits until the scan has ended, without its events; what it came to.
    fn result(&self, py: Python<'_>) -> PyResult<ScanSummary> {
        while self.next(py)?.is_some() {}
        self.shared
            .outcome()
            .unwrap_or_else(|| Err(Failure::instrument("the scan has no outcome")))
            .map(|summary| ScanSummary::of(&summary, self.run.clone()))
            .map_err(|failure| ended(py, failure))
    }

    /// Ends the scan where it is: what moves is stopped and verified at rest, and `resume=True` goes on later.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.end(py, "close")
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<ScanEvent>> {
        self.next(py)
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_exception))]
    fn __exit__(&self, py: Python<'_>, _exception: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.end(py, "end of the with block")
    }

    fn __repr__(&self) -> String {
        let ended = if self.ended() { ", ended" } else { "" };
        format!("<isolux.Scan into {}{ended}>", self.run)
    }
}

impl Scan {
    /// Asks `bench` for the scan.
    pub(super) fn begin(
        bench: &HeldBench,
        plan: Utf8PathBuf,
        out: Utf8PathBuf,
        (resume, reread): (bool, bool),
        ask: Option<Py<PyAny>>,
    ) -> Self {
        let shared = Arc::new(Shared {
            state: Mutex::default(),
            changed: Condvar::new(),
        });
        let run = out.to_string();
        let in_step = bench.in_memory();
        let of_thread = Arc::clone(&shared);
        let pending = bench.ask(async move |bench, cancel| {
            let control = Control {
                cancel: cancel.clone(),
                ..Control::default()
            };
            let push = |event| of_thread.push(event, in_step, || cancel.reason().is_none());
            let teller = Teller {
                follower: Follower::new(push),
                shared: Arc::clone(&of_thread),
            };
            let target = match (resume, reread) {
                (_, true) => Target::Reread(&out),
                (true, false) => Target::Resume(&out),
                (false, false) => Target::New(&out),
            };
            let operator = ask.map(operator);
            let operator = operator.as_ref().map(|operator| operator as &dyn Operator);
            of_thread.end(bench.scan(&plan, target, operator, &control, &teller).await);
            Ok(())
        });
        Self {
            shared,
            pending,
            run,
            process: std::process::id(),
        }
    }

    pub(super) fn shared(&self) -> Weak<Shared> {
        Arc::downgrade(&self.shared)
    }

    /// Waits until the run directory is made.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn until_begun(&self, py: Python<'_>) -> PyResult<()> {
        while !py.detach(|| self.shared.has_begun()) {
            self.signals(py)?;
        }
        let begun = self.shared.state().begun;
        match self.shared.outcome() {
            Some(Err(failure)) if !begun => Err(ended(py, failure)),
            _ => Ok(()),
        }
    }

    fn next(&self, py: Python<'_>) -> PyResult<Option<ScanEvent>> {
        if self.process != std::process::id() {
            return Err(forked(py));
        }
        loop {
            match py.detach(|| self.shared.next()) {
                Next::Event(event) => return Ok(Some(*event)),
                Next::Nothing => self.signals(py)?,
                Next::Ended => {
                    return match self.shared.outcome() {
                        Some(Err(failure)) => Err(ended(py, failure)),
                        _ => Ok(None),
                    };
                }
            }
        }
    }

    /// What a signal raises, after the scan has ended; an axis that is not verified at rest comes first.
    fn signals(&self, py: Python<'_>) -> PyResult<()> {
        let Err(error) = py.check_signals() else { return Ok(()) };
        if let Err(unverified) = self.end(py, &error.to_string()) {
            unverified.set_context(py, Some(error));
            return Err(unverified);
        }
        Err(error)
    }

    /// Ends the scan and waits until what moves is verified at rest.
    fn end(&self, py: Python<'_>, reason: &str) -> PyResult<()> {
        if self.process != std::process::id() || self.shared.has_ended() {
            return Ok(());
        }
        self.pending.cancel(reason);
        self.shared.abandon();
        while !matches!(py.detach(|| self.shared.next()), Next::Ended) {
            // One Ctrl-C more is not answered: nothing is quicker than the stop that goes on.
            let _ = py.check_signals();
        }
        match self.shared.outcome() {
            Some(Err(failure)) if failure.kind == FailureKind::Instrument => Err(raised(py, failure)),
            _ => Ok(()),
        }
    }
}

impl Drop for Scan {
    fn drop(&mut self) {
        if self.process == std::process::id() && !self.shared.has_ended() {
            Python::attach(|py| unraisable(py, self.end(py, "the iterator was left")));
        }
    }
}

/// The person beside the bench: `ask` is called with the words and returns a name, or nothing if it was not done.
fn operator(ask: Py<PyAny>) -> ByFunction {
    ByFunction::new(move |words| {
        Python::attach(|py| {
            let answer = ask
                .call1(py, (words,))
                .and_then(|answer| answer.extract::<Option<String>>(py));
            match answer {
                Ok(Some(who)) if !who.trim().is_empty() => Ok(who.trim().to_owned()),
                Ok(_) => Err("the answer was empty".to_owned()),
                Err(error) => Err(error.to_string()),
            }
        })
    })
}
