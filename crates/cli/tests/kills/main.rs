//! Days that are killed (SIGKILL) at any moment of any phase, once or several times, and resumed to their end: they
//! give what the undisturbed day of the same room gives.
//!
//! A few are a test. The campaign is for a person, of as many days as `ISOLUX_KILLS` says (200):
//!
//! ```text
//! ISOLUX_KILLS=200 cargo test --release -p isolux --test kills -- --ignored --nocapture
//! ```

#![cfg(unix)]
#![allow(clippy::print_stdout, reason = "the campaign prints what it counts")]

mod day;
#[path = "../folder/mod.rs"]
mod folder;
mod phase;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use day::{Bench, Outcome};
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
    fn of(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Self {
            seed,
            first: Phase::ALL[seed as usize % Phase::ALL.len()],
            // Every third day more than once.
            count: if random.random_range(0..3) == 0 {
                random.random_range(2..=MOST_KILLS)
            } else {
                1
            },
        }
    }

    /// The day of this seed, killed and resumed to its end: exit 0, all files whole, nothing left over, and its numbers
    /// within U of those of the undisturbed day.
    fn day(self, bench: &Bench) -> Outcome {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(1);
        let mut killed = Vec::new();
        let mut phase = self.first;
        for _ in 0..self.count {
            if !bench.run_and_kill(self.seed, phase, &mut random) {
                break;
            }
            killed.push(phase);
            phase = Phase::ALL[random.random_range(0..Phase::ALL.len())];
        }
        let outcome = bench.finish(self.seed, &killed);
        for (other, (name, value, expanded)) in outcome.numbers.values.iter().zip(bench.undisturbed.values) {
            assert!(
                (other.1 - value).abs() <= expanded,
                "{outcome}: {name} is {}, undisturbed {value} ± {expanded}",
                other.1
            );
        }
        outcome
    }
}

/// What `work` makes of each number below `count`, two at a time.
fn each<T: Send>(count: u64, work: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let (next, made) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
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

fn share(consistent: &[bool]) -> String {
    let yes = consistent.iter().filter(|yes| **yes).count();
    format!("{yes} of {} consistent", consistent.len())
}

/// One kill or more in each phase.
#[test]
fn a_killed_day_gives_what_the_undisturbed_day_gives() {
    let bench = Bench::coarse(1);
    let consistent = each(Phase::ALL.len() as u64, |seed| {
        let outcome = Kills::of(seed).day(&bench);
        println!("{outcome}");
        outcome.numbers.consistent
    });
    // An undisturbed day is not always consistent either; what the campaign compares are the shares.
    let disagree = consistent.iter().filter(|yes| !**yes).count();
    assert!(disagree <= 2, "{}", share(&consistent));
}

/// Each killed day has a room of its own, or one room would decide the share.
#[test]
#[ignore = "hours: a campaign for a person"]
fn as_many_killed_days_as_asked_give_what_undisturbed_days_give() {
    let requested = std::env::var("ISOLUX_KILLS").ok();
    let count: u64 = requested.map_or(200, |count| count.parse().expect("ISOLUX_KILLS is a number"));
    let killed = each(count, |seed| {
        let bench = Bench::whole(1 + seed);
        let outcome = Kills::of(seed).day(&bench);
        println!("{outcome}, undisturbed {}", bench.undisturbed.consistent);
        (outcome.numbers.consistent, bench.undisturbed.consistent)
    });
    let others = each(count, |number| Bench::whole(1 + count + number).undisturbed.consistent);
    let (killed, same): (Vec<bool>, Vec<bool>) = killed.into_iter().unzip();
    println!("killed days: {}", share(&killed));
    println!("undisturbed days of the same rooms: {}", share(&same));
    println!("undisturbed days of other rooms: {}", share(&others));
}
