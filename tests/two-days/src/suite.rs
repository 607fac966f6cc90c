//! Which cases there are, which of them are wanted, and how they are played on all cores.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use camino::Utf8Path;

use crate::case::{Order, Outcome, play};
use crate::days::{DayError, Days};
use crate::faults::{self, Kind};
use crate::lamps::Lamp;
use crate::plans::Grid;

/// Strengths above noise and the model's own uncertainty, in σ.
pub const SIGMAS: [f64; 3] = [3.0, 10.0, 30.0];
/// Lamps of each kind, and with them first days.
pub const SEEDS: u64 = 5;
/// Second days without a fault.
pub const FAULTLESS: u64 = 200;

/// Which cases are wanted; what is none is any.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Readings or maps.
    pub kind: Option<Kind>,
    /// Labels of faults; `none` is a day without one.
    pub faults: Vec<String>,
    /// Strengths.
    pub sigma: Option<f64>,
    /// Numbers of lamps.
    pub seed: Option<u64>,
    /// Every case is played on this grid.
    pub grid: Option<Grid>,
    /// Every case is played with this lamp, or where that cannot show the fault with another.
    pub lamp: Option<Lamp>,
    /// Of what is left this share, spread evenly.
    pub share: Option<f64>,
}

/// The orders that are wanted: every fault at every strength with every seed, grids and lamps taking turns, then days
/// without a fault.
pub fn orders(wanted: &Wanted) -> Vec<Order> {
    let mut all = Vec::new();
    for kind in [Kind::Readings, Kind::Maps] {
        for (number, fault) in faults::of(kind).enumerate() {
            for (step, sigma) in SIGMAS.into_iter().enumerate() {
                for seed in 1..=SEEDS {
                    let turn = 4 * number + 5 * step + seed as usize;
                    all.push(Order {
                        kind,
                        fault: Some((fault, sigma)),
                        lamp: Lamp::ALL[turn / 3 % 3],
                        grid: Grid::ALL[turn % 3],
                        seed,
                        day: 1 + all.len() as u64,
                    });
                }
            }
        }
    }
    for k in 0..FAULTLESS {
        all.push(Order {
            kind: if k % 3 == 2 { Kind::Maps } else { Kind::Readings },
            fault: None,
            lamp: Lamp::ALL[(k / 3 % 3) as usize],
            grid: Grid::ALL[(k / 9 % 3) as usize],
            seed: 1 + k / 27 % SEEDS,
            day: 1 + all.len() as u64,
        });
    }
    all.retain(|order| {
        let label = order.fault.map_or("none", |(fault, _)| fault.label);
        wanted.kind.is_none_or(|kind| kind == order.kind)
            && (wanted.faults.is_empty() || wanted.faults.iter().any(|name| name == label))
            && wanted
                .sigma
                .is_none_or(|sigma| order.fault.is_some_and(|(_, of)| of == sigma))
            && wanted.seed.is_none_or(|seed| seed == order.seed)
    });
    for order in &mut all {
        order.lamp = wanted.lamp.unwrap_or(order.lamp);
        order.grid = wanted.grid.unwrap_or(order.grid);
    }
    let share = wanted.share.unwrap_or(1.0);
    // Steps of the golden section spread any share evenly over faults, strengths and seeds.
    let kept = |number: usize| (number as f64 * 0.618_033_988_749_895).fract() < share;
    let numbered = all.into_iter().enumerate();
    numbered
        .filter(|(number, _)| kept(*number))
        .map(|(_, order)| order)
        .collect()
}

/// Plays orders on `threads` threads; `done` is called with each as it ends. Their files lie below `root`, one folder
/// each, and stay there where they are to be `kept`.
pub fn play_all(
    orders: &[Order],
    root: &Utf8Path,
    threads: usize,
    kept: bool,
    done: impl Fn(&Order, &Utf8Path, &Result<Outcome, DayError>) + Sync,
) -> Vec<(Order, Result<Outcome, DayError>)> {
    let days = Days::below(&root.join("days"));
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::with_capacity(orders.len()));
    // Not a pool that takes up another case while one waits for a day: that day might be its own.
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(order) = orders.get(number) else { break };
                    let folder = root.join(format!("case-{}", order.day));
                    let outcome = play(&days, order, &folder);
                    done(order, &folder, &outcome);
                    if !kept {
                        // A folder that was never made is gone already.
                        let _ = std::fs::remove_dir_all(&folder);
                    }
                    let mut all = outcomes.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    all.push((number, order.clone(), outcome));
                }
            });
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    outcomes.sort_by_key(|(number, ..)| *number);
    outcomes
        .into_iter()
        .map(|(_, order, outcome)| (order, outcome))
        .collect()
}
