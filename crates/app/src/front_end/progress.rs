//! What a long use case tells its front end while it works.

use std::time::Instant;

use jiff::{Span, Timestamp};

use crate::front_end::live::{Live, Outline};

/// One thing that happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Event<'a> {
    /// A step of the day began ("warm up", "scan", …); `total` counts its units of work where it is known.
    Began {
        /// Name of the step.
        step: &'a str,
        /// Units of work in it.
        total: Option<u64>,
    },
    /// The step stands at `done` units, with a short word on what is being done.
    At {
        /// Units done.
        done: u64,
        /// What is being done now.
        what: &'a str,
    },
    /// The step ended with this sentence.
    Ended(&'a str),
    /// Something worth a line that is no step: a warning, a correction that does not apply.
    Note(&'a str),
    /// A scan begins.
    Outline(&'a Outline),
    /// An event of a scan; what a terminal should say of it follows in the words above.
    Live(&'a Live),
}

/// Receives the events of a use case; called from the thread that works.
pub trait Progress {
    /// Takes one event. Must not block for long.
    fn event(&self, event: Event<'_>);
}

/// Discards every event: tests and scripts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn event(&self, _: Event<'_>) {}
}

/// `1 h 02 min`, `3 min 20 s`, `12 s`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, min, s) => format!("{min} min {s:02} s"),
        (h, min, _) => format!("{h} h {min:02} min"),
    }
}

/// `now` and `left_s` later, the end of what is being done.
pub(crate) fn ends(now: Timestamp, left_s: f64) -> Timestamp {
    let span = Span::new().milliseconds((left_s * 1000.0) as i64);
    now.checked_add(span).unwrap_or(now)
}

/// `3 min 20 s left, ends 14:05 UTC`.
pub(crate) fn left_words(left_s: f64, now: Timestamp) -> String {
    let ends = ends(now, left_s).to_string();
    format!("{} left, ends {} UTC", duration(left_s), ends.get(11..16).unwrap_or(""))
}

/// The pace of equal pieces of work.
#[derive(Debug)]
pub(crate) struct Pace {
    began: Instant,
    total: usize,
}

impl Pace {
    /// Of `total` pieces, the first of which begins now.
    pub fn of(total: usize) -> Self {
        let began = Instant::now();
        Self { began, total }
    }

    /// What is left after `done` of them, in words that follow `what`; nothing before the first is done.
    pub fn words(&self, what: &str, done: usize) -> String {
        if done == 0 {
            return what.to_owned();
        }
        let each_s = self.began.elapsed().as_secs_f64() / done as f64;
        let left_s = each_s * self.total.saturating_sub(done) as f64;
        format!("{what}; {}", left_words(left_s, Timestamp::now()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_said_with_the_time_of_its_end() {
        let now = "2026-01-01T23:59:30Z".parse().unwrap();
        assert_eq!(left_words(200.0, now), "3 min 20 s left, ends 00:02 UTC");
        let pace = Pace::of(4);
        assert_eq!(pace.words("solving", 0), "solving");
        assert!(pace.words("solving", 4).starts_with("solving; 0 s left, ends "));
    }
}
