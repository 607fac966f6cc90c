//! Long work on a thread of its own: the interpreter lock is free meanwhile, Ctrl-C is answered at once, and what the
//! work says reaches a function of the caller's.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use isolux_app::Failure;
use isolux_app::front_end::progress::{Event, Progress};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::error::raised;

/// How often signals are looked for.
pub(crate) const LOOK: Duration = Duration::from_millis(20);

/// What a function given as `progress=` gets: the step, units done and in all where they are counted, and a sentence.
pub(crate) type Step = (String, Option<u64>, Option<u64>, String);

enum Message<T> {
    Step(Step),
    Ended(std::thread::Result<Result<T, Failure>>),
}

/// Ends work that its caller no longer waits for.
struct Abandoned;

/// Listens to work: passes events on, and ends the work at the next one after its caller has gone.
pub(crate) struct Listener {
    stop: Arc<AtomicBool>,
    say: Box<dyn Fn(Step) + Send + Sync>,
    current: std::sync::Mutex<Current>,
}

impl Progress for Listener {
    fn event(&self, event: Event<'_>) {
        if self.stop.load(Ordering::Relaxed) {
            // Files are published whole or not at all, so work may end anywhere.
            resume_unwind(Box::new(Abandoned));
        }
        let Ok(mut current) = self.current.lock() else { return };
        if let Some(step) = current.after(event) {
            (self.say)(step);
        }
    }
}

/// The step that work is in, and how many units it has.
#[derive(Default)]
pub(crate) struct Current(String, Option<u64>);

impl Current {
    /// What is said of `event`; none where nothing is.
    pub(crate) fn after(&mut self, event: Event<'_>) -> Option<Step> {
        let (done, sentence) = match event {
            Event::Began { step, total } => {
                *self = Self(step.to_owned(), total);
                (Some(0), String::new())
            }
            Event::At { done, what } => (Some(done), what.to_owned()),
            Event::Ended(sentence) => (self.1, sentence.to_owned()),
            Event::Note(sentence) => (None, sentence.to_owned()),
            Event::Outline(_) | Event::Live(_) => return None,
        };
        Some((self.0.clone(), done, self.1, sentence))
    }
}

/// Runs `work` on a thread of its own and waits for it; `progress` is called with every [`Step`] that it takes.
///
/// # Errors
/// What `work` fails with, what `progress` raises, and what a signal raises (Ctrl-C: `KeyboardInterrupt`, within
/// [`LOOK`]); the work then ends by itself.
pub(crate) fn on_thread<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Listener) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let listener = listener(sender.clone(), Arc::clone(&stop));
    std::thread::Builder::new().name("isolux".to_owned()).spawn(move || {
        let ended = catch_unwind(AssertUnwindSafe(|| work(&listener)));
        // Nobody listens any more where the caller was interrupted.
        let _ = sender.send(Message::Ended(ended));
    })?;
    let result = wait(py, progress, &mut receiver);
    if result.is_err() {
        stop.store(true, Ordering::Relaxed);
    }
    result
}

fn listener<T: Send + 'static>(sender: Sender<Message<T>>, stop: Arc<AtomicBool>) -> Listener {
    Listener {
        stop,
        say: Box::new(move |step| {
            let _ = sender.send(Message::Step(step));
        }),
        current: std::sync::Mutex::default(),
    }
}

fn wait<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    receiver: &mut Receiver<Message<T>>,
) -> PyResult<T> {
    loop {
        let own = &mut *receiver;
        let received = py.detach(move || own.recv_timeout(LOOK));
        py.check_signals()?;
        match received {
            Ok(Message::Step(step)) => {
                if let Some(progress) = progress {
                    progress.call1(step)?;
                }
            }
            Ok(Message::Ended(Ok(result))) => return result.map_err(|failure| raised(py, failure)),
            Ok(Message::Ended(Err(panic))) => return Err(broken(&*panic)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(broken(&"the thread ended without a result")),
        }
    }
}

fn broken(panic: &(dyn Any + Send)) -> PyErr {
    let words = panic.downcast_ref::<&str>().copied();
    let words = words.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    PyRuntimeError::new_err(format!(
        "a fault of isolux itself: {}",
        words.unwrap_or("no reason given")
    ))
}
