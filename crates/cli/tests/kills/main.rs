//! Days that are killed (SIGKILL) at any moment of any phase, once or several times, and resumed to their end: they give
//! what the undisturbed day of the same room gives.
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

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use day::{Bench, Numbers, Outcome};
use phase::Phase;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Kills of a day at most.
const MOST_KILLS: u32 = 3;

/// What a seed does to a day: how often it is killed, and in which phase first.
#[derive(Debug, Clone, Copy)]
struct Kills {
    seed: u64,
    room: u64,
    first: Phase,
    count: u32,
}

impl Kills {
    fn of(seed: u64, rooms: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Self {
            seed,
            room: 1 + seed % rooms,
            first: Phase::ALL[(seed / rooms) as usize % Phase::ALL.len()],
            // Every third day more than once.
            count: if random.random_range(0..3) == 0 {
                random.random_range(2..=MOST_KILLS)
            } else {
                1
            },
        }
    }

    /// The day of this seed, killed and resumed to its end.
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
        bench.finish(self.seed, &killed)
    }
}

/// The days of `kills`, two at a time.
fn all(benches: &[Arc<Bench>], kills: &[Kills]) -> Vec<Outcome> {
    let next = AtomicU64::new(0);
    let outcomes = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(one) = kills.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
                    let outcome = one.day(&benches[one.room as usize - 1]);
                    println!("{outcome}");
                    outcomes.lock().unwrap().push(outcome);
                }
            });
        }
    });
    outcomes.into_inner().unwrap()
}

/// What must hold of every single day.
fn assert_each(outcomes: &[Outcome], benches: &[Arc<Bench>], kills: &[Kills]) {
    for outcome in outcomes {
        let room = kills.iter().find(|one| one.seed == outcome.seed).unwrap().room;
        let Numbers { values, .. } = &benches[room as usize - 1].undisturbed;
        for (name, value, expanded) in values {
            let (_, found, _) = outcome.numbers.values.iter().find(|(other, ..)| other == name).unwrap();
            assert!(
                (found - value).abs() <= *expanded,
                "{outcome}: {name} is {found}, undisturbed {value} ± {expanded}"
            );
        }
    }
}

/// One kill in each phase.
#[test]
fn a_killed_day_gives_what_the_undisturbed_day_gives() {
    let benches = [Arc::new(Bench::coarse(1))];
    let kills: Vec<Kills> = (0..Phase::ALL.len() as u64).map(|seed| Kills::of(seed, 1)).collect();
    let outcomes = all(&benches, &kills);
    assert_each(&outcomes, &benches, &kills);
    // An undisturbed day is not always consistent either; what the campaign compares are the shares.
    let consistent = outcomes.iter().filter(|outcome| outcome.numbers.consistent).count();
    assert!(consistent + 2 >= outcomes.len(), "{consistent} of {}", outcomes.len());
}

#[test]
#[ignore = "hours: a campaign for a person"]
fn as_many_killed_days_as_asked_give_what_undisturbed_days_give() {
    let asked = std::env::var("ISOLUX_KILLS").ok();
    let count: u64 = asked.map_or(200, |count| count.parse().expect("ISOLUX_KILLS is a number"));
    let rooms = count.div_ceil(10);
    let benches: Vec<Arc<Bench>> = (1..=rooms).map(|room| Arc::new(Bench::whole(room))).collect();
    let kills: Vec<Kills> = (0..count).map(|seed| Kills::of(seed, rooms)).collect();
    let outcomes = all(&benches, &kills);
    let consistent = outcomes.iter().filter(|outcome| outcome.numbers.consistent).count();
    println!("killed days: {consistent} of {} consistent", outcomes.len());
    // Of other rooms than those of the killed days.
    let next = AtomicU64::new(rooms + 1);
    let undisturbed = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let room = next.fetch_add(1, Ordering::Relaxed);
                    if room > rooms + count {
                        break;
                    }
                    let consistent = Bench::whole(room).undisturbed.consistent;
                    println!("undisturbed room {room}: consistent {consistent}");
                    undisturbed.fetch_add(u64::from(consistent), Ordering::Relaxed);
                }
            });
        }
    });
    println!("undisturbed days: {} of {count} consistent", undisturbed.into_inner());
    assert_each(&outcomes, &benches, &kills);
}
