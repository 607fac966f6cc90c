//! Signals that ask the program to end: SIGINT, SIGTERM, and SIGHUP and SIGQUIT of a terminal that is closed; on
//! Windows Ctrl-C, Ctrl-Break, and what is sent before a window is closed or a session ends. Here alone.
//!
//! While something runs that has axes to stop, a signal is its affair ([`OnSignals`]). At all other times the program
//! ends at once, for every file is written completely or not at all.

use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError, mpsc};

use isolux_scan::Cancel;

use crate::Failure;

/// What is asked to end by a signal instead of the whole program, until this is dropped.
#[derive(Debug)]
pub struct OnSignals {
    number: u64,
    cancel: Cancel,
}

impl OnSignals {
    /// From now on, signals go to this handle.
    ///
    /// # Errors
    /// Exit 3 when the system refuses the signal handlers: a bench that cannot be interrupted is not started.
    pub fn listen() -> Result<Self, Failure> {
        Self::ending(&Cancel::new())
    }

    /// From now on, signals go to `cancel`.
    ///
    /// # Errors
    /// As [`listen`](Self::listen).
    pub fn ending(cancel: &Cancel) -> Result<Self, Failure> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        watch()?;
        let listener = Self {
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            cancel: cancel.clone(),
        };
        listeners().push((listener.number, listener.cancel.clone()));
        Ok(listener)
    }

    /// Gives `outcome` back. After a failure the signals stay with this handle until the program ends: it is about to
    /// report what failed, which may be an axis that is not at rest, and a signal must not take the place of that.
    ///
    /// # Errors
    /// Those of `outcome`.
    pub fn until_reported<T>(self, outcome: Result<T, Failure>) -> Result<T, Failure> {
        if outcome.is_err() {
            std::mem::forget(self);
        }
        outcome
    }
}

impl Deref for OnSignals {
    type Target = Cancel;

    fn deref(&self) -> &Cancel {
        &self.cancel
    }
}

impl Drop for OnSignals {
    fn drop(&mut self) {
        listeners().retain(|(number, _)| *number != self.number);
    }
}

fn listeners() -> MutexGuard<'static, Vec<(u64, Cancel)>> {
    static LISTENERS: Mutex<Vec<(u64, Cancel)>> = Mutex::new(Vec::new());
    LISTENERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts the thread that receives the signals, once. It has a runtime of its own: that of a scan may be busy, and
/// ends.
fn watch() -> Result<(), Failure> {
    static WATCH: OnceLock<Result<(), String>> = OnceLock::new();
    let watched = WATCH.get_or_init(|| {
        let (ready, wait) = mpsc::channel();
        std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            match runtime {
                Ok(runtime) => runtime.block_on(receive(&ready)),
                Err(error) => {
                    let _ = ready.send(Err(error.to_string()));
                }
            }
        });
        wait.recv()
            .unwrap_or_else(|_| Err("the thread for signals ended".to_owned()))
    });
    watched
        .clone()
        .map_err(|error| Failure::instrument(format!("cannot listen for signals: {error}")))
}

/// Listens for ever; says on `ready` when it does.
#[cfg(unix)]
async fn receive(ready: &mpsc::Sender<Result<(), String>>) {
    use tokio::signal::unix::{SignalKind, signal};
    let mut all = vec![
        (SignalKind::interrupt(), "SIGINT"),
        (SignalKind::terminate(), "SIGTERM"),
        (SignalKind::quit(), "SIGQUIT"),
    ];
    if !hangup_is_ignored() {
        all.push((SignalKind::hangup(), "SIGHUP"));
    }
    for (kind, name) in all {
        match signal(kind) {
            Ok(mut signals) => {
                tokio::spawn(async move {
                    while signals.recv().await.is_some() {
                        received(name);
                    }
                });
            }
            Err(error) => {
                let _ = ready.send(Err(error.to_string()));
                return;
            }
        }
    }
    let _ = ready.send(Ok(()));
    std::future::pending::<()>().await;
}

/// Listens for ever; says on `ready` when it does. Where a window is closed, a session ends or the computer shuts down,
/// Windows ends the process a few seconds later (`HandlerRoutine`): the axes are stopped at once.
#[cfg(windows)]
async fn receive(ready: &mpsc::Sender<Result<(), String>>) {
    use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_logoff, ctrl_shutdown};
    let all = (|| {
        Ok::<_, std::io::Error>((
            ctrl_c()?,
            ctrl_break()?,
            ctrl_close()?,
            ctrl_logoff()?,
            ctrl_shutdown()?,
        ))
    })();
    let (mut interrupt, mut stop, mut close, mut logoff, mut shutdown) = match all {
        Ok(all) => all,
        Err(error) => {
            let _ = ready.send(Err(error.to_string()));
            return;
        }
    };
    let _ = ready.send(Ok(()));
    loop {
        let name = tokio::select! {
            Some(()) = interrupt.recv() => "Ctrl-C",
            Some(()) = stop.recv() => "Ctrl-Break",
            Some(()) = close.recv() => "the closing of its window",
            Some(()) = logoff.recv() => "the end of the session",
            Some(()) = shutdown.recv() => "the shutdown of the computer",
            else => return,
        };
        received(name);
    }
}

fn received(name: &str) {
    let listeners = listeners();
    for (_, cancel) in listeners.iter() {
        cancel.cancel(name);
    }
    if listeners.is_empty()
        && let Some(act) = OTHERWISE.get()
    {
        // The front end is in the middle of a computation and cannot ask.
        act(name);
    }
}

/// What is done with the name of a signal while nothing listens for signals.
static OTHERWISE: OnceLock<fn(&str)> = OnceLock::new();

/// Says what a signal does while nothing listens for signals; the first call counts.
pub fn otherwise(act: fn(&str)) {
    let _ = OTHERWISE.set(act);
}

/// Whether the program was started with SIGHUP ignored (`nohup`): it stays so.
#[cfg(unix)]
fn hangup_is_ignored() -> bool {
    use std::io::IsTerminal as _;
    match std::fs::read_to_string("/proc/self/status") {
        Ok(status) => ignored_signals(&status) & 1 != 0,
        // No /proc: `nohup` leaves no terminal on any of the three.
        Err(_) => {
            !std::io::stdin().is_terminal() && !std::io::stdout().is_terminal() && !std::io::stderr().is_terminal()
        }
    }
}

/// The mask `SigIgn` of proc_pid_status(5): bit n − 1 for signal n.
#[cfg(unix)]
fn ignored_signals(status: &str) -> u64 {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or_default()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::FailureKind;

    #[test]
    fn a_signal_does_not_take_the_place_of_a_failure_that_is_not_reported_yet() {
        let listens = |number| listeners().iter().any(|(listener, _)| *listener == number);
        let went_well = OnSignals::listen().unwrap();
        let number = went_well.number;
        went_well.until_reported(Ok(())).unwrap();
        assert!(!listens(number), "the program ends at once");
        let failed = OnSignals::listen().unwrap();
        let number = failed.number;
        let not_at_rest = Failure::instrument("axis.c could not be verified at rest");
        let reported = failed.until_reported(Err::<(), _>(not_at_rest)).unwrap_err();
        assert_eq!((listens(number), reported.kind), (true, FailureKind::Instrument));
    }

    #[test]
    fn the_mask_of_ignored_signals_is_read() {
        let status = "Name:\tisolux\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001001\nSigCgt:\t0\n";
        assert_eq!(ignored_signals(status) & 1, 1, "SIGHUP");
        assert_eq!(ignored_signals(status) >> 12 & 1, 1, "SIGPIPE");
        assert_eq!(ignored_signals(status) >> 1 & 1, 0, "SIGINT");
        assert_eq!(ignored_signals("no such line"), 0);
    }
}
