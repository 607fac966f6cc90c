//! Somebody sets the computer's clock during a run: the run's own clock goes on as it did, and the record says so.

use isolux_record::Event;
use jiff::Timestamp;
use tokio::time::Instant;

use super::session::Session;
use crate::error::ScanError;

/// A step in seconds that is recorded. Clocks that are kept right by a network drift and are corrected by less.
const LEAST_STEP_S: f64 = 2.0;

impl Session<'_> {
    /// Looks whether the computer's clock was set since this was asked last.
    pub fn look_at_wall_clock(&mut self) -> Result<(), ScanError> {
        let Some(wall_clock) = self.engine.wall_clock else {
            return Ok(());
        };
        let Ok(by_run) = self.clock.utc(Instant::now()).parse::<Timestamp>() else {
            return Ok(());
        };
        let ahead_s = wall_clock().duration_since(by_run).as_secs_f64();
        let step_s = ahead_s - self.wall_ahead_s;
        if step_s.abs() < LEAST_STEP_S {
            return Ok(());
        }
        self.wall_ahead_s = ahead_s;
        self.event(Event::ClockSet { step_s, ahead_s })?;
        self.note(&format!(
            "the clock of the computer was set by {step_s:+.0} s: the times of this run go on as they were"
        ))
    }
}

#[cfg(test)]
mod tests {
    use isolux_record::run::Run;
    use jiff::SignedDuration;

    use super::*;
    use crate::awake::Awake;
    use crate::cancel::Cancel;
    use crate::engine::Engine;
    use crate::engine::tests::DAY;
    use crate::pause::Pause;
    use crate::testing::{bench, plan, run_dir, station, unobserved};

    /// The rows of a day during which the computer's clock is set by `step_s` after 1840 s, and its events.
    async fn day(step_s: i64) -> (Vec<Option<f64>>, String) {
        let (mut devices, _room) = bench();
        let plan = plan(DAY);
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        let (station, pause, awake) = (station(), Pause::new(), Awake::unwatched());
        let engine = unobserved(&station, &pause, &awake);
        let (now_utc, began) = (engine.now_utc, Instant::now());
        let wall_clock = move || {
            let passed = began.elapsed();
            let step = if passed.as_secs() < 1840 { 0 } else { step_s };
            now_utc + SignedDuration::try_from(passed).unwrap() + SignedDuration::from_secs(step)
        };
        Engine {
            wall_clock: Some(&wall_clock),
            ..engine
        }
        .run(&mut devices, &plan, &mut run, &Cancel::new(), None)
        .await
        .unwrap();
        drop(run);
        let times = Run::read(&path).unwrap().readings.rows;
        let events = std::fs::read_to_string(path.join("events.jsonl")).unwrap();
        (times.iter().map(|row| row.time_s).collect(), events)
    }

    #[tokio::test(start_paused = true)]
    async fn a_clock_that_is_set_by_an_hour_changes_no_time_of_the_record() {
        let (undisturbed, events) = day(0).await;
        assert!(!events.contains("clock_set"), "{events}");
        for step_s in [3600, -3600] {
            let (times, events) = day(step_s).await;
            assert_eq!(times, undisturbed);
            assert_eq!(events.matches("\"clock_set\"").count(), 1, "{events}");
            assert!(events.contains(&format!("set by {step_s:+} s")), "{events}");
            let utc = |line: &str| {
                let event: serde_json::Value = serde_json::from_str(line).unwrap();
                event["time_utc"].as_str().unwrap().parse::<Timestamp>().unwrap()
            };
            assert!(events.lines().map(utc).is_sorted(), "{events}");
        }
    }
}
