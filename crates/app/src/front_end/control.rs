//! What a front end may ask of a scan while it runs, and how fast a virtual bench runs.

use std::future::Future;
use std::time::{Duration, Instant};

pub use isolux_scan::{Cancel, Pause};

/// Asks a scan to pause, to go on and to end; may be cloned and used from any thread.
#[derive(Debug, Clone, Default)]
pub struct Control {
    /// Pauses where nothing is half done; the lamp stays on.
    pub pause: Pause,
    /// Ends the scan: the axes are stopped and verified at rest, what was read stays.
    pub cancel: Cancel,
    /// How virtual time runs; real time is what it is.
    pub pace: Pace,
}

/// How virtual time runs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Pace {
    /// As fast as the machine can, hours in seconds; nobody is there to pause it.
    #[default]
    Free,
    /// As fast as the machine can, and at the pace of real time during a pause.
    Attended,
    /// So many times faster than real time.
    Times(f64),
}

/// How often a paced clock is compared with real time.
const TICK_S: f64 = 0.02;

impl Control {
    /// Carries out `work` on a runtime whose clock is virtual, at this pace. The clock itself stays exact: between two
    /// timers this waits in real time, in which nothing virtual happens.
    pub(crate) async fn paced<T>(&self, work: impl Future<Output = T>) -> T {
        tokio::select! {
            biased;
            outcome = work => outcome,
            () = self.keep_pace() => unreachable!("the pace is kept for ever"),
        }
    }

    async fn keep_pace(&self) {
        if self.pace == Pace::Free {
            std::future::pending::<()>().await;
        }
        loop {
            let times = match self.pace {
                Pace::Times(times) => Some(times),
                _ if self.pause.requested().is_some() => Some(1.0),
                _ => None,
            };
            let began = Instant::now();
            tokio::time::sleep(Duration::from_secs_f64(TICK_S * times.unwrap_or(50.0))).await;
            if times.is_some() {
                let left = Duration::from_secs_f64(TICK_S).saturating_sub(began.elapsed());
                // Blocks the whole runtime, which holds the virtual bench and its drivers alone.
                std::thread::sleep(left);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_paced_clock_is_exact_and_not_faster_than_asked() {
        for (pace, least) in [(Pace::Times(1000.0), 100), (Pace::Free, 0), (Pace::Attended, 0)] {
            let control = Control {
                pace,
                ..Control::default()
            };
            let began = Instant::now();
            let virtual_s = crate::instruments::session::run(true, async {
                let began = tokio::time::Instant::now();
                control.paced(tokio::time::sleep(Duration::from_secs(110))).await;
                Ok(began.elapsed().as_secs_f64())
            });
            assert_eq!(virtual_s.unwrap(), 110.0, "{pace:?}");
            assert!(began.elapsed() >= Duration::from_millis(least), "{pace:?}");
        }
    }
}
