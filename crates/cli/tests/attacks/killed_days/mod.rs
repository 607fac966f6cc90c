//! Days that are killed (SIGKILL) at any moment of any phase, once or several times, and resumed to their end: they
//! give what the undisturbed day of the same room gives.
//!
//! A few are a test. The campaigns, of days at rest and of days in motion, are for a person, each of as many days as
//! `ISOLUX_KILLS` says (200):
//!
//! ```text
//! ISOLUX_KILLS=200 cargo test --release -p isolux --test attacks killed_days -- --ignored --nocapture
//! ```

#![allow(clippy::print_stdout, reason = "the campaign prints what it counts")]

mod day;
mod live;
mod phase;
mod sweeps;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use day::{Bench, Outcome};
use live::Live;
use phase::Phase;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Kills of a day at most.
const MOST_KILLS: u32 = 3;

/// What a seed does to a day: how often it is killed, and in which phase first.
#[derive(Debug, Clone, Copy)]
struct Kills {
    seed: u64,
    first: Phase,
    count: u32,
}

impl Kills {
    fn of(seed: u64, bench: &Bench) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Self {
            seed,
            first: bench.phases[seed as usize % bench.phases.len()],
            // Every third day more than once.
            count: if random.random_range(0..3) == 0 {
                random.random_range(2..=MOST_KILLS)
            } else {
                1
            },
        }
    }

    /// The day of this seed, killed and resumed to its end: exit 0, all files whole, nothing left over, and its numbers
    /// within U of those of the undisturbed day. None where the directions read at rest refuse it.
    fn day(self, bench: &Bench) -> Option<Outcome> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(1);
        let mut killed = Vec::new();
        let mut phase = self.first;
        for _ in 0..self.count {
            let Some(one) = bench.run_and_kill(self.seed, phase, &mut random) else {
                break;
            };
            killed.push(one);
            phase = bench.phases[random.random_range(0..bench.phases.len())];
        }
        let outcome = bench.finish(self.seed, killed)?;
        for (other, (name, value, expanded)) in outcome.numbers.values.iter().zip(bench.undisturbed.values) {
            assert!(
                (other.1 - value).abs() <= expanded,
                "{outcome}: {name} is {}, undisturbed {value} ± {expanded}",
                other.1
            );
        }
        Some(outcome)
    }

    /// The same of a day in motion, with the intensities of its directions: 95 % of them are within U.
    fn day_in_motion(self, bench: &Bench) -> Option<Outcome> {
        let outcome = self.day(bench)?;
        let differences = outcome.numbers.differences(&bench.undisturbed);
        let outside = differences.iter().filter(|share| **share > 1.0).count();
        let largest = differences.iter().copied().fold(0.0, f64::max);
        let count = differences.len();
        let said = format!("{outcome}; {outside} of {count} directions beyond U, at most {largest:.2} U");
        println!("{said}");
        assert!(outside * 20 <= count, "{said}");
        Some(outcome)
    }
}

/// What `work` makes of each number below `count`, two at a time.
fn each<T: Send>(count: u64, work: impl Fn(u64) -> T + Sync) -> Vec<T> {
    each_of(2, count, work)
}

/// What `work` makes of each number below `count`, so many `at_once`.
fn each_of<T: Send>(at_once: usize, count: u64, work: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let (next, made) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..at_once {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= count {
                        break;
                    }
                    let one = work(number);
                    made.lock().unwrap().push(one);
                }
            });
        }
    });
    made.into_inner().unwrap()
}

/// Days of a campaign.
fn requested() -> u64 {
    let requested = std::env::var("ISOLUX_KILLS").ok();
    requested.map_or(200, |count| count.parse().expect("ISOLUX_KILLS is a number"))
}

fn share(consistent: &[bool]) -> String {
    let yes = consistent.iter().filter(|yes| **yes).count();
    format!("{yes} of {} consistent", consistent.len())
}

/// One kill or more in each phase.
pub fn a_killed_day_gives_what_the_undisturbed_day_gives() {
    let bench = Bench::coarse(1);
    let consistent = each(bench.phases.len() as u64, |seed| {
        let outcome = Kills::of(seed, &bench).day(&bench).unwrap();
        println!("{outcome}");
        outcome.numbers.consistent
    });
    // An undisturbed day is not always consistent either; what the campaign compares are the shares.
    let disagree = consistent.iter().filter(|yes| !**yes).count();
    assert!(disagree <= 2, "{}", share(&consistent));
}

/// In motion, at all half-planes of a plan and at those that are chosen.
pub fn a_killed_day_in_motion_sweeps_what_the_undisturbed_day_sweeps() {
    let benches = [false, true].map(|chosen| Bench::in_motion(1, chosen).unwrap());
    each(3, |number| {
        let bench = &benches[number as usize % 2];
        // The directions read at rest refuse one sound day in twenty by design; where a kill falls depends on the
        // computer, and so do the readings of the rest of the day. Another day then takes its place.
        let mut days = (0..4).map(|attempt| number + 10 * attempt);
        let came = days.find_map(|seed| Kills::of(seed, bench).day_in_motion(bench));
        assert!(
            came.is_some(),
            "four days in a row were refused by their directions at rest"
        );
    });
}

/// A scan of a bench of its own, killed within so many seconds from the beginning of its sweeps on: its axes come to
/// rest inside their limits. Whether one moved then.
fn killed_live(seed: u64, seconds: f64) -> bool {
    let after_s = ChaCha8Rng::seed_from_u64(seed).random_range(0.0..seconds);
    Live::new().kill_and_follow(Duration::from_secs_f64(after_s))
}

pub fn axes_whose_program_is_killed_in_a_sweep_come_to_rest_inside_their_limits() {
    // The first sweep with the way to its beginning.
    let moved = each(2, |seed| killed_live(seed, 6.0));
    assert!(moved.contains(&true), "{moved:?}");
}

/// In real time, which costs no computer much: many at once.
pub fn axes_come_to_rest_inside_their_limits_at_as_many_kills_as_asked() {
    let count = requested();
    // All five sweeps and the first directions at rest.
    let moved = each_of(16, count, |seed| killed_live(seed, 60.0));
    let moved = moved.iter().filter(|moved| **moved).count();
    println!("{count} kills, {moved} of them while an axis moved: all axes at rest inside their limits");
}

/// Each killed day has a room of its own, or one room would decide the share.
pub fn as_many_killed_days_as_asked_give_what_undisturbed_days_give() {
    let count = requested();
    let killed = each(count, |seed| {
        let bench = Bench::whole(1 + seed);
        let outcome = Kills::of(seed, &bench).day(&bench).unwrap();
        println!("{outcome}, undisturbed {}", bench.undisturbed.consistent);
        (outcome.numbers.consistent, bench.undisturbed.consistent)
    });
    let others = each(count, |number| Bench::whole(1 + count + number).undisturbed.consistent);
    let (killed, same): (Vec<bool>, Vec<bool>) = killed.into_iter().unzip();
    println!("killed days: {}", share(&killed));
    println!("undisturbed days of the same rooms: {}", share(&same));
    println!("undisturbed days of other rooms: {}", share(&others));
}

/// The same in motion, every other day at half-planes that are chosen.
pub fn as_many_killed_days_in_motion_as_asked_give_what_undisturbed_days_give() {
    let days = each(requested(), |seed| {
        let bench = Bench::in_motion(1 + seed, seed % 2 == 1)?;
        let outcome = Kills::of(seed, &bench).day_in_motion(&bench)?;
        Some((outcome.killed.len(), outcome.repeated))
    });
    let (count, killed): (usize, Vec<_>) = (days.len(), days.into_iter().flatten().collect());
    let kills: usize = killed.iter().map(|day| day.0).sum();
    let repeated: usize = killed.iter().map(|day| day.1).sum();
    let refused = count - killed.len();
    println!(
        "{} days in motion, {kills} kills, {repeated} whole sweeps made again; {refused} days refused by \
         directions at rest",
        killed.len()
    );
    // One in twenty by design, of two days each.
    assert!(refused * 5 <= count, "{refused} of {count}");
}
