//! What a scan says while it works, as objects of Python.

use std::cell::RefCell;
use std::sync::mpsc::{Receiver, Sender, channel};

use isolux_app::front_end::live::{self, Live, Reading, Remaining, State};
use isolux_app::front_end::progress::{Event, Progress};
use pyo3::prelude::*;

use crate::document::to_python;
use crate::wait::{Current, Step};

/// Something that happened in a scan, and how far it is.
#[pyclass(frozen, module = "isolux")]
pub(crate) struct ScanEvent {
    live: Live,
    state: Option<State>,
    sentence: Option<String>,
    /// As of the last event that changed it.
    left: Option<Remaining>,
}

#[pymethods]
impl ScanEvent {
    /// What happened: `began`, `homed`, `lamp`, `warm_up`, `stable`, `block`, `reading`, `spectrum`, `sweep`, `note`,
    /// `stopped`, …: the names of events.jsonl.
    #[getter]
    fn kind<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.facts(py)?.get_item("event")
    }

    /// When, UTC, RFC 3339, by the clock of the bench.
    #[getter]
    fn time_utc(&self) -> &str {
        &self.live.logged.time_utc
    }

    /// What the bench does: `homing`, `warming_up`, `scanning`, `paused`, `resuming`, `completed`, `interrupted`,
    /// `failed`; `None` before the first of them.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.state)
    }

    /// It in words, where there are any.
    #[getter]
    fn sentence(&self) -> Option<&str> {
        self.sentence.as_deref()
    }

    /// Points of the plan that are done.
    #[getter]
    fn done(&self) -> u64 {
        self.left.as_ref().map_or(0, |left| left.done)
    }

    /// Points of the plan.
    #[getter]
    fn total(&self) -> u64 {
        self.left.as_ref().map_or(0, |left| left.total)
    }

    /// Estimated time that is left in s of the bench's clock, where it is known.
    #[getter]
    fn remaining_s(&self) -> Option<f64> {
        let left = self.left.as_ref()?;
        left.left_s.is_finite().then_some(left.left_s)
    }

    /// Of a reading: C in degrees, read back.
    #[getter]
    fn c_deg(&self) -> Option<f64> {
        self.of_reading(|reading| reading.c_deg)
    }

    /// Of a reading: γ in degrees, signed, read back.
    #[getter]
    fn gamma_deg(&self) -> Option<f64> {
        self.of_reading(|reading| reading.gamma_deg)
    }

    /// Of a reading: illuminance in lx; `None` where it has no number, and `quality` says why.
    #[getter]
    fn illuminance_lx(&self) -> Option<f64> {
        self.of_reading(|reading| reading.illuminance_lx)?
    }

    /// Of a reading: `ok`, `over_range`, `under_range`, `unsteady`, …
    #[getter]
    fn quality(&self) -> Option<String> {
        self.of_reading(|reading| reading.quality.to_string())
    }

    /// Everything that is known of it, as in events.jsonl; of a reading its row of readings.csv.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.live)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (kind, words) = (self.kind(py)?, self.sentence.as_deref().unwrap_or_default());
        Ok(format!(
            "<isolux.ScanEvent {kind} {}/{} {words}>",
            self.done(),
            self.total()
        ))
    }
}

impl ScanEvent {
    fn of_reading<T>(&self, of: impl FnOnce(&Reading) -> T) -> Option<T> {
        match &self.live.logged.event {
            live::Event::Reading(reading) => Some(of(reading)),
            _ => None,
        }
    }
}

/// Makes [`ScanEvent`]s of what a scan says: its events, each with the words that follow it.
pub(crate) struct Follower<F> {
    push: F,
    so_far: RefCell<SoFar>,
}

#[derive(Default)]
struct SoFar {
    /// Waits for its words.
    open: Option<ScanEvent>,
    state: Option<State>,
    left: Option<Remaining>,
    /// The last words, which come once as an event and once for a terminal.
    words: Option<String>,
}

impl<F: Fn(ScanEvent)> Follower<F> {
    /// Hands every event to `push`.
    pub(crate) fn new(push: F) -> Self {
        Self {
            push,
            so_far: RefCell::default(),
        }
    }

    fn flush(&self, so_far: &mut SoFar) {
        if let Some(event) = so_far.open.take() {
            (self.push)(event);
        }
    }

    fn live(&self, live: &Live) {
        let mut so_far = self.so_far.borrow_mut();
        self.flush(&mut so_far);
        so_far.state = live.state.or(so_far.state);
        so_far.left = live.left.clone().or_else(|| so_far.left.take());
        let is_note = matches!(live.logged.event, live::Event::Note { .. });
        if is_note && live.sentence == so_far.words {
            return;
        }
        so_far.words.clone_from(&live.sentence);
        let event = ScanEvent {
            live: live.clone(),
            state: so_far.state,
            sentence: live.sentence.clone(),
            left: so_far.left.clone(),
        };
        let has_words_to_come = matches!(live.logged.event, live::Event::Reading(_) | live::Event::WarmUp(_));
        if has_words_to_come && live.sentence.is_none() {
            so_far.open = Some(event);
        } else {
            (self.push)(event);
        }
    }

    fn words(&self, what: &str) {
        let mut so_far = self.so_far.borrow_mut();
        if let Some(event) = &mut so_far.open {
            event.sentence = Some(what.to_owned());
            self.flush(&mut so_far);
        }
    }

    fn total(&self, total: u64) {
        self.so_far.borrow_mut().left = Some(Remaining {
            done: 0,
            total,
            left_s: f64::NAN,
            ends_utc: String::new(),
        });
    }
}

impl<F: Fn(ScanEvent)> Progress for Follower<F> {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Outline(outline) => self.total(outline.points.len() as u64),
            Event::Live(live) => self.live(live),
            Event::At { what, .. } => self.words(what),
            Event::Note(sentence) => self.live(&Live::now(None, sentence)),
            Event::Began { .. } | Event::Ended(_) => {}
        }
    }
}

/// Says the steps of a use case to a function of Python that waits for it.
pub(crate) struct Steps {
    say: Sender<Step>,
    current: RefCell<Current>,
}

/// What was said and not yet called.
pub(crate) struct Said(Receiver<Step>);

impl Steps {
    pub(crate) fn new() -> (Self, Said) {
        let (say, said) = channel();
        let current = RefCell::default();
        (Self { say, current }, Said(said))
    }
}

impl Progress for Steps {
    fn event(&self, event: Event<'_>) {
        if let Some(step) = self.current.borrow_mut().after(event) {
            // Nobody may listen any more.
            let _ = self.say.send(step);
        }
    }
}

impl Said {
    /// Calls `progress` with every step since the last call.
    pub(crate) fn call(&self, progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        for step in self.0.try_iter() {
            if let Some(progress) = progress {
                progress.call1(step)?;
            }
        }
        Ok(())
    }
}
