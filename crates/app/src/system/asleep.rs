//! How long the computer has slept, by the two clocks of the system: one counts the sleep and one does not.

use std::sync::Arc;
use std::time::Duration;

use isolux_scan::awake::Suspended;

/// A clock of the time that the computer has slept since it was started. Where deadlines count that time themselves
/// (Windows) it stands still.
pub fn clock() -> Suspended {
    Arc::new(slept)
}

/// CLOCK_BOOTTIME counts while the computer is suspended, CLOCK_MONOTONIC does not, and `Instant` is that one.
#[cfg(any(target_os = "linux", target_os = "android"))]
fn slept() -> Duration {
    use rustix::time::{ClockId, Timespec, clock_gettime};
    let seconds = |time: Timespec| Duration::try_from(time).unwrap_or_default();
    // The one that counts is read first: what comes between the two makes the difference smaller, never larger.
    let passed = seconds(clock_gettime(ClockId::Boottime));
    passed.saturating_sub(seconds(clock_gettime(ClockId::Monotonic)))
}

/// CLOCK_MONOTONIC counts while the computer is asleep, and `Instant` (CLOCK_UPTIME_RAW) does not.
#[cfg(target_vendor = "apple")]
fn slept() -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;

    use rustix::time::{ClockId, Timespec, clock_gettime};
    static BEGAN: OnceLock<(Instant, Duration)> = OnceLock::new();
    let seconds = |time: Timespec| Duration::try_from(time).unwrap_or_default();
    let passed = seconds(clock_gettime(ClockId::Monotonic));
    let (began, at) = *BEGAN.get_or_init(|| (Instant::now(), passed));
    passed.saturating_sub(at).saturating_sub(began.elapsed())
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn slept() -> Duration {
    Duration::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_computer_that_is_awake_does_not_sleep() {
        let clock = clock();
        let before = clock();
        std::thread::sleep(Duration::from_millis(20));
        // Two clocks are read one after the other.
        assert!(clock().abs_diff(before) < Duration::from_millis(10));
    }
}
