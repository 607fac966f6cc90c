//! Whether this program ran all the time: a stopped process, a computer that slept, a disk that held everything up.
//!
//! Two clocks show it. The one that deadlines are counted in goes on while a process is stopped: a look at it every
//! `EVERY` that comes late by `LEAST` shows that nothing was done meanwhile. It stands still while the computer
//! sleeps (Linux, macOS): then a clock that counts the sleep is ahead of it.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::time::{Instant, sleep};

/// Between two looks at the clocks.
const EVERY: Duration = Duration::from_millis(100);

/// Less than this disturbs nothing: no deadline of an instrument is shorter.
const LEAST: Duration = Duration::from_millis(800);

/// A sleep of the computer that the clock of deadlines did not count, at least: two clocks are read one after the other,
/// and something may come between.
const LEAST_SUSPENDED: Duration = Duration::from_millis(500);

/// How long the computer has slept since it was started, by a clock that may be another one in a test.
pub type Suspended = Arc<dyn Fn() -> Duration + Send + Sync>;

/// One time in which this program did not run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sleep {
    /// When it ran last.
    pub from: Instant,
    /// When it ran again.
    pub to: Instant,
    /// What passed while the computer slept and is not counted between these two.
    pub suspended: Duration,
}

impl Sleep {
    /// How long it was.
    pub fn length(&self) -> Duration {
        self.to.saturating_duration_since(self.from) + self.suspended
    }
}

/// Watches the clocks; clones share what was seen.
#[derive(Clone, Default)]
pub struct Awake(Option<Arc<Mutex<Watch>>>);

struct Watch {
    looked: Instant,
    suspended: Suspended,
    counted: Duration,
    sleeps: Vec<Sleep>,
    /// How many of them were taken.
    taken: usize,
}

impl Awake {
    /// Watches nothing: virtual time stands still with the program.
    pub fn unwatched() -> Self {
        Self::default()
    }

    /// Watches from now on; [`keep_looking`](Self::keep_looking) must run beside the work.
    pub fn watching(suspended: Suspended) -> Self {
        let counted = suspended();
        Self(Some(Arc::new(Mutex::new(Watch {
            looked: Instant::now(),
            suspended,
            counted,
            sleeps: Vec::new(),
            taken: 0,
        }))))
    }

    /// Looks at the clocks for ever.
    pub async fn keep_looking(&self) {
        if self.0.is_none() {
            std::future::pending::<()>().await;
        }
        loop {
            sleep(EVERY).await;
            self.with(Watch::look);
        }
    }

    /// Whether the program did not run at some time since [`take`](Self::take) was asked last.
    pub fn slept(&self) -> bool {
        self.with(|watch| {
            watch.look();
            watch.taken < watch.sleeps.len()
        })
        .unwrap_or(false)
    }

    /// The times in which the program did not run since this was asked last, as one.
    pub fn take(&self) -> Option<Sleep> {
        self.with(|watch| {
            watch.look();
            let new = watch.sleeps.get(watch.taken..).unwrap_or_default();
            let (first, last) = (new.first()?, new.last()?);
            let sleep = Sleep {
                from: first.from,
                to: last.to,
                suspended: new.iter().map(|sleep| sleep.suspended).sum(),
            };
            watch.taken = watch.sleeps.len();
            Some(sleep)
        })?
    }

    /// What passed before `at` while the computer slept, and is not counted by the clock of `at`.
    pub fn suspended_before(&self, at: Instant) -> Duration {
        self.with(|watch| {
            let before = watch.sleeps.iter().filter(|sleep| sleep.from < at);
            before.map(|sleep| sleep.suspended).sum()
        })
        .unwrap_or_default()
    }

    fn with<T>(&self, ask: impl FnOnce(&mut Watch) -> T) -> Option<T> {
        let watch = self.0.as_ref()?;
        Some(ask(&mut watch.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

impl Watch {
    fn look(&mut self) {
        let (now, suspended) = (Instant::now(), (self.suspended)().saturating_sub(self.counted));
        let late = now.saturating_duration_since(self.looked).saturating_sub(EVERY) >= LEAST;
        let slept = suspended >= LEAST_SUSPENDED;
        if late || slept {
            self.sleeps.push(Sleep {
                from: self.looked,
                to: now,
                suspended: if slept { suspended } else { Duration::ZERO },
            });
        }
        self.looked = now;
        if slept {
            self.counted += suspended;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering};

    use tokio::time::advance;

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_stopped_process_and_a_computer_that_slept_are_noticed_and_taken_once() {
        let seconds = Arc::new(AtomicU64::new(7));
        let clock = seconds.clone();
        let awake = Awake::watching(Arc::new(move || Duration::from_secs(clock.load(Ordering::Relaxed))));
        let began = Instant::now();
        let watch = awake.clone();
        let work = async {
            sleep(Duration::from_mins(10)).await;
            assert!(!awake.slept() && awake.take().is_none(), "long waiting is no sleep");
            advance(Duration::from_secs(45)).await;
            assert!(awake.slept());
            let sleep_of = awake.take().unwrap();
            assert!((sleep_of.length().as_secs_f64() - 45.0).abs() < 0.11, "{sleep_of:?}");
            assert!(!awake.slept(), "taken");
            sleep(Duration::from_secs(1)).await;
            assert_eq!(awake.suspended_before(Instant::now()), Duration::ZERO);
            seconds.fetch_add(3600, Ordering::Relaxed);
            sleep(Duration::from_millis(150)).await;
            let sleep_of = awake.take().unwrap();
            assert_eq!(sleep_of.suspended, Duration::from_hours(1));
            assert_eq!(awake.suspended_before(Instant::now()), Duration::from_hours(1));
            assert_eq!(awake.suspended_before(began), Duration::ZERO);
        };
        tokio::select! {
            () = watch.keep_looking() => unreachable!("it looks for ever"),
            () = work => {}
        }
    }

    #[tokio::test(start_paused = true)]
    async fn what_is_not_watched_never_slept() {
        let awake = Awake::unwatched();
        advance(Duration::from_hours(5)).await;
        assert!(!awake.slept() && awake.take().is_none());
    }
}
