//! Deadlines in time during which this program ran.
//!
//! A process that was stopped (SIGSTOP), whose computer slept or whose disk held it up finds its deadlines over when it
//! runs again, although nobody waited for the instrument. A timer of a program that runs fires within milliseconds; one
//! that fires later than [`LATE`] shows that it did not run.

use std::pin::pin;
use std::time::Duration;

use tokio::time::{Instant, sleep_until};

/// A timer that fires later than this after its time was not watched.
pub const LATE: Duration = Duration::from_millis(500);

/// Whether this program did not run when `deadline` passed: it is over for longer than a timer needs.
pub fn missed(deadline: Instant) -> bool {
    Instant::now().saturating_duration_since(deadline) > LATE
}

/// What `work` gives until `deadline`, or none. A deadline that passed while this program did not run begins anew, with
/// the whole time that there was for it.
pub async fn until<T>(mut deadline: Instant, work: impl Future<Output = T>) -> Option<T> {
    let patience = deadline.saturating_duration_since(Instant::now());
    let mut work = pin!(work);
    loop {
        tokio::select! {
            biased;
            done = &mut work => return Some(done),
            () = sleep_until(deadline) => {}
        }
        if patience.is_zero() || !missed(deadline) {
            return None;
        }
        deadline = Instant::now() + patience;
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::{advance, sleep};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_deadline_that_passed_while_the_program_did_not_run_begins_anew() {
        let began = Instant::now();
        let deadline = began + Duration::from_secs(15);
        let (outcome, ()) = tokio::join!(until(deadline, sleep(Duration::from_secs(50))), async {
            sleep(Duration::from_secs(2)).await;
            // The process is stopped for 45 s, and goes on.
            advance(Duration::from_secs(45)).await;
        });
        assert_eq!(outcome, Some(()));
        let (outcome, ()) = tokio::join!(
            until(Instant::now() + Duration::from_secs(15), std::future::pending::<()>()),
            advance(Duration::from_secs(45))
        );
        assert_eq!(outcome, None, "and it ends all the same");
        assert_eq!(began.elapsed(), Duration::from_secs(50 + 45 + 15));
    }

    #[tokio::test(start_paused = true)]
    async fn a_deadline_of_a_program_that_runs_is_one() {
        let began = Instant::now();
        let outcome = until(began + Duration::from_secs(15), std::future::pending::<()>()).await;
        assert_eq!((outcome, began.elapsed()), (None, Duration::from_secs(15)));
        let past = until(began, std::future::pending::<()>()).await;
        assert_eq!(past, None, "one that was over before is over");
    }
}
