//! A bench that stays open from step to step, on a thread of its own, for a front end that is a program of somebody
//! else: its threads ask for steps and wait for them, and none of them drives a runtime.
//!
//! Steps follow one another in the order in which they were asked for. Between two of them nothing moves; virtual time
//! stands still then, and what a real bench needs (signs of life of its owner) goes on.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use isolux_scan::Cancel;
use isolux_virtual::twins::Choice;
use tokio::runtime::Runtime;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use super::open::OpenBench;
use crate::front_end::progress::Progress;
use crate::init::virtual_station;
use crate::instruments::bench::StationFiles;
use crate::instruments::{roles, session};
use crate::{Failure, FailureKind};

/// The stack of the thread: a scan needs that of a main thread.
const STACK_BYTES: usize = 8 << 20;

type Step = Box<dyn FnOnce(&Runtime, &mut OpenBench) + Send>;

enum Request {
    Step(Step),
    Close(SyncSender<Result<(), Failure>>),
}

/// A bench that is open, and the way to its thread.
pub struct HeldBench {
    requests: UnboundedSender<Request>,
    waiting: Waiting,
    in_memory: bool,
}

/// What can end each step that was asked for and has not ended, in their order.
type Waiting = Arc<Mutex<VecDeque<Cancel>>>;

fn locked(waiting: &Waiting) -> MutexGuard<'_, VecDeque<Cancel>> {
    waiting.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A step that was asked for.
pub struct Pending<T> {
    answer: Mutex<Receiver<Result<T, Failure>>>,
    cancel: Cancel,
}

impl<T> Pending<T> {
    fn new(answer: Receiver<Result<T, Failure>>, cancel: Cancel) -> Self {
        let answer = Mutex::new(answer);
        Self { answer, cancel }
    }

    /// Its outcome, where it has one within `patience`.
    pub fn wait(&self, patience: Duration) -> Option<Result<T, Failure>> {
        let answer = self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        match answer.recv_timeout(patience) {
            Ok(outcome) => Some(outcome),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => Some(Err(Failure::instrument(
                "a fault of isolux itself: the thread of the bench gave no answer; the axes were stopped",
            ))),
        }
    }

    /// Asks for its end: the axes are stopped and verified at rest, then [`wait`](Self::wait) has its outcome.
    pub fn cancel(&self, reason: &str) {
        self.cancel.cancel(reason);
    }
}

/// The built-in virtual darkroom, which is no file.
///
/// # Errors
/// Never for the darkroom as it is shipped.
pub fn built_in() -> Result<StationFiles, Failure> {
    let (station, calibration) = virtual_station(&Choice::default())?;
    StationFiles::from_text(&station, calibration.as_deref())
}

impl HeldBench {
    /// Opens the bench of `source` on a thread of its own. `force` is the reason for which the instruments may be taken
    /// over from a process that does not answer. The bench counts when [`Pending::wait`] says that it is open.
    ///
    /// # Errors
    /// Exit 3 when the system gives no thread; the answer has those of [`OpenBench::open`].
    pub fn open(
        source: StationFiles,
        force: Option<String>,
        progress: impl Progress + Send + 'static,
    ) -> Result<(Self, Pending<()>), Failure> {
        let (requests, asked) = unbounded_channel();
        let (answer, opened) = sync_channel(1);
        let (cancel, waiting) = (Cancel::new(), Waiting::default());
        let held = Self {
            requests,
            waiting: Arc::clone(&waiting),
            in_memory: roles::is_virtual(&source.station),
        };
        let ended = cancel.clone();
        let work = move || hold(source, force.as_deref(), &progress, &ended, &answer, asked, &waiting);
        let thread = std::thread::Builder::new().name("isolux bench".to_owned());
        thread
            .stack_size(STACK_BYTES)
            .spawn(work)
            .map_err(Failure::instrument)?;
        Ok((held, Pending::new(opened, cancel)))
    }

    /// Whether the whole bench is the virtual darkroom in memory, in virtual time.
    pub const fn in_memory(&self) -> bool {
        self.in_memory
    }

    /// Asks for a step.
    pub fn ask<T: Send + 'static>(
        &self,
        step: impl AsyncFnOnce(&mut OpenBench, &Cancel) -> Result<T, Failure> + Send + 'static,
    ) -> Pending<T> {
        let cancel = Cancel::new();
        let (answer, outcome) = sync_channel(1);
        let ended = cancel.clone();
        let work = move |runtime: &Runtime, bench: &mut OpenBench| {
            // Whoever asked may have gone.
            let _ = answer.send(runtime.block_on(step(bench, &ended)));
        };
        // Under one lock, so that both have one order.
        let mut waiting = locked(&self.waiting);
        waiting.push_back(cancel.clone());
        if self.requests.send(Request::Step(Box::new(work))).is_err() {
            waiting.pop_back();
        }
        Pending::new(outcome, cancel)
    }

    /// Asks every step that was asked for to end: what moves is stopped and verified at rest.
    pub fn interrupt(&self, reason: &str) {
        locked(&self.waiting).iter().for_each(|cancel| cancel.cancel(reason));
    }

    /// Interrupts all steps, stops what moves, verifies that it rests, and closes the instruments.
    pub fn close(&self, reason: &str) -> Pending<()> {
        let (answer, closed) = sync_channel(1);
        self.interrupt(reason);
        // A thread that has ended closes nothing, and the answer says so.
        let _ = self.requests.send(Request::Close(answer));
        Pending::new(closed, Cancel::new())
    }
}

/// The thread: opens the bench and does what is asked until it is closed, or nobody can ask any more.
fn hold(
    source: StationFiles,
    force: Option<&str>,
    progress: &dyn Progress,
    ended: &Cancel,
    opened: &SyncSender<Result<(), Failure>>,
    mut asked: UnboundedReceiver<Request>,
    waiting: &Waiting,
) {
    let in_memory = roles::is_virtual(&source.station);
    let open = session::runtime(in_memory).and_then(|runtime| {
        let bench = runtime.block_on(async {
            tokio::select! {
                biased;
                reason = ended.cancelled() => Err(interrupted(&reason)),
                opened = OpenBench::open(source, force, progress) => opened,
            }
        })?;
        Ok((runtime, bench))
    });
    let (runtime, mut bench) = match open {
        Ok(open) => open,
        Err(failure) => {
            let _ = opened.send(Err(failure));
            return;
        }
    };
    let _ = opened.send(Ok(()));
    let answer = loop {
        // A runtime that nobody drives keeps virtual time standing still.
        let request = if in_memory {
            asked.blocking_recv()
        } else {
            runtime.block_on(asked.recv())
        };
        match request {
            Some(Request::Step(step)) => {
                if catch_unwind(AssertUnwindSafe(|| step(&runtime, &mut bench))).is_err() {
                    // Whoever asked gets no answer. Closing verifies the axes again, and says so if they do not rest.
                    let _ = runtime.block_on(bench.stop());
                }
                locked(waiting).pop_front();
            }
            Some(Request::Close(answer)) => break Some(answer),
            None => break None,
        }
    };
    let stopped = runtime.block_on(async move {
        let stopped = bench.stop().await;
        drop(bench);
        stopped
    });
    // Links and locks are free when whoever closes the bench gets the answer.
    drop(runtime);
    if let Some(answer) = answer {
        let _ = answer.send(stopped);
    }
}

fn interrupted(reason: &str) -> Failure {
    Failure {
        kind: FailureKind::Interrupted,
        message: format!("interrupted ({reason}) before anything moved"),
        help: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front_end::progress::Silent;

    const PATIENCE: Duration = Duration::from_mins(1);

    fn open() -> HeldBench {
        let (bench, opened) = HeldBench::open(built_in().unwrap(), None, Silent).unwrap();
        opened.wait(PATIENCE).unwrap().unwrap();
        bench
    }

    fn done<T>(pending: &Pending<T>) -> Result<T, Failure> {
        pending.wait(PATIENCE).unwrap()
    }

    #[test]
    fn steps_follow_one_another_and_virtual_time_passes_in_them_alone() {
        let bench = open();
        let homed = bench.ask(async |bench, cancel| bench.home(cancel).await);
        let moved = bench.ask(async |bench, cancel| bench.move_to(None, Some(30.0), None, cancel).await);
        assert!((done(&moved).unwrap().gamma_deg - 30.0).abs() < 0.01 && done(&homed).is_ok());
        let now = || done(&bench.ask(async |_, _| Ok(tokio::time::Instant::now()))).unwrap();
        let before = now();
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(before, now());
        done(&bench.close("test")).unwrap();
    }

    #[test]
    fn a_step_that_is_cancelled_or_panics_leaves_the_bench_to_the_next() {
        let bench = open();
        let cancelled = bench.ask(async |bench, cancel| {
            cancel.cancel("test");
            bench.home(cancel).await
        });
        assert_eq!(done(&cancelled).unwrap_err().kind, FailureKind::Interrupted);
        let broken = bench.ask(async |_, _| -> Result<(), Failure> { panic!("a fault that this test makes") });
        assert!(done(&broken).unwrap_err().message.contains("fault of isolux itself"));
        done(&bench.ask(async |bench, cancel| bench.home(cancel).await)).unwrap();
    }

    #[test]
    fn closing_ends_every_step_that_was_asked_for_and_then_none_is_done() {
        let bench = open();
        let waits = |bench: &HeldBench| {
            bench.ask(async |_, cancel| {
                let reason = cancel.cancelled().await;
                Ok(reason)
            })
        };
        let (first, second) = (waits(&bench), waits(&bench));
        done(&bench.close("test")).unwrap();
        assert_eq!(
            (done(&first).unwrap(), done(&second).unwrap()),
            ("test".to_owned(), "test".to_owned())
        );
        assert!(done(&waits(&bench)).is_err());
    }
}
